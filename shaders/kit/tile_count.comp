#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/tile_rectangle.h"
#include "kit/texels.glsl"
#include "kit/tile_push.glsl"

// Tile lists, part 1: how many tiles each item covers, in the lists' order. Zero past the last item, because the
// prefix sum that follows runs over the whole capacity.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) readonly buffer Counters { uint counters[]; };
WORDS(1, order);
WORDS(2, rectangles);
layout(scalar, set = 0, binding = 3) writeonly buffer Places { uint places[]; };

void main() {
  const uint rank = gl_GlobalInvocationID.x;
  if (rank >= item_capacity) return;
  places[rank] = rank < counters[item_count_at] ? rectangle_area(two_words_at(rectangles, word_at(order, rank))) : 0u;
}
