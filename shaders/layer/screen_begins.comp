// Finishes the screen tiles' lists: every place gets the distance before which nothing from here on in the list begins.
// One thread walks one list from its end. And gathers, row by row, the tiles with long lists and those with lists of
// several pages.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "shared/blend.h"
#include "shared/screen_bounds.h"
#include "kit/texels.glsl"

layout(local_size_x = 32) in;
layout(scalar, set = 0, binding = 0) readonly buffer Ranges { uvec2 ranges[]; };
WORDS(1, list);
WORDS(2, near_m);
layout(scalar, set = 0, binding = 3) writeonly buffer Begins { float begins_m[]; };
// How many tiles each row has, then their columns, a row after the other.
layout(scalar, set = 0, binding = 4) buffer LongTiles {
  uvec3 long_groups;
  uint long_tiles[];
};
layout(scalar, set = 0, binding = 5) buffer PagedTiles {
  uvec3 paged_groups;
  uint paged_tiles[];
};
layout(push_constant) uniform Push { uint tile_columns, tile_rows, short_list; };

void gather_row(uint row) {
  uint long_count = 0u, paged_count = 0u;
  for (uint column = 0u; column < tile_columns; ++column) {
    const uvec2 range = ranges[row * tile_columns + column];
    const uint places = range.y - range.x;
    if (places > kPagePlaces)
      paged_tiles[tile_rows + row * tile_columns + paged_count++] = column;
    else if (places > short_list)
      long_tiles[tile_rows + row * tile_columns + long_count++] = column;
  }
  long_tiles[row] = long_count;
  paged_tiles[row] = paged_count;
  atomicMax(long_groups.x, long_count);
  atomicMax(paged_groups.x, paged_count);
}

void main() {
  const uint tile = gl_GlobalInvocationID.x;
  if (tile >= tile_columns * tile_rows) return;
  if (tile == 0u) long_groups.yz = paged_groups.yz = uvec2(tile_rows, 1u);
  if (tile < tile_rows) gather_row(tile);
  const uvec2 range = ranges[tile];
  float least = kNoMatterM;
  // Lavapipe goes round 65 535 times at most: with 17 places a round, through the longest of lists
  // (kMaxScreenParticles).
  for (uint i = range.y; i > range.x;) {
    [[unroll]] for (uint k = 0u; k < 17u; ++k) {
      if (i > range.x) {
        least = min(least, float_at(near_m, word_at(list, --i)));
        begins_m[i] = least;
      }
    }
  }
}
