#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/ring_grid.h"

// Lists the cells that may get a weight while the camera stays in its finest cell: some three fifths of all, the rest
// lies under finer rings or beyond the view. The order is free.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(scalar, set = 0, binding = 1) writeonly buffer CellList { uint cell_list[]; };
layout(scalar, set = 0, binding = 2) buffer Counters { FrameCounters counters; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= grid_cell_count(frame)) return;
  if (!cell_may_show(frame, grid_cell(frame, i))) return;
  const uint place = atomicAdd(counters.found_cell_count, 1u);
  cell_list[place] = i;
  if (place % 64u == 0u) atomicMax(counters.found_cell_groups.x, place / 64u + 1u);
}
