#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// For each line of each pair of ordinates, the listed cells on it, or those with matter alone, in the order in which
// the upward ordinate meets them. Eight neighbouring lines are interleaved, as eight threads of a CPU read them
// together.
#include "light/light_lattice_buffer.glsl"
#include "light/light_line.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 1) readonly buffer Pairs { LightPair pairs[]; };
WORDS(2, index_of);
layout(scalar, set = 0, binding = 3) writeonly buffer Lines { uint lines[]; };
layout(scalar, set = 0, binding = 4) writeonly buffer Lengths { uint lengths[]; };
layout(push_constant, scalar) uniform Push {
  uint cell_count;
  uint with_skin;  // 1: cells without matter are on the lines too
};

void main() {
  const uint pair = gl_WorkGroupID.y, line = gl_GlobalInvocationID.x;
  const ivec3 count = pairs[pair].count, stride = pairs[pair].stride;
  if (line >= uint(count.y * count.z)) return;
  const ivec2 slope = pairs[pair].slope;
  const bool down = pairs[pair].reversed != 0u;
  const uint axis = pairs[pair].axis;
  int u = int(line) % count.y, v = int(line) / count.y;
  ivec2 before = ivec2(0);
  // The upward ordinate enters the lattice here: at its floor, or at a side.
  uint enters = kLineEnters | (axis == 2u ? kLineEntersAtFloor : 0u);
  const uint first = light_line_first(pair, line, count, cell_count);
  uint length = 0u, gap = 0u;
  for (int k = 0; k < count.x; ++k) {
    const ivec2 shift = ivec2(light_line_shift(slope.x, k), light_line_shift(slope.y, k));
    u += shift.x - before.x;
    v += shift.y - before.y;
    before = shift;
    // The third of the other axes is z where the axis is x or y; an upward ordinate wraps from the top to the floor.
    const bool side = u < 0 || u >= count.y, across = v < 0 || v >= count.z;
    u = u < 0 ? u + count.y : (u >= count.y ? u - count.y : u);
    v = v < 0 ? v + count.z : (v >= count.z ? v - count.z : v);
    if (side || across) enters = kLineEnters | (across && axis != 2u ? kLineEntersAtFloor : 0u);
    const uint index = word_at(index_of, uint((down ? count.x - 1 - k : k) * stride.x + u * stride.y + v * stride.z));
    if (index == 0u || ((index & kWithoutMatter) != 0u && with_skin == 0u)) {
      gap = kLineGap;
      continue;
    }
    const uint skin = (index & kWithoutMatter) != 0u ? kLineGap : 0u;
    lines[first + kInterleaved * length] = ((index & ~kWithoutMatter) - 1u) | enters | gap | skin;
    ++length;
    enters = 0u;
    gap = skin;
  }
  lengths[pair * light_lines_at_most(lattice.side, lattice.height) + line] = length;
}
