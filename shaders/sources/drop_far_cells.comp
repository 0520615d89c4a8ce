#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/ring_grid.h"
#include "sources/field.glsl"

// Empties the cells that find no room: the farthest, which show the least. Runs only when there are any.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 1) readonly buffer Counters { FieldCounters counters; };
layout(scalar, set = 0, binding = 2) buffer CellCounts { uint cell_counts[]; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= grid_cell_count(constants.frame.field) || cell_counts[i] == 0u) return;
  if (distance_bin(constants.frame, grid_cell(constants.frame.field, i)) >= counters.kept_distance_bins)
    cell_counts[i] = 0u;
}
