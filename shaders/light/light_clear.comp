#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Zeros in a level's planes of the volume of radiance and in the empty ones below and above.
#include "light/light_lattice_buffer.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 1, rgba16f) writeonly uniform image3D radiance;
layout(push_constant, scalar) uniform Push { uint level; };

#include "kit/light_lattice.glsl"

void main() {
  const uvec2 at = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(at, uvec2(lattice.side)))) return;
  for (uint z = 0u; z < lattice.height + 2u; ++z)
    imageStore(radiance, ivec3(at, lattice.levels[level].radiance_plane - 1u + z), vec4(0.0));
}
