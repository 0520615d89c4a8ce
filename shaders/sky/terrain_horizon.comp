// The horizon towards the sun of every n-th vertex, as the tangent of its elevation: what is no higher than `least`
// hides no sun and counts as that.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "sky/terrain_arrays.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 4) writeonly buffer Horizon { float horizon[]; };
layout(push_constant, scalar) uniform Push {
  vec2 towards_sun;  // unit, east and north
  float least;
};

void main() {
  const ivec2 size = terrain_samples(view.vertices, view.shadow_stride);
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, size))) return;
  const ivec2 vertex = min(at * int(view.shadow_stride), view.vertices - 1);
  const float skip_m = kHorizonSkip / max(view.per_m.x, view.per_m.y);
  horizon[at.y * size.x + at.x] = terrain_horizon(Terrain(view), vec2(vertex), terrain_height(Terrain(view), vertex),
                                                  towards_sun * view.per_m, least, skip_m);
}
