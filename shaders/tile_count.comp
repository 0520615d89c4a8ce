#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/light.h"

// [Yusov14] 5.3 step 1, part 2: how many tiles each particle covers, in order from the sun. Zero past the last
// particle, because the prefix sum that follows runs over the whole capacity.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 1) readonly buffer SunOrder { uint sun_order[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Rectangles { uint rectangles[]; };
layout(scalar, set = 0, binding = 3) writeonly buffer Places { uint places[]; };
layout(push_constant) uniform Push { uint capacity; };

void main() {
  const uint rank = gl_GlobalInvocationID.x;
  if (rank >= capacity) return;
  places[rank] = rank < counters.particle_count ? rectangle_area(rectangles[sun_order[rank]]) : 0u;
}
