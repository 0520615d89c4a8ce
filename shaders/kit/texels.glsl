// Buffers that each thread reads at a place of its own, declared by one of
//   WORDS(binding, name);             read by word_at, float_at, two_words_at
//   TEXELS(binding, name);            four words each: texel_at, vec4_at
//   PARTICLES(binding, name);         particle_at
//   PARTICLE_LIGHTS(binding, name);   particle_light_at
//   DRAW_PARTICLES(binding, name);    draw_particle_at
// The host binds them as Access::words or Access::texels. Each shader that uses them is compiled twice, and the
// device's tuning chooses: to a uniform texel buffer, and with STORAGE_TEXELS to a storage buffer. Lavapipe loads
// storage buffers lane by lane and word by word, but gathers a texel's four words for eight threads at once. Hardware
// does either alike, and texel buffers have a limit of elements, which may be as low as 65 536. Texels whose words a
// shader does not use cost nothing.
#ifndef NEPHELE_TEXELS_GLSL
#define NEPHELE_TEXELS_GLSL

#include "shared/types.h"

#ifdef STORAGE_TEXELS
#define NEPHELE_BUFFER(at, name, Type) \
  layout(scalar, set = 0, binding = at) readonly buffer name##_in { Type name[]; };
#define NEPHELE_LOAD(name, i, Type) name[i]
#else
#define NEPHELE_BUFFER(at, name, Type) layout(set = 0, binding = at) uniform usamplerBuffer name;
#define NEPHELE_LOAD(name, i, Type) Type(texelFetch(name, int(i)))
#endif

#define word_at(name, i) name##_word(i)
#define two_words_at(name, i) name##_two_words(i)
#define float_at(name, i) uintBitsToFloat(name##_word(i))
#define texel_at(name, i) name##_texel(i)
#define vec4_at(name, i) uintBitsToFloat(name##_texel(i))
#define particle_at(name, i) name##_particle(i)
#define particle_light_at(name, i) name##_particle_light(i)
#define draw_particle_at(name, i) name##_draw_particle(i)

#define WORDS(at, name)                                            \
  NEPHELE_BUFFER(at, name, uint)                                   \
  uint name##_word(uint i) { return NEPHELE_LOAD(name, i, uint); } \
  uvec2 name##_two_words(uint i) { return uvec2(name##_word(2u * i), name##_word(2u * i + 1u)); }

#define TEXELS(at, name)          \
  NEPHELE_BUFFER(at, name, uvec4) \
  uvec4 name##_texel(uint i) { return NEPHELE_LOAD(name, i, uvec4); }

#define PARTICLES(at, name)                                              \
  TEXELS(at, name)                                                       \
  Particle name##_particle(uint i) {                                     \
    uvec4 texels[5];                                                     \
    for (uint k = 0u; k < 5u; ++k) texels[k] = name##_texel(5u * i + k); \
    return particle_from(texels);                                        \
  }

#define PARTICLE_LIGHTS(at, name)                                        \
  TEXELS(at, name)                                                       \
  ParticleLight name##_particle_light(uint i) {                          \
    uvec4 texels[2];                                                     \
    for (uint k = 0u; k < 2u; ++k) texels[k] = name##_texel(2u * i + k); \
    return particle_light_from(texels);                                  \
  }

#define DRAW_PARTICLES(at, name)                                           \
  TEXELS(at, name)                                                         \
  DrawParticle name##_draw_particle(uint i) {                              \
    uvec4 texels[10];                                                      \
    for (uint k = 0u; k < 10u; ++k) texels[k] = name##_texel(10u * i + k); \
    return draw_particle_from(texels);                                     \
  }

Particle particle_from(uvec4 texels[5]) {
  const vec4 a = uintBitsToFloat(texels[0]), b = uintBitsToFloat(texels[1]);
  const uvec4 c = texels[2], d = texels[3], e = texels[4];
  return Particle(a.xyz, a.w, EllipsoidShape(b.xyz, vec3(b.w, uintBitsToFloat(c.xy))), c.z, c.w, uintBitsToFloat(d.x),
                  uintBitsToFloat(d.y), d.z, d.w, uintBitsToFloat(e.xyz), e.w);
}

ParticleLight particle_light_from(uvec4 texels[2]) {
  const vec4 a = uintBitsToFloat(texels[0]), b = uintBitsToFloat(texels[1]);
  return ParticleLight(a.xyz, a.w, b.xyz, b.w);
}

DrawParticle draw_particle_from(uvec4 texels[10]) {
  vec4 t[10];
  for (uint k = 0u; k < 10u; ++k) t[k] = uintBitsToFloat(texels[k]);
  DrawParticle p;
  p.reference_from_render = mat3(t[0].xyz, vec3(t[0].w, t[1].xy), vec3(t[1].zw, t[2].x));
  p.center_m = t[2].yzw;
  p.light_direction = t[3].xyz;
  p.extinction_per_m = t[3].w;
  p.sun_irradiance = t[4].xyz;
  p.optical_radius = t[4].w;
  p.tau_gradient_per_m = t[5].xyz;
  p.tau_sun = t[5].w;
  p.ambient_radiance = t[6].xyz;
  p.base_m = t[6].w;
  p.radiance_per_sr = t[7].xyz;
  p.flags = texels[7].w;
  p.field_place = t[8].xyz;
  p.own_depth_share = t[8].w;
  p.field_per_m = t[9].xy;
  p.structure_depth = t[9].z;
  p.soft_detail = t[9].w;
  return p;
}

#endif
