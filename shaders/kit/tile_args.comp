#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "kit/pair_dispatch.glsl"
#include "kit/tile_push.glsl"

// Tile lists, part 2: from the demand to the number of pairs there is room for, and its dispatch.
layout(local_size_x = 1) in;

layout(scalar, set = 0, binding = 0) buffer Counters { uint counters[]; };

void main() {
  const uint count = min(counters[pair_demand_at], pair_capacity);
  counters[pair_count_at] = count;
  const uvec3 groups = pair_groups(count);
  for (int k = 0; k < 3; ++k) counters[pair_groups_at + uint(k)] = groups[k];
}
