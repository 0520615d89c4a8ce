// Draw particles as an image of RGBA32F texels, ten a particle. Every thread of the tiled backend reads another
// particle; lavapipe gathers a texel's four values for eight threads at once, but loads storage buffers one by one.
#ifndef NEPHELE_DRAW_TEXELS_GLSL
#define NEPHELE_DRAW_TEXELS_GLSL

#include "shared/types.h"

ivec2 first_texel(uint particle) {
  return ivec2(kDrawTexelsPerParticle * (particle % kDrawParticlesPerRow), particle / kDrawParticlesPerRow);
}

#ifdef DRAW_TEXELS_WRITE
void store_draw_particle(uint particle, DrawParticle p) {
  const ivec2 at = first_texel(particle);
  const mat3 m = p.reference_from_render;
  imageStore(draw_texels, at, vec4(m[0], p.extinction_per_m));
  imageStore(draw_texels, at + ivec2(1, 0), vec4(m[1], p.base_m));
  imageStore(draw_texels, at + ivec2(2, 0), vec4(m[2], uintBitsToFloat(p.flags | 0x40000000u)));  // no denormal
  imageStore(draw_texels, at + ivec2(3, 0), vec4(p.center_m, p.optical_radius));
  imageStore(draw_texels, at + ivec2(4, 0), vec4(p.light_direction, p.tau_sun));
  imageStore(draw_texels, at + ivec2(5, 0), vec4(p.sun_irradiance, p.sky_share));
  imageStore(draw_texels, at + ivec2(6, 0), vec4(p.tau_gradient_per_m, p.tau_near));
  imageStore(draw_texels, at + ivec2(7, 0), vec4(p.sky_up_radiance, p.tau_behind));
  imageStore(draw_texels, at + ivec2(8, 0), vec4(p.sky_down_radiance, p.sky_share_per_m));
  imageStore(draw_texels, at + ivec2(9, 0), vec4(p.radiance_per_sr, p.outward));
}
#else
DrawParticle load_draw_particle(sampler2D texels, uint particle) {
  const ivec2 at = first_texel(particle);
  vec4 t[kDrawTexelsPerParticle];
  for (int i = 0; i < int(kDrawTexelsPerParticle); ++i) t[i] = texelFetch(texels, at + ivec2(i, 0), 0);
  DrawParticle p;
  p.reference_from_render = mat3(t[0].xyz, t[1].xyz, t[2].xyz);
  p.extinction_per_m = t[0].w;
  p.base_m = t[1].w;
  p.flags = floatBitsToUint(t[2].w) & 0x3FFFFFFFu;
  p.center_m = t[3].xyz;
  p.optical_radius = t[3].w;
  p.light_direction = t[4].xyz;
  p.tau_sun = t[4].w;
  p.sun_irradiance = t[5].xyz;
  p.sky_share = t[5].w;
  p.tau_gradient_per_m = t[6].xyz;
  p.sky_up_radiance = t[7].xyz;
  p.sky_down_radiance = t[8].xyz;
  p.sky_share_per_m = t[8].w;
  p.radiance_per_sr = t[9].xyz;
  p.outward = t[9].w;
  p.tau_near = t[6].w;
  p.tau_behind = t[7].w;
  return p;
}
#endif

#endif
