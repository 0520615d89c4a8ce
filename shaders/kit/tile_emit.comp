#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "shared/tile_rectangle.h"
#include "kit/texels.glsl"
#include "kit/tile_push.glsl"

// Tile lists, part 3: one (tile, item) pair for every tile an item covers, in the lists' order. Pairs beyond the
// capacity, those of the last items, are counted and left out.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kColumnsARound =
    1u;  // more where an item may cover more tiles than lavapipe goes rounds

layout(scalar, set = 0, binding = 0) readonly buffer Counters { uint counters[]; };
WORDS(1, order);
WORDS(2, rectangles);
WORDS(3, places);
layout(scalar, set = 0, binding = 4) writeonly buffer Keys { uint keys[]; };
layout(scalar, set = 0, binding = 5) writeonly buffer Values { uint values[]; };

void main() {
  const uint rank = gl_GlobalInvocationID.x;
  if (rank >= counters[item_count_at]) return;
  const uint item = word_at(order, rank);
  const uvec2 rectangle = two_words_at(rectangles, item);
  const uvec2 low = rectangle_low(rectangle), high = rectangle_high(rectangle);
  uint place = word_at(places, rank);
  // One loop for rows and columns: eight threads of a CPU run in step, and with a loop in a loop all would wait for the
  // longest row.
  uint x = low.x, y = low.x < high.x ? low.y : high.y;
  while (y < high.y) {
    [[unroll]] for (uint k = 0u; k < kColumnsARound; ++k) {
      if (x + k < high.x && place < pair_capacity) {
        keys[place] = y * tile_columns + x + k;
        values[place++] = item;
      }
    }
    x += kColumnsARound;
    if (x >= high.x) {
      x = low.x;
      ++y;
    }
  }
}
