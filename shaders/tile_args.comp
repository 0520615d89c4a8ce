#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/light.h"

// [Yusov14] 5.3 step 1, part 4: from the demand to the number of pairs there is room for, and its dispatch.
layout(local_size_x = 1) in;

layout(scalar, set = 0, binding = 0) buffer Counters { FrameCounters counters; };
layout(push_constant) uniform Push { uint pair_capacity; };

void main() {
  const uint count = min(counters.tile_pair_demand, pair_capacity);
  counters.tile_pair_count = count;
  counters.tile_pair_groups = uvec3((count + 63u) / 64u, 1u, 1u);
}
