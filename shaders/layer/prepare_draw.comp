// Gathers what shading needs of each visible particle, in drawing order, and evaluates once a particle what is the
// same for all its pixels: the map into reference space, the sun's direction there, the sky's light.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/cloud_light.h"
#include "shared/ellipsoid.h"
#include "shared/flat_base.h"
#include "kit/texels.glsl"
#include "shared/light_lattice.h"
#include "shared/structure.h"
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
layout(scalar, set = 0, binding = 9) readonly buffer Lattice { LightLattice lattice; };
layout(set = 0, binding = 10) uniform sampler3D light_radiance;
layout(push_constant, scalar) uniform Push { float mean_fill; };
layout(constant_id = 20) const bool kLightField = true;

#include "kit/light_lattice.glsl"

vec3 field_place(uint level, vec3 at_m, float planes) {
  return light_volume_coordinates(light_cell_position(level, at_m), lattice.levels[level].radiance_plane, planes);
}

// Which level of the light field holds at the particle, and where in it the particle is.
void place_in_field(vec3 center_m, float own_depth, float radius_m, inout DrawParticle d) {
  const vec3 at_m = grid_from_render(center_m, vec3(0.0, 0.0, frame.camera_grid_m.z));
  const float distance_m = max(abs(at_m.x), abs(at_m.y));
  uint level = 0u;
  while (level + 1u < lattice.level_count && distance_m >= lattice.levels[level].reach_m) ++level;
  // Matter that a level has no cell for, which the levels of detail may leave, is lit as in a coarser one.
  const float planes = float(textureSize(light_radiance, 0).z);
  vec3 place = field_place(level, at_m, planes);
  while (level + 1u < lattice.level_count && textureLod(light_radiance, place, 0.0).a <= 0.0)
    place = field_place(++level, at_m, planes);
  d.own_depth_share = own_depth * near_camera_share(length(center_m) - radius_m, lattice.levels[0].cell_m);
  d.field_per_m = vec2(1.0 / (lattice.levels[level].cell_m * float(lattice.side)), 1.0 / (lattice.layer_m * planes));
  d.field_place = place;
}

// Mean radiance of sky above and ground below, mixed by the place in the cloud.
vec3 ambient_radiance(Particle p) {
  const float altitude = altitude_m(p.center_m, frame.camera_grid_m.z);
  vec3 above, below;
  mean_radiance_at(sky_irradiance, frame, altitude, sun_cos_zenith_at(p.center_m, frame), above, below);
  if (!has_base(p.base_m)) return 0.5 * (above + below);  // whose cloud it is part of is not known
  const float extinction_per_m = records[p.flags >> kParticleSourceShift].extinction_per_m;  // of its own cloud
  const float share = slab_share_above(extinction_per_m * (p.top_m - altitude),
                                       extinction_per_m * max(p.top_m - p.base_m, 0.0), frame.phase_g);
  return mix(below, above, clamp(share, 0.0, 1.0));
}

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= counters.visible_count) return;
  const uint slot = draw_order[i];
  const Particle p = particle_at(particles, visible[slot]);
  const ParticleLight light = particle_light_at(lights, slot);
  const bool homogeneous = (p.flags & kParticleHomogeneous) != 0u;

  DrawParticle d;
  const vec4 orientation = unpack_orientation(p.orientation);
  const mat3 to_unit = unit_from_render(p.shape);
  for (int axis = 0; axis < 3; ++axis)
    d.reference_from_render[axis] = quaternion_rotate_inverse(orientation, to_unit[axis]);
  d.center_m = p.center_m;
  d.extinction_per_m = p.extinction_per_m;
  d.light_direction = normalize(d.reference_from_render * -frame.sun_direction);
  const float radius_m = mean_radius_m(p.shape);
  d.optical_radius = p.extinction_per_m * radius_m * (homogeneous ? 1.0 : mean_fill);
  d.sun_irradiance = light.sun_irradiance;
  d.tau_sun = light.tau_sun;
  d.tau_gradient_per_m = light.tau_gradient_per_m;
  d.base_m = p.base_m;
  d.flags = frame.detail_enabled != 0u ? p.flags : p.flags & ~kParticleDetail;
  d.radiance_per_sr = p.radiance_per_sr;
  d.ambient_radiance = vec3(0.0);
  d.field_place = vec3(0.0);
  d.own_depth_share = 0.0;
  d.field_per_m = vec2(0.0);
  d.structure_depth = structure_depth(radius_m, d.flags);
  d.soft_detail = frame.detail_enabled != 0u ? soft_detail(p.flags) : min(soft_detail(p.flags), 0.0);
  if (kLightField)
    place_in_field(p.center_m, light.own_depth, longest_axis_m(p.shape), d);
  else
    d.ambient_radiance = ambient_radiance(p);
  draw_particles[i] = d;
}
