#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// [Yusov14] 5.2 step 1: what stands in each listed cell of the ring grid, wherever in its finest cell the camera is.
layout(local_size_x = 64) in;

#define FIELD_IN_STORAGE
#define READS_WEATHER 4
#define READS_NEAR 7
#include "sources/cloud_features.glsl"
#include "shared/cell_particles.h"
layout(scalar, set = 0, binding = 2) writeonly buffer CellClouds { PackedCellCloud cell_clouds[]; };
layout(scalar, set = 0, binding = 3) writeonly buffer CellCounts { uint cell_counts[]; };  // particles

layout(scalar, set = 0, binding = 5) readonly buffer CellList { uint cell_list[]; };
layout(scalar, set = 0, binding = 6) readonly buffer Counters { FieldCounters counters; };

void main() {
  if (gl_GlobalInvocationID.x >= counters.found_cell_count) return;
  const uint i = cell_list[gl_GlobalInvocationID.x];
  const CloudField field = constants.frame.field;
  const GridCell cell = grid_cell(field, i);
  const CellCloud cloud = cell_cloud(field, cloud_params(field), cell);
  const uint count = particle_count(cloud);
  if (count > 0u) cell_clouds[i] = pack_cell(cloud, cell, field.thickness_m);
  cell_counts[i] = count;
}
