// Buffers read as texels. Lavapipe loads a storage buffer thread by thread and word by word, but gathers a texel's four
// words for eight threads at once; a GPU is as fast either way. So a buffer that each thread reads at another place is
// bound as texels. A texel that a shader declares and does not read costs nothing.
#ifndef NEPHELE_TEXELS_GLSL
#define NEPHELE_TEXELS_GLSL

#include "shared/types.h"

vec4 texel_at(usamplerBuffer texels, uint i) { return uintBitsToFloat(texelFetch(texels, int(i))); }
uint word_at(usamplerBuffer words, uint i) { return texelFetch(words, int(i)).x; }
uvec2 two_words_at(usamplerBuffer words, uint i) { return uvec2(word_at(words, 2u * i), word_at(words, 2u * i + 1u)); }
float float_at(usamplerBuffer words, uint i) { return uintBitsToFloat(word_at(words, i)); }

Particle particle_at(usamplerBuffer texels, uint i) {
  const vec4 a = texel_at(texels, 4u * i), b = texel_at(texels, 4u * i + 1u), d = texel_at(texels, 4u * i + 3u);
  const uvec4 c = texelFetch(texels, int(4u * i + 2u));
  return Particle(a.xyz, a.w, b.xyz, b.w, c.x, c.y, uintBitsToFloat(c.z), uintBitsToFloat(c.w), d.xyz,
                  floatBitsToUint(d.w));
}

ParticleLight particle_light_at(usamplerBuffer texels, uint i) {
  const vec4 a = texel_at(texels, 3u * i), b = texel_at(texels, 3u * i + 1u), c = texel_at(texels, 3u * i + 2u);
  return ParticleLight(a.xyz, a.w, b.xyz, b.w, c.x, c.yzw);
}

DrawParticle draw_particle_at(usamplerBuffer texels, uint i) {
  vec4 t[10];
  for (uint k = 0u; k < 10u; ++k) t[k] = texel_at(texels, 10u * i + k);
  DrawParticle p;
  p.reference_from_render = mat3(t[0].xyz, vec3(t[0].w, t[1].xy), vec3(t[1].zw, t[2].x));
  p.center_m = t[2].yzw;
  p.light_direction = t[3].xyz;
  p.extinction_per_m = t[3].w;
  p.sun_irradiance = t[4].xyz;
  p.optical_radius = t[4].w;
  p.tau_gradient_per_m = t[5].xyz;
  p.tau_sun = t[5].w;
  p.sky_up_radiance = t[6].xyz;
  p.base_m = t[6].w;
  p.sky_down_radiance = t[7].xyz;
  p.sky_share = t[7].w;
  p.radiance_per_sr = t[8].xyz;
  p.flags = texelFetch(texels, int(10u * i + 8u)).w;
  p.tau_near = t[9].x;
  p.tau_behind = t[9].y;
  p.sky_share_per_m = t[9].z;
  p.outward = t[9].w;
  return p;
}

#endif
