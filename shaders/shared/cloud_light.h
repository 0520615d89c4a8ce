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

NEPHELE_CONST(int, kDiffuseOctaves, 5);
NEPHELE_CONST(float, kOctaveAttenuation, 0.5f);  // optical depth of each further octave
NEPHELE_CONST(float, kOctaveAsymmetry, 0.5f);    // g of each further octave
NEPHELE_CONST(float, kOctaveWeight, 0.62f);      // share of each further octave
NEPHELE_CONST(float, kOctaveGain, 1.0f);

// Neighbouring particles overlap: the homogeneous sphere that stands in for one is this much thicker than it alone.
NEPHELE_CONST(float, kNeighbourhood, 4.0f);

// Light that reaches a particle deep inside also leaves the cloud sideways, which a layer's transmission knows nothing
// of: its depth counts this many times.
NEPHELE_CONST(float, kBeamSpread, 3.5f);

// Sunlight scattered at least twice on its way through neighbours of optical depth tau, per unit irradiance, per sr.
NEPHELE_FN float diffuse_octaves(float mu, float g, float tau) {
  float sum = 0.0f;
  float weight = kOctaveGain;
  float depth = tau;
  float asymmetry = g;
  for (int i = 0; i < kDiffuseOctaves; ++i) {
    weight *= kOctaveWeight;
    depth *= kOctaveAttenuation;
    asymmetry *= kOctaveAsymmetry;
    sum += weight * phase_henyey_greenstein(mu, asymmetry) * exp(-depth);
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
