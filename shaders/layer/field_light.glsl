// Light from the field (passes/light/light_field.h) at places of particles.
#ifndef NEPHELE_FIELD_LIGHT_GLSL
#define NEPHELE_FIELD_LIGHT_GLSL

#include "shared/cloud_light.h"
#include "shared/types.h"
#include "kit/near_beam_fetch.glsl"

layout(constant_id = 20) const bool kLightField = true;       // false: light from tables, and dummies are bound here
layout(constant_id = 22) const bool kSoftParticles = true;    // false: there are no soft ones
layout(constant_id = 21) const bool kSmoothParticles = true;  // false: particles are homogeneous or have structure
layout(set = 0, binding = 20) uniform sampler3D
    light_radiance;  // what the lattice carries, in units of frame.light_unit; depth towards the sun
layout(set = 0, binding = 21) uniform sampler2D near_beam;  // per sr and unit irradiance

vec3 field_scale_per_m(DrawParticle p) { return vec3(p.field_per_m.x, p.field_per_m.x, p.field_per_m.y); }

// mu: cosine between the ray from the eye and the way to the sun; once_per_sr: the phase function there;
// carried: radiance from the volume.
vec3 source_radiance_in_field(vec3 sun_irradiance, float mu, float once_per_sr, float tau, vec3 carried) {
  return field_source_radiance(sun_irradiance, once_per_sr, tau, fetch_near_beam(near_beam, tau, mu),
                               frame.light_unit * carried);
}

#endif
