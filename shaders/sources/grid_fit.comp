#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/ring_grid.h"

// How far out the cells find room for all their particles, after those that the scene lists. One thread: a sum over
// kDistanceBins counts.
layout(local_size_x = 1) in;

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(scalar, set = 0, binding = 1) readonly buffer DistanceCounts { uint distance_counts[kDistanceBins]; };
layout(scalar, set = 0, binding = 2) buffer Counters { FrameCounters counters; };
layout(push_constant) uniform Push { uint capacity; };

void main() {
  const uint room = capacity - min(frame.listed_particle_count, capacity);
  uint demand = 0u;
  uint kept = 0u;
  for (uint bin = 0u; bin < kDistanceBins; ++bin) {
    demand += distance_counts[bin];
    if (demand <= room) kept = bin + 1u;
  }
  counters.particle_demand = frame.listed_particle_count + demand;
  counters.kept_distance_bins = kept;
  counters.thin_groups = uvec3(kept < kDistanceBins ? (grid_cell_count(frame) + 63u) / 64u : 0u, 1u, 1u);
}
