#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/ring_grid.h"
#include "sources/field.glsl"

// Lists the cells that may get a weight while the camera stays in its finest cell: some three fifths of all, the rest
// lies under finer rings or beyond the view. The order is free.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 1) writeonly buffer CellList { uint cell_list[]; };
layout(scalar, set = 0, binding = 2) buffer Counters { FieldCounters counters; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= grid_cell_count(constants.frame.field)) return;
  if (!cell_may_show(constants.frame.field, grid_cell(constants.frame.field, i))) return;
  const uint place = atomicAdd(counters.found_cell_count, 1u);
  cell_list[place] = i;
  if (place % 64u == 0u) atomicMax(counters.found_cell_groups.x, place / 64u + 1u);
}
