#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/ring_grid.h"
#include "shared/types.h"
#include "sources/field.glsl"

// How far out the cells find room for all their particles, and where in the particle buffer these begin: after those
// of the sources before. One thread: a sum over kDistanceBins counts.
layout(local_size_x = 1) in;

layout(scalar, set = 0, binding = 1) readonly buffer DistanceCounts { uint distance_counts[kDistanceBins]; };
layout(scalar, set = 0, binding = 2) writeonly buffer FieldCounts { FieldCounters field_counters; };
layout(scalar, set = 0, binding = 3) buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 4) writeonly buffer Records { SourceRecord records[]; };

void main() {
  uint demand = 0u;
  uint kept = 0u;
  for (uint bin = 0u; bin < kDistanceBins; ++bin) {
    demand += distance_counts[bin];
    if (demand <= constants.capacity) kept = bin + 1u;
  }
  field_counters.kept_distance_bins = kept;
  const uint groups = (grid_cell_count(constants.frame.field) + 63u) / 64u;
  field_counters.thin_groups = uvec3(kept < kDistanceBins ? groups : 0u, 1u, 1u);
  records[constants.source].first = counters.particle_count;
  records[constants.source].demand = demand;
  counters.particle_demand += demand;
}
