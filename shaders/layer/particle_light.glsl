// Light from a particle's own tables, as the shading of whole chords (cloud_shade.glsl) and the ray marcher
// (cloud_march.comp) take it. The including shader declares FrameConstants frame and sampler3D multiple_table, and
// includes blend.h and types.h before.
#ifndef NEPHELE_PARTICLE_LIGHT_GLSL
#define NEPHELE_PARTICLE_LIGHT_GLSL

#include "layer/table_fetch.glsl"

// Source radiance of sunlight scattered more than once inside the particle, per unit irradiance on it, as the mean over
// a chord: what leaves the homogeneous sphere of the particle's optical radius along it, over the chord's opacity
// there. entry: unit vector to where the ray enters, reference space; h: half the chord in the unit sphere; mu_unit:
// cosine between the light and the way to the eye, reference space.
float multiple_inside_per_sr(DrawParticle p, vec3 entry, float h, float mu_unit) {
  const float c = dot(entry, p.light_direction), sigma = p.optical_radius;
  return fetch_multiple(multiple_table, c, h, mu_unit, sigma, frame.phase_g) / max(opacity_of(2.0 * h * sigma), 1e-3);
}

#endif
