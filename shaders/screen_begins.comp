// For every place in a screen tile's list: nothing from here on in the list begins nearer than this. One thread walks
// one list from its end.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/blend.h"

layout(local_size_x = 32) in;
layout(scalar, set = 0, binding = 0) readonly buffer Ranges { uvec2 ranges[]; };
layout(scalar, set = 0, binding = 1) readonly buffer List { uint list[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Nears { float near_m[]; };
layout(scalar, set = 0, binding = 3) writeonly buffer Begins { float begins_m[]; };
layout(push_constant) uniform Push { uint tile_count; };

void main() {
  const uint tile = gl_GlobalInvocationID.x;
  if (tile >= tile_count) return;
  float least = kNoMatterM;
  for (uint i = ranges[tile].y; i-- > ranges[tile].x;) {
    least = min(least, near_m[list[i]]);
    begins_m[i] = least;
  }
}
