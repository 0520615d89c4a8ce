#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// [Yusov14] 5.2 step 2: the particles of the occupied cells, one thread each.
layout(local_size_x = 64) in;

#include "sources/cloud_features.glsl"
#include "shared/cell_particles.h"
#include "shared/ellipsoid.h"
#include "shared/types.h"
layout(scalar, set = 0, binding = 2) readonly buffer CellClouds { PackedCellCloud cell_clouds[]; };
layout(scalar, set = 0, binding = 3) readonly buffer CellFirst { uint cell_first[]; };
layout(scalar, set = 0, binding = 4) readonly buffer ParticleCell { uint particle_cell[]; };
layout(scalar, set = 0, binding = 5) readonly buffer Records { SourceRecord records[]; };
layout(scalar, set = 0, binding = 6) writeonly buffer Particles { Particle particles[]; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  const uint source = constants.source;
  if (i >= records[source].count) return;
  const CloudField field = constants.frame.field;
  const uint cell_index = particle_cell[i];
  const GridCell cell = grid_cell(field, cell_index);
  const CellCloud cloud = unpack_cell(cell_clouds[cell_index], cell, field.thickness_m);
  const CloudParticle made = cell_particle(field, cloud_params(field), cell, cloud, i - cell_first[cell_index]);
  particles[records[source].first + i] = render_particle(constants.frame, cell, made, source);
}
