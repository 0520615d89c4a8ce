#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Which cells are listed: those with matter, and their neighbours, for filtered look-ups at a cloud's skin. Three
// steps, each of which spreads along one axis by a cell.
#include "light/light_lattice_buffer.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
WORDS(1, from);
layout(scalar, set = 0, binding = 2) writeonly buffer To { uint to[]; };
layout(push_constant, scalar) uniform Push { uint axis; };

#include "kit/light_lattice.glsl"

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= light_cell_count(lattice.side, lattice.height)) return;
  const int at = light_cell_place(i)[axis], last = int(axis == 2u ? lattice.height : lattice.side) - 1;
  const uint stride = axis == 0u ? 1u : (axis == 1u ? lattice.side : lattice.side * lattice.side);
  const uint before = word_at(from, at > 0 ? i - stride : i), after = word_at(from, at < last ? i + stride : i);
  to[i] = (before | word_at(from, i) | after) > 0u ? 1u : 0u;
}
