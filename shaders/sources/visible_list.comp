#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/types.h"

// The visible particles' indices in the order of the particles, and the arguments of everything that runs over them.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) readonly buffer Places { uint places[]; };
layout(scalar, set = 0, binding = 1) writeonly buffer Visible { uint visible[]; };
layout(scalar, set = 0, binding = 2) buffer Counters { FrameCounters counters; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i == 0u) {
    const uint count = counters.visible_demand;  // the prefix sum's total; the list holds every particle there is
    counters.visible_count = count;
    counters.visible_groups = uvec3((count + 63u) / 64u, 1u, 1u);
    counters.draw = uvec4(6u * count, 1u, 0u, 0u);
  }
  if (i < counters.particle_count && places[i + 1u] > places[i]) visible[places[i]] = i;
}
