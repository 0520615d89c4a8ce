#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Lists the cells with matter and their neighbours. The extinction of all cells goes into the volume that depths are
// found in.
#include "light/light_lattice_buffer.glsl"
#include "light/light_line.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
WORDS(1, cells);
WORDS(2, places);  // how many listed cells there are before
layout(scalar, set = 0, binding = 3) writeonly buffer Listed { uint listed[]; };
layout(scalar, set = 0, binding = 4) writeonly buffer Index { uint index_of[]; };  // as in light_line.glsl
layout(scalar, set = 0, binding = 5) writeonly buffer Sigma { float sigma[]; };    // 1/m
layout(scalar, set = 0, binding = 6) buffer Count {
  uvec3 groups;
  uint listed_count;
};
layout(set = 0, binding = 7, r16f) writeonly uniform image3D extinction;
layout(push_constant, scalar) uniform Push { uint level; };

#include "kit/light_lattice.glsl"

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= light_cell_count(lattice.side, lattice.height)) return;
  const uint amount = word_at(cells, i), place = word_at(places, i);
  const bool is_listed =
      (i + 1u < light_cell_count(lattice.side, lattice.height) ? word_at(places, i + 1u) : listed_count) > place;
  const float own = float(amount) * (1.0 / kLightFixedPoint);
  index_of[i] = is_listed ? (place + 1u) | (amount > 0u ? 0u : kWithoutMatter) : 0u;
  if (is_listed) {
    listed[place] = i;
    sigma[place] = own;
  }
  const ivec3 at = light_cell_place(i);
  const ivec3 to = ivec3(at.xy, int(lattice.levels[level].extinction_plane) + at.z);
  imageStore(extinction, to, vec4(own));
  if (at.z == 0) imageStore(extinction, to - ivec3(0, 0, 1), vec4(0.0));  // the empty planes below and above
  if (at.z + 1 == int(lattice.height)) imageStore(extinction, to + ivec3(0, 0, 1), vec4(0.0));
  if (i == 0u) groups = uvec3((listed_count + 63u) / 64u, 1u, 1u);
}
