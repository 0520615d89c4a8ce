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
layout(scalar, set = 0, binding = 5) uniform Boundary { vec4 boundary[2u * kLightOrdinates]; };
layout(scalar, set = 0, binding = 6) writeonly buffer Mean { uvec2 mean[]; };
layout(scalar, set = 0, binding = 7) writeonly buffer Exits { vec4 exits[]; };
WORDS(8, beam);  // radiance of the beam's first scattering, were it the same in all directions
layout(push_constant, scalar) uniform Push {
  uint cell_count;
  uint lines_at_most;  // of a pair
  float scale;         // of extinction: without the forward peak
  float scaled_asymmetry;
  vec3 travel;  // of sunlight
};

// (1 + exp(-s)) / 2 - f over s, with f = mean_transmittance(s).
float slope_share(float s, float f) {
  return s < 0.1 ? s * (1.0 / 12.0 - s * (1.0 / 24.0)) : (1.0 - 0.5 * s * f - f) / s;
}

// What a cell scatters into a direction, the beam's first scattering aside.
vec4 source_of(uint cell, vec3 direction) {
  const LightSource q = unpack_light_source(texel_at(source, 2u * cell), texel_at(source, 2u * cell + 1u));
  return q.even + direction.x * q.x + direction.y * q.y + direction.z * q.z;
}

// Light of an ordinate through a cell. On the way the source rises by `rise`, and what it has of the beam falls as the
// beam does. Were the source even in it, a cell that is optically thick would let light through too easily: a wave's
// second derivative would count by the depth instead of by its square [Larsen, Morel and Miller 1987].
// along: cosine between the ordinate and the sunlight.
void pass_cell(uint cell, vec4 own, vec4 rise, float length_m, float along, uint ordinate, inout vec4 radiance) {
  const float depth = scale * float_at(sigma, cell) * length_m;
  const float once = float_at(beam, cell) * (1.0 + 3.0 * scaled_asymmetry * along);
  own.x += once;
  rise.x -= 2.0 * once * tanh(0.5 * depth * along);
  // Cells without matter have no source; what stands there is of another solve.
  own = depth > 0.0 ? own : radiance;
  rise = depth > 0.0 ? clamp(rise, -2.0 * abs(own), 2.0 * abs(own)) : vec4(0.0);  // changes sign at neither end
  const float f = mean_transmittance(depth);
  const vec4 mean_radiance = own + f * (radiance - own) - slope_share(depth, f) * rise;
  mean[ordinate * cell_count + cell] = pack_light(mean_radiance);
  radiance += depth * (own - mean_radiance);
}

void main() {
  const uint pair = gl_WorkGroupID.y, line = gl_GlobalInvocationID.x;
  const ivec3 count = pairs[pair].count;
  if (line >= uint(count.y * count.z)) return;
  const vec3 up = pairs[pair].direction;
  const float along = dot(up, travel);
  const float length_m = pairs[pair].length_m;
  const uint slot = pair * lines_at_most + line;
  const uint first = light_line_first(pair, line, count, cell_count);
  const uint end = first + kInterleaved * word_at(lengths, slot);
  const vec4 from_below = boundary[2u * pair], from_above = boundary[2u * pair + 1u];
  // The source rises as it does between the neighbours on the line, if matter is in both.
  vec4 radiance = from_below, before = vec4(0.0), own = vec4(0.0);
  uint entry = end > first ? word_at(lines, first) : 0u;
  if (end > first) own = source_of(entry & kLineCell, up);
  bool follows = false;
  for (uint i = first; i < end; i += kInterleaved) {
    const uint next = i + kInterleaved < end ? word_at(lines, i + kInterleaved) : kLineGap | entry;
    const bool leads = (next & (kLineEnters | kLineGap)) == 0u;
    const vec4 after = source_of(next & kLineCell, up);
    radiance = (entry & kLineEnters) != 0u ? from_below : radiance;
    pass_cell(entry & kLineCell, own, follows && leads ? 0.5 * (after - before) : vec4(0.0), length_m, along, 2u * pair,
              radiance);
    before = own;
    own = after;
    follows = leads;
    entry = next;
  }
  radiance = from_above;
  const vec4 without_clouds = boundary[kLightOrdinates + 2u * pair + 1u];
  vec4 exit = vec4(0.0);
  if (end > first) entry = word_at(lines, end - kInterleaved);
  if (end > first) own = source_of(entry & kLineCell, -up);
  follows = false;
  for (uint i = end; i > first; i -= kInterleaved) {
    const uint next = i - kInterleaved > first ? word_at(lines, i - 2u * kInterleaved) : entry;
    const bool leads = (entry & (kLineEnters | kLineGap)) == 0u;
    const vec4 after = source_of(next & kLineCell, -up);
    pass_cell(entry & kLineCell, own, follows && leads ? 0.5 * (after - before) : vec4(0.0), length_m, -along,
              2u * pair + 1u, radiance);
    exit += (entry & kLineEntersAtFloor) != 0u ? radiance - without_clouds : vec4(0.0);
    radiance = (entry & kLineEnters) != 0u ? from_above : radiance;
    before = own;
    own = after;
    follows = leads;
    entry = next;
  }
  exits[slot] = exit;
}
