#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/types.h"

// [Yusov14] 5.2 step 1: what stands in each cell of the ring grid. One more count than cells, always 0, so that the
// prefix sum that follows also ends with the total.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
#include "cloud_features.glsl"
#include "shared/cloud_particles.h"
layout(scalar, set = 0, binding = 2) writeonly buffer CellClouds { PackedCellCloud cell_clouds[]; };
layout(scalar, set = 0, binding = 3) writeonly buffer CellFirst { uint cell_first[]; };
layout(scalar, set = 0, binding = 4) buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 5) buffer DistanceCounts { uint distance_counts[kDistanceBins]; };  // particles

void main() {
  const uint i = gl_GlobalInvocationID.x;
  const uint cells = grid_cell_count(frame);
  if (i > cells) return;
  uint count = 0u;
  if (i < cells) {
    const GridCell cell = grid_cell(frame, i);
    if (cell_weight(frame, cell) > 0.0) {
      const CellCloud cloud = cell_cloud(frame, cloud_params(frame), cell);
      count = particle_count(cloud.parts);
      if (count > 0u) {
        cell_clouds[i] = pack_cell(cloud, cell, frame.thickness_m);
        atomicAdd(counters.cell_count, 1u);
        atomicAdd(distance_counts[distance_bin(frame, cell)], count);
      }
    }
  }
  cell_first[i] = count;
}
