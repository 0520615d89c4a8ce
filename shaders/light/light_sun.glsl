// Sunlight in a window. The including shader declares LightLattice lattice, FrameConstants frame, kAir and
// sampler2D transmittance.
#ifndef NEPHELE_LIGHT_SUN_GLSL
#define NEPHELE_LIGHT_SUN_GLSL

#include "kit/light_through_air.glsl"

// Before any cloud, at a place counted from the reference point; z = altitude.
vec3 sun_irradiance(vec3 p_m) {
  // The local vertical leans with the way from the reference point.
  const float sine = dot(frame.sun_direction, normalize(vec3(p_m.xy, kPlanetRadiusM + p_m.z)));
  if (kAir) return sun_irradiance_at(transmittance, frame, p_m.z, sine);
  return frame.sun_irradiance * sun_visibility(max(0.0, p_m.z), sine);
}

#endif
