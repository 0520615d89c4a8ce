// Rays through pixels, and the ground they meet. The including shader declares FrameConstants frame.
#ifndef NEPHELE_CAMERA_RAYS_GLSL
#define NEPHELE_CAMERA_RAYS_GLSL

#include "shared/types.h"

// Unit direction of the ray through a pixel's centre; size_px is that of the image the pixel belongs to.
vec3 pixel_direction(vec2 pixel_center, uvec2 size_px) {
  vec2 ndc = pixel_center / vec2(size_px) * 2.0 - 1.0;
  vec4 far = frame.render_from_clip * vec4(ndc, 1.0, 1.0);
  return normalize(far.xyz);
}

// Distance along the ray to the ground (a sphere), or a huge number.
float ground_distance_m(vec3 direction) {
  if (frame.ground_enabled == 0u) return 1e30;
  float h = max(frame.camera_grid_m.z, 0.01);
  float down = -direction.z * (kPlanetRadiusM + h);
  float twice = h * (2.0 * kPlanetRadiusM + h);
  float discriminant = down * down - twice;
  if (down <= 0.0 || discriminant < 0.0) return 1e30;
  return twice / (down + sqrt(discriminant));
}

#endif
