#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/light.h"

// [Yusov14] 5.3 step 1, part 3: one (tile, particle) pair for every tile a particle covers, in order from the sun.
// Pairs beyond the capacity, those of the particles farthest from the sun, are counted and left out.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 1) readonly buffer SunOrder { uint sun_order[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Rectangles { uint rectangles[]; };
layout(scalar, set = 0, binding = 3) readonly buffer Places { uint places[]; };
layout(scalar, set = 0, binding = 4) writeonly buffer Keys { uint keys[]; };
layout(scalar, set = 0, binding = 5) writeonly buffer Values { uint values[]; };
layout(push_constant) uniform Push { uint pair_capacity; };

void main() {
  const uint rank = gl_GlobalInvocationID.x;
  if (rank >= counters.particle_count) return;
  const uint particle = sun_order[rank];
  const uint rectangle = rectangles[particle];
  const uvec2 low = rectangle_low(rectangle), high = rectangle_high(rectangle);
  uint place = places[rank];
  for (uint y = low.y; y < high.y; ++y)
    for (uint x = low.x; x < high.x && place < pair_capacity; ++x, ++place) {
      keys[place] = light_tile_index(uvec2(x, y));
      values[place] = particle;
    }
}
