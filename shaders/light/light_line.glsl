// How lines are kept (light_lines.comp).
#ifndef NEPHELE_LIGHT_LINE_GLSL
#define NEPHELE_LIGHT_LINE_GLSL

#include "shared/light_lattice.h"

// A cell's entry in the index: 0 where it is not listed, else 1 + its place in the list, with this bit if it is listed
// for its neighbours' sake alone.
const uint kWithoutMatter = 0x80000000u;

const uint kInterleaved = 8u;
const uint kLineEnters = 0x80000000u;         // the upward ordinate comes from outside before this cell
const uint kLineEntersAtFloor = 0x40000000u;  // and there through the lattice's floor
const uint kLineGap = 0x20000000u;            // there is no matter in this cell, or just before it on the line
const uint kLineCell = 0x1fffffffu;

// Lines of a pair: as many as cells in a plane, at most those of the largest.
uint light_lines_at_most(uint side, uint height) { return side * max(side, height); }

// Where a line's first entry is; the next is kInterleaved further on. Counts of lines are multiples of kInterleaved.
uint light_line_first(uint pair, uint line, ivec3 count, uint cell_count) {
  return pair * cell_count + line / kInterleaved * kInterleaved * uint(count.x) + line % kInterleaved;
}

#endif
