#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "kit/pair_dispatch.glsl"
#include "kit/texels.glsl"
#include "kit/tile_push.glsl"

// Tile lists, part 4: where each tile's pairs begin and end in the list sorted by tile. Tiles without pairs keep the
// zeros of the fill before.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) readonly buffer Counters { uint counters[]; };
WORDS(1, keys);
layout(scalar, set = 0, binding = 2) writeonly buffer Ranges { uvec2 ranges[]; };

void main() {
  const uint i = pair_of_thread();
  const uint pair_count = counters[pair_count_at];
  if (i >= pair_count) return;
  const uint tile = word_at(keys, i);
  if (i == 0u || word_at(keys, i - 1u) != tile) ranges[tile].x = i;
  if (i + 1u == pair_count || word_at(keys, i + 1u) != tile) ranges[tile].y = i + 1u;
}
