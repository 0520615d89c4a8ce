#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/ring_grid.h"
#include "sources/field.glsl"

// The particles of the cells that have a weight in this frame. One more count than cells, always 0, so that the prefix
// sum that follows also ends with the total.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 1) readonly buffer CellCounts { uint cell_counts[]; };
layout(scalar, set = 0, binding = 2) writeonly buffer CellFirst { uint cell_first[]; };
layout(scalar, set = 0, binding = 3) buffer Counters { FieldCounters counters; };
layout(scalar, set = 0, binding = 4) buffer DistanceCounts { uint distance_counts[kDistanceBins]; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  const uint cells = grid_cell_count(constants.frame.field);
  if (i > cells) return;
  uint count = i < cells ? cell_counts[i] : 0u;
  if (count > 0u) {
    const GridCell cell = grid_cell(constants.frame.field, i);
    if (cell_weight(constants.frame, cell) <= 0.0)
      count = 0u;
    else {
      atomicAdd(counters.cell_count, 1u);
      atomicAdd(distance_counts[distance_bin(constants.frame, cell)], count);
    }
  }
  cell_first[i] = count;
}
