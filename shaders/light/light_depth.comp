#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Optical depth towards the sun from the middle of each listed cell.
#include "light/light_lattice_buffer.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
WORDS(1, listed);
layout(scalar, set = 0, binding = 2) readonly buffer Count {
  uvec3 groups;
  uint listed_count;
};
layout(set = 0, binding = 3) uniform sampler3D extinction;
layout(scalar, set = 0, binding = 4) writeonly buffer Depths { float depths[]; };
layout(push_constant, scalar) uniform Push { uint level; };

#include "light/light_depth_walk.glsl"

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= listed_count) return;
  const vec3 at_m = light_cell_middle(level, light_cell_place(word_at(listed, i)));
  depths[i] = depth_to_sun(level, at_m);
}
