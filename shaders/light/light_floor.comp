#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// The beam, in the scaled sense, that leaves the lattice through its floor, at evenly spread places. Where the sun is
// below the horizon there is none.
#include "light/light_lattice_buffer.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 1) uniform sampler3D extinction;
layout(scalar, set = 0, binding = 2) writeonly buffer Floor { float beam_at_floor[]; };
layout(push_constant, scalar) uniform Push {
  uint level;
  uint across;  // places along a side
};

#include "light/light_depth_walk.glsl"

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= across * across) return;
  const float side_m = float(lattice.side) * lattice.levels[level].cell_m;
  const vec2 at = (vec2(i % across, i / across) + 0.5) / float(across);
  const vec3 from_m = vec3(lattice.levels[level].corner_m + at * side_m, lattice.lowest_m + 1e-3 * lattice.layer_m);
  beam_at_floor[i] = lattice.sun_direction.z > 0.0 ? exp(-(1.0 - lattice.forward) * depth_to_sun(level, from_m)) : 0.0;
}
