#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Sums of what the lines of each pair let out through the floor: 64 a pair.
#include "light/light_lattice_buffer.glsl"
#include "light/light_line.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 1) readonly buffer Pairs { LightPair pairs[]; };
TEXELS(2, exits);
layout(scalar, set = 0, binding = 3) writeonly buffer Sums { vec4 sums[]; };

void main() {
  const uint pair = gl_WorkGroupID.y, part = gl_GlobalInvocationID.x;
  const uint lines = uint(pairs[pair].count.y * pairs[pair].count.z);
  const uint first = pair * light_lines_at_most(lattice.side, lattice.height);
  vec4 sum = vec4(0.0);
  for (uint line = part; line < lines; line += 64u) sum += vec4_at(exits, first + line);
  sums[64u * pair + part] = sum;
}
