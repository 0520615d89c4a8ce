// The atmosphere as other passes see it: sunlight and sky light at an altitude. The including shader declares the two
// tables (AtmosphereTables::transmittance and ::sky_irradiance, linear and clamped) and hands them over.
#ifndef NEPHELE_LIGHT_THROUGH_AIR_GLSL
#define NEPHELE_LIGHT_THROUGH_AIR_GLSL

#include "shared/atmosphere_tables.h"
#include "shared/types.h"

// Irradiance perpendicular to the sun's rays: after the air, before any cloud. sun_cos_zenith is the sun's at that
// place (dot(local vertical, sun_direction)).
vec3 sun_irradiance_at(sampler2D transmittance, FrameConstants frame, float altitude_m, float sun_cos_zenith) {
  if (frame.atmosphere_enabled == 0u)
    return frame.sun_irradiance * sun_visibility(max(0.0, altitude_m), sun_cos_zenith);
  return frame.sun_irradiance * sun_transmittance(transmittance, altitude_m, sun_cos_zenith);
}

// Mean radiance of the sky above a place and of air and ground below it.
void mean_radiance_at(sampler2D sky_irradiance, FrameConstants frame, float altitude_m, float sun_cos_zenith,
                      out vec3 above, out vec3 below) {
  above = vec3(0.0);
  below = vec3(0.0);
  if (frame.atmosphere_enabled == 0u) return;
  above = frame.sun_irradiance * mean_radiance_above(sky_irradiance, altitude_m, sun_cos_zenith);
  below = frame.sun_irradiance * mean_radiance_below(sky_irradiance, altitude_m, sun_cos_zenith);
}

// Cosine of the sun's zenith angle at a point of render space.
float sun_cos_zenith_at(vec3 p_render_m, FrameConstants frame) {
  vec3 from_center = vec3(p_render_m.xy, p_render_m.z + frame.camera_grid_m.z + kPlanetRadiusM);
  return dot(from_center, frame.sun_direction) * inversesqrt(dot(from_center, from_center));
}

#endif
