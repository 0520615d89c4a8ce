// Finishes the screen tiles' lists: every place gets its entry (screen_bounds.h) and the distance before which nothing
// from here on in the list begins. One thread walks one list from its end. And gathers the tiles with long lists row by row; in
// what order is left to chance, and changes nothing.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/blend.h"
#include "shared/screen_bounds.h"

layout(local_size_x = 32) in;
layout(scalar, set = 0, binding = 0) readonly buffer Ranges { uvec2 ranges[]; };
layout(scalar, set = 0, binding = 1) readonly buffer List { uint list[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Nears { float near_m[]; };
layout(scalar, set = 0, binding = 3) readonly buffer Pixels { uvec2 pixels[]; };
layout(scalar, set = 0, binding = 4) writeonly buffer Entries { uint entries[]; };
layout(scalar, set = 0, binding = 5) writeonly buffer Begins { float begins_m[]; };
layout(scalar, set = 0, binding = 6) buffer LongTiles { uvec3 long_groups; uint long_tiles[]; };  // a count a row, then tiles' columns
layout(push_constant) uniform Push { uint tile_columns, tile_rows; };

void main() {
  const uint tile = gl_GlobalInvocationID.x;
  if (tile >= tile_columns * tile_rows) return;
  const uvec2 place = uvec2(tile % tile_columns, tile / tile_columns);
  if (tile == 0u) long_groups.yz = uvec2(tile_rows, 1u);
  if (ranges[tile].y - ranges[tile].x > kShortList) {
    const uint at = atomicAdd(long_tiles[place.y], 1u);
    long_tiles[tile_rows + place.y * tile_columns + at] = place.x;
    atomicMax(long_groups.x, at + 1u);
  }
  float least = kNoMatterM;
  for (uint i = ranges[tile].y; i-- > ranges[tile].x;) {
    const uint particle = list[i];
    least = min(least, near_m[particle]);
    begins_m[i] = least;
    entries[i] = tile_entry(particle, pixels[particle], place);
  }
}
