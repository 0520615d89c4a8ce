// Rectangles of tiles in a grid of at most 65 535 tiles a side: what an item covers in the lists of tile_pairs.h.
#ifndef NEPHELE_SHARED_TILE_RECTANGLE_H
#define NEPHELE_SHARED_TILE_RECTANGLE_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

// x: first column in the low half, column past the last in the high half; y: rows likewise.
NEPHELE_CONST(uvec2, kNoTiles, uvec2(0u));

NEPHELE_FN uvec2 tile_rectangle(uvec2 low, uvec2 past) {
  return uvec2(low.x | (past.x << 16u), low.y | (past.y << 16u));
}

NEPHELE_FN uvec2 rectangle_low(uvec2 rectangle) { return uvec2(rectangle.x & 0xFFFFu, rectangle.y & 0xFFFFu); }
NEPHELE_FN uvec2 rectangle_high(uvec2 rectangle) { return uvec2(rectangle.x >> 16u, rectangle.y >> 16u); }

NEPHELE_FN uint rectangle_area(uvec2 rectangle) {
  uvec2 low = rectangle_low(rectangle);
  uvec2 high = rectangle_high(rectangle);
  return (high.x - low.x) * (high.y - low.y);
}

// The tiles that two rectangles have in common.
NEPHELE_FN uvec2 rectangle_both(uvec2 a, uvec2 b) {
  uvec2 low = max(rectangle_low(a), rectangle_low(b));
  uvec2 past = min(rectangle_high(a), rectangle_high(b));
  return low.x < past.x && low.y < past.y ? tile_rectangle(low, past) : kNoTiles;
}

NEPHELE_SHARED_END

#endif
