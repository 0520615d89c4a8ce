// The source radiance of one particle's segment ([Yusov14] 4.4, extended): what an infinitely thick piece of this
// medium would show, to be multiplied by the segment's opacity.
//
//   sun, once scattered      phase * S / opacity * exp(-tau)     exact in the homogeneous sphere
//   sun, scattered again     M(table) / opacity * exp(-tau')     light exchanged inside the particle
//   sun, scattered forward   a wider phase * (exp(-tau') - exp(-tau))  still in the beam's direction, more or less
//   sun, diffuse             two-stream light of the cloud around, by its thickness and the place in it
//   sky and ground           mean radiance from above and below, mixed by the depth of cloud above and below
//
// tau is the optical depth towards the sun, tau' = (1 - g) tau what it counts by similarity once forward scattering is
// taken for none. Deviates from the paper: it scales tau by xi = 0.05 for everything and has the first two terms; here
// single scattering keeps the true depth, and what the rest of the cloud contributes depends on how much of it there is, so
// that thin turrets and edges stay dark seen from the sun's side.
#ifndef NEPHELE_SHARED_CLOUD_LIGHT_H
#define NEPHELE_SHARED_CLOUD_LIGHT_H

#include "phase.h"
#include "prelude.h"

NEPHELE_SHARED_BEGIN

// What the terms weigh: fitted to path-traced images with the sun alone (docs/accuracy.md), where the fit of single
// scattering came out as 1 by itself. The terms overlap: orders two and three are in each.
NEPHELE_CONST(float, kAgainShare, 0.6f);
NEPHELE_CONST(float, kForwardShare, 1.15f);
NEPHELE_CONST(float, kDiffuseShare, 0.75f);

NEPHELE_CONST(float, kForwardAsymmetry, 0.5f);   // of the phase function's
NEPHELE_CONST(float, kTurnsPerDepth, 3.0f);      // scatterings that turn diffuse light, per optical depth of the cloud

NEPHELE_CONST(float, kMeanChord, 4.0f / 3.0f);  // of a sphere, over its radius

// Depth towards the sun through other particles where it differs by `change` from that at a particle's centre: linear
// within limits, as four samples know it.
NEPHELE_FN float linear_depth(float at_center, float change) { return clamp(at_center + change, 0.1f * at_center, 4.0f * at_center); }

// Share of sunlight scattered forward alone on its way through optical depth tau: what similarity leaves in the beam
// without what is unscattered.
NEPHELE_FN float forward_share(float tau, float g) { return max(exp(-(1.0f - g) * tau) - exp(-tau), 0.0f); }

// Mean radiance of multiply scattered light in a slab lit along its normal, times 4 pi per unit irradiance: at optical
// depth `depth` of `total`, conservative scattering, Eddington's approximation with similarity-scaled depths and Marshak's
// boundary (no light from without). 0 in a slab of no depth, 2 on top of an endless one, 5 deep in it.
NEPHELE_FN float slab_light(float depth, float total, float g) {
  float t = (1.0f - g) * depth;
  float all = (1.0f - g) * total;
  float j = 5.0f - 3.0f * exp(-t) - (5.0f - exp(-all)) * (t + 2.0f / 3.0f) / (all + 4.0f / 3.0f);
  return max(j, 0.0f);
}

// Share of diffuse light that crosses a layer of optical depth tau of a non-absorbing medium: the two-stream result.
NEPHELE_FN float diffuse_transmission(float tau, float g) { return 1.0f / (1.0f + 0.75f * (1.0f - g) * max(tau, 0.0f)); }

// Sunlight that the cloud around sends to a place, per unit irradiance, per sr. beam: optical depth towards the sun
// through everything; near and total: of the cloud around, towards the sun and through and through.
NEPHELE_FN float light_from_around(float mu, float g, float beam, float near, float total) {
  float forward = phase_henyey_greenstein(mu, kForwardAsymmetry * g) * forward_share(beam, g);
  // The thinner the cloud, the fewer turns the light in it has made, and the more of it still goes on as it came.
  float asymmetry = pow(max(g, 0.0f), 1.0f + kTurnsPerDepth * total);
  float diffuse = phase_henyey_greenstein(mu, asymmetry) * slab_light(min(near, total), total, g);
  return kForwardShare * forward + kDiffuseShare * diffuse * diffuse_transmission(beam - near, g);
}

// The ground under a cloud field lies partly in its shadow: what it sends up is reduced by this share of the coverage.
NEPHELE_CONST(float, kGroundShadow, 0.7f);

// Share of the ambient light that comes from above, for cloud of optical depths tau_up above and tau_down below. Above
// and below sum to 1, so a uniform environment shows the cloud in its own radiance (white furnace).
NEPHELE_FN float ambient_share_above(float tau_up, float tau_down, float g) {
  return 0.5f + 0.5f * (diffuse_transmission(tau_up, g) - diffuse_transmission(tau_down, g));
}

NEPHELE_SHARED_END

#endif
