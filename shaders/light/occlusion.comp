#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/light.h"
#include "light/occluders.glsl"

// [Yusov14] 5.3 step 2: the sunlight that reaches each visible particle. The depth is sampled at a tetrahedron inside
// the particle rather than at its centre alone, for its mean and its gradient.
// Deviates from the paper: the depth is not low-passed over neighbouring particles (its step 3). With the light field
// the depths of particles near the camera are wanted alone; those of others are 0, and marked so.
layout(local_size_x = 64) in;
layout(constant_id = 0) const bool kAir = true;          // false: a dummy is bound as the transmittance table
layout(constant_id = 20) const bool kLightField = true;  // depths are wanted within near_m of the camera alone
layout(push_constant, scalar) uniform Push { float near_m; };

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
PARTICLES(1, particles);
layout(scalar, set = 0, binding = 2) readonly buffer Visible { uint visible[]; };
layout(scalar, set = 0, binding = 3) readonly buffer Counters { FrameCounters counters; };
OCCLUDERS(4, occluders);
WORDS(5, ranges);  // two words a tile
WORDS(6, list);
layout(scalar, set = 0, binding = 7) writeonly buffer Lights { ParticleLight lights[]; };
layout(set = 0, binding = 8) uniform sampler2D transmittance;

#include "kit/light_through_air.glsl"
#include "light/occlusion_walk.glsl"

vec3 sun_irradiance(vec3 p_render_m) {
  const float altitude = altitude_m(p_render_m, frame.camera_grid_m.z);
  const float cos_zenith = sun_cos_zenith_at(p_render_m, frame);
  if (kAir) return sun_irradiance_at(transmittance, frame, altitude, cos_zenith);
  return frame.sun_irradiance * sun_visibility(max(0.0, altitude), cos_zenith);
}

void main() {
  const uint slot = gl_GlobalInvocationID.x;
  if (slot >= counters.visible_count) return;
  const uint self = visible[slot];
  const Particle particle = particle_at(particles, self);

  ParticleLight light;
  light.sun_irradiance = vec3(0.0);
  light.tau_sun = 0.0;
  light.tau_gradient_per_m = vec3(0.0);
  if ((particle.flags & kParticleEmissive) == 0u) light.sun_irradiance = sun_irradiance(particle.center_m);
  bool wanted = any(greaterThan(light.sun_irradiance, vec3(0.0)));
  if (kLightField) wanted = wanted && length(particle.center_m) - longest_axis_m(particle.shape) < near_m;
  light.own_depth = wanted ? 1.0 : 0.0;
  vec3 points_m[4];
  // Turned by the particle's own orientation, so that no direction is preferred among many.
  const vec4 turn = unpack_orientation(particle.orientation);
  vec3 corners[4];
  for (uint j = 0u; j < 4u; ++j) corners[j] = quaternion_rotate(turn, tetrahedron_corner(j));
  for (uint j = 0u; j < 4u; ++j) points_m[j] = particle_point(particle, kDepthSampleRadius * corners[j]);
  const float depths[4] = depths_to_sun(points_m, self, wanted);
  vec3 slope = vec3(0.0);
  for (uint j = 0u; j < 4u; ++j) {
    light.tau_sun += 0.25 * depths[j];
    slope += depths[j] * corners[j];
  }
  slope *= 0.75 / kDepthSampleRadius;
  light.tau_gradient_per_m = unit_from_render(particle.shape) * slope;
  lights[slot] = light;
}
