#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Carries light along the lines of one kind of axis: each thread takes a line up, and the same line down. Writes the
// mean radiance of each ordinate in each cell, and how much what leaves through the floor differs from what would
// without any cloud.
#include "shared/light_lattice.h"
#include "light/light_line.glsl"
#include "light/light_source.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) readonly buffer Pairs { LightPair pairs[]; };
WORDS(1, lines);
WORDS(2, lengths);
WORDS(3, sigma);
TEXELS(4, source);
layout(scalar, set = 0, binding = 5) readonly buffer Boundary { vec4 boundary[]; };
layout(scalar, set = 0, binding = 6) writeonly buffer Mean { uvec2 mean[]; };
layout(scalar, set = 0, binding = 7) writeonly buffer Exits { vec4 exits[]; };
layout(push_constant, scalar) uniform Push {
  uint cell_count;
  uint lines_at_most;  // of a pair
  float scale;         // of extinction: without the forward peak
};

// Light of a direction through a cell. The source is constant in it; a slope of it between the neighbours on the line
// changes the picture by less than a thousandth (docs/light.md).
void pass_cell(uint cell, vec3 direction, float length_m, uint ordinate, inout vec4 radiance) {
  const LightSource q = unpack_light_source(texel_at(source, 2u * cell), texel_at(source, 2u * cell + 1u));
  const float depth = scale * float_at(sigma, cell) * length_m;
  // Cells without matter have no source; what stands there is of another solve.
  const vec4 own = depth > 0.0 ? q.even + direction.x * q.x + direction.y * q.y + direction.z * q.z : radiance;
  const float f = mean_transmittance(depth);
  const vec4 excess = radiance - own;
  mean[ordinate * cell_count + cell] = pack_light(own + f * excess);
  radiance -= f * depth * excess;
}

void main() {
  const uint pair = gl_WorkGroupID.y, line = gl_GlobalInvocationID.x;
  const ivec3 count = pairs[pair].count;
  if (line >= uint(count.y * count.z)) return;
  const vec3 direction = pairs[pair].direction;
  const float length_m = pairs[pair].length_m;
  const uint slot = pair * lines_at_most + line;
  const uint first = light_line_first(pair, line, count, cell_count);
  const uint end = first + kInterleaved * word_at(lengths, slot);
  const vec4 from_below = boundary[2u * pair], from_above = boundary[2u * pair + 1u];
  vec4 radiance = from_below;
  uint i = first;
  for (; i < end; i += kInterleaved) {
    const uint entry = word_at(lines, i);
    radiance = (entry & kLineEnters) != 0u ? from_below : radiance;
    pass_cell(entry & kLineCell, direction, length_m, 2u * pair, radiance);
  }
  radiance = from_above;
  vec4 exit = vec4(0.0);
  while (i > first) {
    i -= kInterleaved;
    const uint entry = word_at(lines, i);
    pass_cell(entry & kLineCell, -direction, length_m, 2u * pair + 1u, radiance);
    exit += (entry & kLineEntersAtFloor) != 0u ? radiance - from_above : vec4(0.0);
    radiance = (entry & kLineEnters) != 0u ? from_above : radiance;
  }
  exits[slot] = exit;
}
