#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/types.h"

// [Yusov14] 5.2 step 2: the particles of the occupied cells, one thread each.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
#include "sources/cloud_features.glsl"
#include "shared/cell_particles.h"
#include "shared/ellipsoid.h"
layout(scalar, set = 0, binding = 2) readonly buffer CellClouds { PackedCellCloud cell_clouds[]; };
layout(scalar, set = 0, binding = 3) readonly buffer CellFirst { uint cell_first[]; };
layout(scalar, set = 0, binding = 4) readonly buffer ParticleCell { uint particle_cell[]; };
layout(scalar, set = 0, binding = 5) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 6) writeonly buffer Particles { Particle particles[]; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i < frame.listed_particle_count || i >= counters.particle_count) return;
  const uint cell_index = particle_cell[i];
  const GridCell cell = grid_cell(frame, cell_index);
  const CellCloud cloud = unpack_cell(cell_clouds[cell_index], cell, frame.thickness_m);
  const uint slot = i - frame.listed_particle_count - cell_first[cell_index];
  const CloudParticle made = cell_particle(frame, cloud_params(frame), cell, cloud, slot);
  particles[i] = render_particle(frame, cell, made);
}
