// The cloud layer from its low resolution to the image's: the four nearest low-resolution pixels, weighted by distance
// and by how well the scene behind them (ground or sky) agrees with that behind the full-resolution pixel, so that
// neither cloud nor sky bleeds across the horizon or an object's edge.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 1) uniform sampler2D layer_color;
layout(set = 0, binding = 2) uniform sampler2D layer_depth;
layout(set = 0, binding = 3, rgba32f) writeonly uniform image2D full_color;
layout(set = 0, binding = 4, r32f) writeonly uniform image2D full_depth;
layout(set = 0, binding = 5) uniform sampler2D layer_scene;
layout(set = 0, binding = 6) uniform sampler2D host_distance;

#include "scene_distance.glsl"

// Logarithm of a distance; the sky counts as 10 000 km away.
float log_distance(float distance_m) { return log(clamp(distance_m, 0.01, 1e7)); }

// Whether the scene may change abruptly within a few low-resolution pixels: near the horizon, or anywhere in a host's.
bool near_edge(vec2 pixel_center) {
  if (frame.host_scene != 0u) return true;
  if (frame.ground_enabled == 0u) return false;
  const float h = max(frame.camera_grid_m.z, 0.0);
  const float horizon = -sqrt(h * (2.0 * kPlanetRadiusM + h)) / (kPlanetRadiusM + h);
  const float pixel_rad = 4.0 / (length(vec3(frame.clip_from_render[0][1], frame.clip_from_render[1][1], frame.clip_from_render[2][1])) * float(frame.layer_size_px.y));
  return abs(pixel_direction(pixel_center, frame.image_size_px).z - horizon) < 8.0 * pixel_rad;
}

void main() {
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(pixel, frame.image_size_px))) return;
  const float scale = float(frame.scale);
  const vec2 center = vec2(pixel) + 0.5;
  const vec2 low = center / scale - 0.5;
  const ivec2 corner = ivec2(floor(low));
  const vec2 f = low - vec2(corner);
  const bool edge = near_edge(center);
  const float own = edge ? log_distance(scene_distance_m(center)) : 0.0;

  vec4 color = vec4(0.0);
  float weights = 0.0, depth_weights = 0.0, inverse_depth = 0.0;
  for (int i = 0; i < 4; ++i) {
    const ivec2 offset = ivec2(i & 1, i >> 1);
    const ivec2 at = clamp(corner + offset, ivec2(0), ivec2(frame.layer_size_px) - 1);
    const float bilinear = (offset.x == 1 ? f.x : 1.0 - f.x) * (offset.y == 1 ? f.y : 1.0 - f.y);
    float weight = bilinear + 1e-4;
    if (edge) weight *= exp(-8.0 * min(abs(own - log_distance(texelFetch(layer_scene, at, 0).x)), 4.0));
    const vec4 texel = texelFetch(layer_color, at, 0);
    const float first = texelFetch(layer_depth, at, 0).x;
    color += weight * texel;
    weights += weight;
    if (!isinf(first)) {  // inverse distances: near matter decides, as in perspective
      inverse_depth += weight * (1.0 - texel.a) / first;
      depth_weights += weight * (1.0 - texel.a);
    }
  }
  imageStore(full_color, ivec2(pixel), color / weights);
  imageStore(full_depth, ivec2(pixel), vec4(inverse_depth > 0.0 ? depth_weights / inverse_depth : uintBitsToFloat(0x7f800000u)));
}
