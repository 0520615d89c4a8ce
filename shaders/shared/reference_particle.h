// The noisy reference particle inside the unit sphere: a smooth fall-off modulated by billows. One for the whole sky;
// every particle turns it its own way.
//
// Its finest structure is what the optical depth table resolves: billows 0.56 radii apart, some six vertices of the
// table, and no kinks (docs/tables.md: what finer ones cost). What is finer belongs to the shading's detail noise
// (cloud_shade.glsl), which no table has to carry.
#ifndef NEPHELE_SHARED_REFERENCE_PARTICLE_H
#define NEPHELE_SHARED_REFERENCE_PARTICLE_H

#include "noise.h"

NEPHELE_SHARED_BEGIN

// Density above which a point counts as cloud matter.
NEPHELE_CONST(float, kFirstMatterDensity, 0.04f);

NEPHELE_CONST(float, kBillowsPerRadius, 1.8f);
NEPHELE_CONST(float, kBillowContrast, 3.0f);
NEPHELE_CONST(float, kReferenceThickness, 4.0f);

// Relative extinction in [0, 1] at p, 0 outside the unit sphere, for billows of another size.
NEPHELE_FN float billowy_density(vec3 p, float billows_per_radius, uint seed) {
  float q = 1.0f - dot(p, p);
  if (q <= 0.0f) return 0.0f;
  float billows = billow_noise3(billows_per_radius * p, uvec3(0u), noise_seed(seed, 16)) - kBillowMean;
  return 1.0f - exp(-kReferenceThickness * q * q * exp(kBillowContrast * billows));
}

NEPHELE_FN float reference_particle_density(vec3 p, uint seed) { return billowy_density(p, kBillowsPerRadius, seed); }

NEPHELE_SHARED_END

#endif
