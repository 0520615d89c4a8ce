#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Multiple scattering [Hillaire20 5.5], for every altitude and height of the sun.
#include "shared/atmosphere_tables.h"

layout(local_size_x = 8, local_size_y = 4) in;
layout(set = 0, binding = 0) uniform sampler2D transmittance;
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2D table;
layout(push_constant, scalar) uniform Push { vec3 ground_albedo; };

void main() {
  uvec2 texel = gl_GlobalInvocationID.xy;
  if (texel.x >= kMultiScatteringWidth || texel.y >= kMultiScatteringHeight) return;
  imageStore(table, ivec2(texel), vec4(multi_scattering_texel(transmittance, texel, ground_albedo), 1.0));
}
