#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/ring_grid.h"
#include "shared/types.h"
#include "sources/field.glsl"

// Gives every particle of the field its cell, so that the next step has one thread a particle; and adds the field's
// particles to those of the sources before it.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 1) readonly buffer CellFirst { uint cell_first[]; };
layout(scalar, set = 0, binding = 2) writeonly buffer ParticleCell { uint particle_cell[]; };
layout(scalar, set = 0, binding = 3) writeonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 4) buffer Records { SourceRecord records[]; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  const uint cells = grid_cell_count(constants.frame.field);
  if (i == 0u) {
    const uint count = min(cell_first[cells], constants.capacity);
    records[constants.source].count = count;
    records[constants.source].groups = uvec3((count + 63u) / 64u, 1u, 1u);
    const uint all = records[constants.source].first + count;
    counters.particle_count = all;
    counters.particle_groups.x = (all + 63u) / 64u;
  }
  if (i >= cells) return;
  const uint end = min(cell_first[i + 1u], constants.capacity);
  for (uint slot = cell_first[i]; slot < end; ++slot) particle_cell[slot] = i;
}
