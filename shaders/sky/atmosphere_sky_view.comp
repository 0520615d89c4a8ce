#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Sky view: light scattered into every ray from the camera's altitude to space or to the ground, and what the ray
// lets through.
#include "shared/atmosphere_tables.h"
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, scalar) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 1) uniform sampler2D transmittance;
layout(set = 0, binding = 2) uniform sampler2D multi_scattering;
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2D sky_smooth;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2D sky_aerosol;
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2D view_transmittance;

void main() {
  uvec2 texel = gl_GlobalInvocationID.xy;
  if (texel.x >= kSkyViewWidth || texel.y >= kSkyViewHeight) return;
  float altitude_m = max(0.0, frame.camera_grid_m.z);
  ViewMarch march = sky_view_texel(transmittance, multi_scattering, texel, altitude_m, frame.sun_direction.z);
  imageStore(sky_smooth, ivec2(texel), vec4(march.smooth_light, 1.0));
  imageStore(sky_aerosol, ivec2(texel), vec4(march.aerosol_light, 1.0));
  if (texel.x == 0u) imageStore(view_transmittance, ivec2(texel), vec4(march.transmittance, 1.0));
}
