// The atmosphere as other passes see it: sunlight and sky light at an altitude. The including shader declares the two
// tables (AtmosphereTables::transmittance and ::sky_irradiance, linear and clamped) and hands them over.
#ifndef NEPHELE_ATMOSPHERE_GLSL
#define NEPHELE_ATMOSPHERE_GLSL

#include "shared/atmosphere_tables.h"
#include "shared/types.h"

// Irradiance perpendicular to the sun's rays: after the air, before any cloud. sun_cos_zenith is the sun's at that
// place (dot(local vertical, sun_direction)).
vec3 sun_irradiance_at(sampler2D transmittance, FrameConstants frame, float altitude_m, float sun_cos_zenith) {
  if (frame.atmosphere_enabled == 0u) return frame.sun_irradiance * sun_visibility(max(0.0, altitude_m), sun_cos_zenith);
  return frame.sun_irradiance * sun_transmittance(transmittance, altitude_m, sun_cos_zenith);
}

// Irradiance of a horizontal surface from the sky above it and from air and ground below it.
void sky_irradiance_at(sampler2D sky_irradiance, FrameConstants frame, float altitude_m, float sun_cos_zenith,
                       out vec3 from_above, out vec3 from_below) {
  from_above = vec3(0.0);
  from_below = vec3(0.0);
  if (frame.atmosphere_enabled == 0u) return;
  from_above = frame.sun_irradiance * sky_irradiance_from_above(sky_irradiance, altitude_m, sun_cos_zenith);
  from_below = frame.sun_irradiance * sky_irradiance_from_below(sky_irradiance, altitude_m, sun_cos_zenith);
}

// Cosine of the sun's zenith angle at a point of render space.
float sun_cos_zenith_at(vec3 p_render_m, FrameConstants frame) {
  vec3 from_center = vec3(p_render_m.xy, p_render_m.z + frame.camera_grid_m.z + kPlanetRadiusM);
  return dot(from_center, frame.sun_direction) * inversesqrt(dot(from_center, from_center));
}

#endif
