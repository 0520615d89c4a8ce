#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/ring_grid.h"

// Gives every particle slot its cell, so that the next step has one thread a particle; and settles how many there are.
// Listed particles come first.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(scalar, set = 0, binding = 1) readonly buffer CellFirst { uint cell_first[]; };
layout(scalar, set = 0, binding = 2) writeonly buffer ParticleCell { uint particle_cell[]; };
layout(scalar, set = 0, binding = 3) buffer Counters { FrameCounters counters; };
layout(push_constant) uniform Push { uint capacity; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  const uint cells = grid_cell_count(frame);
  if (i == 0u) {
    const uint count = min(frame.listed_particle_count + cell_first[cells], capacity);
    counters.particle_count = count;
    counters.particle_groups = uvec3((count + 63u) / 64u, 1u, 1u);
  }
  if (i >= cells) return;
  const uint end = min(frame.listed_particle_count + cell_first[i + 1u], capacity);
  for (uint slot = frame.listed_particle_count + cell_first[i]; slot < end; ++slot) particle_cell[slot] = i;
}
