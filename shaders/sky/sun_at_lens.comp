#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// The sunlight at the camera, for its glare: the same for all pixels, so one thread finds it.
#include "shared/atmosphere_tables.h"
#include "shared/types.h"
#define WRITES_COMPOSITE_TILES
#include "sky/composite_tiles.glsl"

layout(local_size_x = 1) in;
layout(constant_id = 2) const bool kClouds = true;  // as in composite.comp
// Not a uniform buffer: lavapipe compiles the values of a uniform buffer into the code where much of it depends on
// them, and would compile this shader anew every frame.
layout(set = 0, binding = 0, scalar) readonly buffer Frame { FrameConstants frame; };
layout(set = 0, binding = 3) uniform sampler2D transmittance;
layout(set = 0, binding = 8) uniform sampler2D layer_color;  // a dummy without clouds

#include "kit/camera_rays.glsl"

// Share of the sun's disc that the clouds let through, where the disc is in the image; off it, at the nearest border.
float sun_through_clouds() {
  if (!kClouds) return 1.0;
  const vec4 clip = frame.clip_from_render * vec4(frame.sun_direction, 0.0);
  const vec2 center_px = (clip.xy / max(clip.w, 1e-4) * 0.5 + 0.5) * vec2(frame.image_size_px);
  const vec2 nearest_px = clamp(center_px, vec2(0.0), vec2(frame.image_size_px));
  const float pixel_rad = length(pixel_direction(nearest_px + vec2(0.0, 1.0), frame.image_size_px) -
                                 pixel_direction(nearest_px, frame.image_size_px));
  const float reach_px = 0.6 * frame.sun_angular_radius_rad / pixel_rad;
  float sum = 0.0;
  for (int i = 0; i < 5; ++i) {
    const vec2 offset =
        i == 4 ? vec2(0.0) : vec2((i & 1) == 0 ? -reach_px : reach_px, (i & 2) == 0 ? -reach_px : reach_px);
    const vec2 at = clamp((center_px + offset) / float(frame.scale), vec2(0.0), vec2(frame.layer_size_px) - 1.0);
    sum += texelFetch(layer_color, ivec2(at), 0).a;
  }
  return 0.2 * sum;
}

void main() {
  const float altitude_m = max(0.0, frame.camera_grid_m.z);
  sun_at_lens =
      sun_through_clouds() * sun_transmittance(transmittance, altitude_m, frame.sun_direction.z) * frame.sun_irradiance;
}
