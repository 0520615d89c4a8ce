#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Irradiance and mean radiance of the sky and from below, for every altitude and height of the sun.
#include "shared/atmosphere_tables.h"

layout(local_size_x = 8, local_size_y = 4) in;
layout(set = 0, binding = 0) uniform sampler2D transmittance;
layout(set = 0, binding = 1) uniform sampler2D multi_scattering;
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2D table;
layout(push_constant, scalar) uniform Push { vec3 ground_albedo; };

void main() {
  uvec2 texel = gl_GlobalInvocationID.xy;
  if (texel.x >= kSkyIrradianceWidth || texel.y >= kSkyIrradianceBlocks * kSkyIrradianceHeight) return;
  imageStore(table, ivec2(texel),
             vec4(sky_irradiance_texel(transmittance, multi_scattering, texel, ground_albedo), 1.0));
}
