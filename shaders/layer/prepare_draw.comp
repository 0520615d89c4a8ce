// Gathers what shading needs of each visible particle, in drawing order, and evaluates once a particle what is the
// same for all its pixels: the map into reference space, the sun's direction there, the sky's light.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/cloud_light.h"
#include "shared/ellipsoid.h"
#include "shared/flat_base.h"
#include "kit/texels.glsl"
#include "shared/world.h"
#include "kit/light_through_air.glsl"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
PARTICLES(1, particles);
layout(scalar, set = 0, binding = 2) readonly buffer Visible { uint visible[]; };
layout(scalar, set = 0, binding = 3) readonly buffer DrawOrder { uint draw_order[]; };
PARTICLE_LIGHTS(4, lights);
layout(scalar, set = 0, binding = 5) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 6) writeonly buffer DrawParticles { DrawParticle draw_particles[]; };
layout(set = 0, binding = 7) uniform sampler2D sky_irradiance;
layout(scalar, set = 0, binding = 8) readonly buffer Records { SourceRecord records[]; };
layout(push_constant, scalar) uniform Push { float mean_fill; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= counters.visible_count) return;
  const uint slot = draw_order[i];
  const Particle p = particle_at(particles, visible[slot]);
  const ParticleLight light = particle_light_at(lights, slot);
  const bool homogeneous = (p.flags & kParticleHomogeneous) != 0u;

  DrawParticle d;
  const vec4 orientation = unpack_orientation(p.orientation);
  for (int axis = 0; axis < 3; ++axis) {
    vec3 e = vec3(0.0);
    e[axis] = 1.0;
    d.reference_from_render[axis] =
        quaternion_rotate_inverse(orientation, local_from_render(e, p.yaw_rad) / p.radius_m);
  }
  d.center_m = p.center_m;
  d.extinction_per_m = p.extinction_per_m;
  d.light_direction = normalize(d.reference_from_render * -frame.sun_direction);
  const float mean_radius_m = pow(p.radius_m.x * p.radius_m.y * p.radius_m.z, 1.0 / 3.0);
  d.optical_radius = p.extinction_per_m * mean_radius_m * (homogeneous ? 1.0 : mean_fill);
  d.sun_irradiance = light.sun_irradiance;
  d.tau_sun = light.tau_sun;
  d.tau_near = light.tau_near;
  d.tau_behind = light.tau_behind;
  d.tau_gradient_per_m = light.tau_gradient_per_m;
  d.base_m = p.base_m;
  d.flags = p.flags;
  d.radiance_per_sr = p.radiance_per_sr;
  // At its very centre it has no side.
  d.outward = outward_factor(-dot(light.openness, p.center_m) / max(length(p.center_m), mean_radius_m), frame.phase_g);
  const float altitude = altitude_m(p.center_m, frame.camera_grid_m.z);
  mean_radiance_at(sky_irradiance, frame, altitude, sun_cos_zenith_at(p.center_m, frame), d.sky_up_radiance,
                   d.sky_down_radiance);
  d.sky_down_radiance *= 1.0 - kGroundShadow * frame.ground_cover;
  if (has_base(p.base_m)) {
    const float thickness_m = max(p.top_m - p.base_m, 0.0);
    const float extinction_per_m = records[p.flags >> kParticleSourceShift].extinction_per_m;  // of its own cloud
    d.sky_share =
        slab_share_above(extinction_per_m * (p.top_m - altitude), extinction_per_m * thickness_m, frame.phase_g);
    d.sky_share_per_m = slab_share_per_depth(extinction_per_m * thickness_m, frame.phase_g) * extinction_per_m;
  } else {  // whose cloud it is part of is not known: as much as a surface sees that faces away from its neighbours
    d.sky_share = 0.5 + 0.5 * light.openness.z;
    d.sky_share_per_m = 0.0;
  }
  draw_particles[i] = d;
}
