#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Aerial perspective: light scattered in, and transmittance, between the camera and each distance of every ray.
// A thread walks one ray from slice to slice.
#include "shared/atmosphere_tables.h"
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, scalar) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 1) uniform sampler2D transmittance;
layout(set = 0, binding = 2) uniform sampler2D multi_scattering;
layout(set = 0, binding = 3, rgba32f) uniform writeonly image3D aerial_light;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image3D aerial_transmittance;

void main() {
  uvec2 texel = gl_GlobalInvocationID.xy;
  if (texel.x >= kAerialAzimuths || texel.y >= kAerialElevations) return;
  float altitude_m = max(0.0, frame.camera_grid_m.z);
  ViewRay ray = aerial_ray(texel, altitude_m, frame.sun_direction.z);
  float near_m = aerial_near_m(altitude_m, ray.cos_zenith);
  float reach_m = aerial_reach_m(altitude_m);
  float phase = aerosol_phase(ray.sun_cos_view);
  ViewMarch march = begin_march(ray, near_m);
  for (uint slice = 0u; slice < kAerialDistances; ++slice) {
    if (slice > 0u) {
      float distance_m = distance_from_unit(unit_from_index(slice, kAerialDistances), near_m, reach_m);
      march_to(transmittance, multi_scattering, ray, distance_m, march);
    }
    ivec3 at = ivec3(texel, slice);
    imageStore(aerial_light, at, vec4(march.smooth_light + march.aerosol_light * phase, 1.0));
    imageStore(aerial_transmittance, at, vec4(march.transmittance, 1.0));
  }
}
