// The clouds' shadow as other passes see it. The including shader declares the image of passes/light/cloud_shadow.h as
// a linearly filtered, clamped sampler and hands it over.
#ifndef NEPHELE_CLOUD_SHADOW_LOOKUP_GLSL
#define NEPHELE_CLOUD_SHADOW_LOOKUP_GLSL

#include "shared/light.h"

// Transmittance of the clouds from a point of render space towards the sun: 1 towards the sun from them, all of
// their shadow behind them, and in between a share that is half at the mean place where the light is lost. Shadows
// are as soft as a texel is wide: wider than the sun's penumbra (1/107 of the distance to the cloud) nearly everywhere.
// uv_scale: light_uv_scale of the view distance.
float cloud_shadow(sampler2D shadow, mat3 light_from_render, float uv_scale, vec3 p_render_m) {
  const vec3 p_m = light_from_render * p_render_m;
  const vec2 uv = scaled_light_uv(p_m.xy, uv_scale);
  if (any(lessThan(uv, vec2(0.0))) || any(greaterThan(uv, vec2(1.0)))) return 1.0;
  const vec4 value = textureLod(shadow, uv, 0.0);
  if (value.x < 1.0e-4) return 1.0;
  const vec3 warped = value.yzw / value.x;
  const float top_m = light_unwarp(warped.x), mean_m = light_unwarp(warped.y), bottom_m = light_unwarp(warped.z);
  const float upper = clamp((top_m - p_m.z) / max(top_m - mean_m, 1.0), 0.0, 1.0);
  const float lower = clamp((mean_m - p_m.z) / max(mean_m - bottom_m, 1.0), 0.0, 1.0);
  return 1.0 - value.x * 0.5 * (upper + lower);
}

#endif
