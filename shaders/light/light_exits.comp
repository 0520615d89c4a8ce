#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Sums of what the lines of each pair let out through the floor, 64 a pair; then 64 of the mean radiance in
// cells with matter, and 64 of these cells' number.
#include "light/light_lattice_buffer.glsl"
#include "light/light_line.glsl"
#include "light/light_source.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 1) readonly buffer Pairs { LightPair pairs[]; };
TEXELS(2, exits);
layout(scalar, set = 0, binding = 3) writeonly buffer Sums { vec4 sums[]; };
TEXELS(4, source);
layout(scalar, set = 0, binding = 5) readonly buffer Count {
  uvec3 groups;
  uint listed_count;
};
WORDS(6, sigma);

void main() {
  const uint pair = gl_WorkGroupID.y, part = gl_GlobalInvocationID.x;
  if (pair == kLightPairs) {
    vec4 of_cells = vec4(0.0);
    float count = 0.0;
    for (uint i = part; i < listed_count; i += 64u) {
      const bool matter = float_at(sigma, i) > 0.0;  // other cells have no source
      of_cells += matter ? unpack_light(texel_at(source, 2u * i).xy) : vec4(0.0);
      count += matter ? 1.0 : 0.0;
    }
    sums[64u * pair + part] = of_cells;
    sums[64u * (pair + 1u) + part] = vec4(count);
    return;
  }
  const uint lines = uint(pairs[pair].count.y * pairs[pair].count.z);
  const uint first = pair * light_lines_at_most(lattice.side, lattice.height);
  vec4 sum = vec4(0.0);
  for (uint line = part; line < lines; line += 64u) sum += vec4_at(exits, first + line);
  sums[64u * pair + part] = sum;
}
