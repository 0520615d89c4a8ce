#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Transmittance to the top of the atmosphere, for every altitude and zenith angle above the horizon.
#include "shared/atmosphere_tables.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba32f) uniform writeonly image2D table;

void main() {
  uvec2 texel = gl_GlobalInvocationID.xy;
  if (texel.x >= kTransmittanceWidth || texel.y >= kTransmittanceHeight) return;
  imageStore(table, ivec2(texel), vec4(transmittance_texel(texel), 1.0));
}
