// The source radiance of one particle's segment ([Yusov14] 4.4, extended): what an infinitely thick piece of this
// medium would show, to be multiplied by the segment's opacity.
//
//   sun, once scattered      phase * S / opacity * exp(-tau)            exact in the homogeneous sphere
//   sun, scattered again     M(table) / opacity * diffuse(tau)          light exchanged inside the particle
//   sun, from other clouds   octaves of widened phase and weaker depth  light diffused through the neighbours
//   sky and ground           mean radiance from above and below, mixed by the depth of cloud above and below
//
// tau is the optical depth towards the sun through the *other* particles, varying linearly inside the particle.
// Deviates from the paper: it scales tau by xi = 0.05 for everything; here single scattering keeps the true depth, and
// the slower decay of multiply scattered light is spread over octaves.
#ifndef NEPHELE_SHARED_CLOUD_LIGHT_H
#define NEPHELE_SHARED_CLOUD_LIGHT_H

#include "phase.h"
#include "prelude.h"

NEPHELE_SHARED_BEGIN

// Octaves after Wrenninge et al., Art-directable multiple volumetric scattering (2013): octave k = 1 .. 5 sees 0.5^k of
// the optical depth and of the asymmetry, and weighs 0.62^k.
NEPHELE_CONST(int, kDiffuseOctaves, 5);
NEPHELE_CONST(float, kOctaveWeight, 0.62f);
NEPHELE_CONST(float, kLastOctaveWeight, 0.0916132832f);  // 0.62^5
NEPHELE_CONST(float, kLastOctaveShare, 0.03125f);        // 0.5^5

// Neighbouring particles overlap: the homogeneous sphere that stands in for one is this much thicker than it alone.
NEPHELE_CONST(float, kNeighbourhood, 4.0f);

// Light that reaches a particle deep inside also leaves the cloud sideways, which a layer's transmission knows nothing
// of: its depth counts this many times.
NEPHELE_CONST(float, kBeamSpread, 3.5f);

// Sunlight scattered at least twice on its way through neighbours of optical depth tau, per unit irradiance, per sr.
// From the last octave up, so that one exponential, squared again and again, serves all.
NEPHELE_FN float diffuse_octaves(float mu, float g, float tau) {
  float sum = 0.0f;
  float weight = kLastOctaveWeight;
  float asymmetry = g * kLastOctaveShare;
  float transmittance = exp(-tau * kLastOctaveShare);
  for (int i = 0; i < kDiffuseOctaves; ++i) {
    sum += weight * phase_henyey_greenstein(mu, asymmetry) * transmittance;
    weight *= 1.0f / kOctaveWeight;
    asymmetry *= 2.0f;
    transmittance *= transmittance;
  }
  return sum;
}

// Share of diffuse light that crosses a layer of optical depth tau of a non-absorbing medium: the two-stream result.
NEPHELE_FN float diffuse_transmission(float tau, float g) { return 1.0f / (1.0f + 0.75f * (1.0f - g) * max(tau, 0.0f)); }

// The ground under a cloud field lies partly in its shadow: what it sends up is reduced by this share of the coverage.
NEPHELE_CONST(float, kGroundShadow, 0.7f);

// Share of the ambient light that comes from above, for cloud of optical depths tau_up above and tau_down below. Above
// and below sum to 1, so a uniform environment shows the cloud in its own radiance (white furnace).
NEPHELE_FN float ambient_share_above(float tau_up, float tau_down, float g) {
  return 0.5f + 0.5f * (diffuse_transmission(tau_up, g) - diffuse_transmission(tau_down, g));
}

NEPHELE_SHARED_END

#endif
