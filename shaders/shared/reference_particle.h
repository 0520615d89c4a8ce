// The noisy reference particle inside the unit sphere: a smooth fall-off eroded by cellular noise with some gradient
// noise. One for the whole sky; every particle turns it its own way.
#ifndef NEPHELE_SHARED_REFERENCE_PARTICLE_H
#define NEPHELE_SHARED_REFERENCE_PARTICLE_H

#include "noise.h"

NEPHELE_SHARED_BEGIN

// Density above which a point counts as cloud matter.
NEPHELE_CONST(float, kFirstMatterDensity, 0.04f);

// Relative extinction in [0, 1] at p, 0 outside the unit sphere.
NEPHELE_FN float reference_particle_density(vec3 p, uint seed) {
  float r2 = dot(p, p);
  if (r2 >= 1.0f) return 0.0f;
  float falloff = 1.0f - r2 * (22.0f / 9.0f - r2 * (17.0f / 9.0f - r2 * (4.0f / 9.0f)));
  float billows = 2.4f * (worley_fbm(2.2f * p, uvec3(0u), noise_seed(seed, 16), 2) - 0.45f);
  float ragged = 1.6f * fbm3(1.2f * p, uvec3(0u), noise_seed(seed, 17), 3);
  float x = falloff + 1.2f * (0.3f * ragged + 0.7f * billows) - 0.2f;
  return clamp(2.0f * x, 0.0f, 1.0f) * (1.0f - smoothstep(0.9f, 1.0f, sqrt(r2)));
}

NEPHELE_SHARED_END

#endif
