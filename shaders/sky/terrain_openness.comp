// How much of the sky every n-th vertex sees past its surroundings: its share of a horizontal surface's irradiance
// under an even sky, over that of a bare slope as steep as the land around it (whose own share the shading knows).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "sky/terrain_arrays.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 4) writeonly buffer Openness { float openness[]; };

const int kAzimuths = 16;

void main() {
  const ivec2 size = terrain_samples(view.vertices, view.openness_stride);
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, size))) return;
  const int stride = int(view.openness_stride);
  const ivec2 vertex = min(at * stride, view.vertices - 1);
  const float altitude_m = terrain_height(Terrain(view), vertex);
  const float skip_m = kHorizonSkip / max(view.per_m.x, view.per_m.y);
  float seen = 0.0;
  for (int i = 0; i < kAzimuths; ++i) {
    const float angle = 2.0 * kPi * (float(i) + 0.5) / float(kAzimuths);
    const float up = terrain_horizon(Terrain(view), vec2(vertex), altitude_m, vec2(cos(angle), sin(angle)) * view.per_m,
                                     0.0, skip_m);
    seen += 1.0 / (float(kAzimuths) * (1.0 + up * up));
  }
  const ivec2 low = max(vertex - 2, ivec2(0)), high = min(vertex + 2, view.vertices - 1);
  const vec2 slope = vec2(terrain_height(Terrain(view), ivec2(high.x, vertex.y)) -
                              terrain_height(Terrain(view), ivec2(low.x, vertex.y)),
                          terrain_height(Terrain(view), ivec2(vertex.x, high.y)) -
                              terrain_height(Terrain(view), ivec2(vertex.x, low.y))) *
                     view.per_m / vec2(high - low);
  const float of_slope = 0.5 + 0.5 * inversesqrt(1.0 + dot(slope, slope));
  openness[at.y * size.x + at.x] = min(seen / of_slope, 1.0);
}
