#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// The light that the air between the camera and each distance does not scatter because it lies in the clouds' shadow:
// what aerial perspective and sky view have too much. Dark beams between light shafts, per unit of the sun's
// irradiance. A thread walks one ray of the camera's frustum. Multiple scattering stays: it comes from all sides.
#include "shared/atmosphere_tables.h"
#include "shared/haze_shadow_volume.h"
#include "shared/types.h"
#include "kit/cloud_shadow_lookup.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(set = 0, binding = 0, scalar) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 1) uniform sampler2D transmittance;
layout(set = 0, binding = 2) uniform sampler2D cloud_shadow_map;
layout(set = 0, binding = 3, rgba32f) uniform writeonly image3D haze_shadow;

#include "kit/camera_rays.glsl"

void main() {
  uvec2 texel = gl_GlobalInvocationID.xy;
  if (texel.x >= kHazeShadowWidth || texel.y >= kHazeShadowHeight) return;
  vec2 unit = vec2(unit_from_index(texel.x, kHazeShadowWidth), unit_from_index(texel.y, kHazeShadowHeight));
  vec3 direction = pixel_direction(unit * vec2(frame.image_size_px), frame.image_size_px);
  float h = max(0.0, frame.camera_grid_m.z);
  float mu = direction.z;
  float nu = dot(direction, frame.sun_direction);
  float rayleigh = rayleigh_phase(nu);
  float aerosol = aerosol_phase(nu);

  vec3 through = vec3(1.0);
  vec3 lost = vec3(0.0);
  float t0 = 0.0;
  float h0 = h;
  AirDensity d0 = air_density(h0);
  // A ray ends where it climbs above the clouds, since nothing is shadowed there, and where it is so far under the
  // ground that the next ray above it has met the ground too: a pixel between the two interpolates.
  float texel_rad = 1.2 * length(pixel_direction(unit * vec2(frame.image_size_px) +
                                                     vec2(0.0, float(frame.image_size_px.y) / float(kHazeShadowHeight)),
                                                 frame.image_size_px) -
                                 direction);
  float sinking = horizon_cosine(h) - mu - texel_rad;
  float bottom_m = frame.ground_enabled != 0u && sinking > 0.0 ? -h * texel_rad / sinking : -1.0e30;
  float uv_scale = light_uv_scale(frame.view_distance_m);
  uint i = 0u;
  bool on = true;
  for (; on && i < kHazeShadowSteps; ++i) {
    if (i % kHazeShadowStepsPerSlice == 0u)
      imageStore(haze_shadow, ivec3(texel, i / kHazeShadowStepsPerSlice), vec4(lost, 1.0));
    float t1 = haze_shadow_distance(float(i + 1u) / float(kHazeShadowSteps), frame.view_distance_m);
    float middle = 0.5 * (t0 + t1);
    float way_up_m = ray_altitude(h, mu, t1);
    float h1 = max(0.0, way_up_m);
    float h_middle = clamp(ray_altitude(h, mu, middle), 0.0, kAtmosphereTopM);
    AirDensity d1 = air_density(h1);
    AirMedium medium = air_medium(h0, d0, h1, d1, h_middle);
    vec3 depth = medium.extinction_per_m * (t1 - t0);
    vec3 step_transmittance = exp(-depth);
    float shadowed = 1.0 - cloud_shadow(cloud_shadow_map, frame.light_from_render, uv_scale, direction * middle);
    if (shadowed > 0.0)
      lost += through * mean_attenuation(depth, step_transmittance) * (t1 - t0) * shadowed *
              (medium.rayleigh_scattering_per_m * rayleigh + medium.aerosol_scattering_per_m * aerosol) *
              sun_transmittance(transmittance, h_middle, cosine_along_ray(h, mu, middle, frame.sun_direction.z, nu));
    through *= step_transmittance;
    on = !(h0 > frame.clouds_top_m && h1 > h0) && way_up_m > bottom_m;
    t0 = t1;
    h0 = h1;
    d0 = d1;
  }
  const uint reached = (i + kHazeShadowStepsPerSlice - 1u) / kHazeShadowStepsPerSlice;
  for (uint slice = reached; slice < kHazeShadowDepth; ++slice)
    imageStore(haze_shadow, ivec3(texel, slice), vec4(lost, 1.0));
}
