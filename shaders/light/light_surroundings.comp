#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// What clouds see around them without each other, from the middle of their layer: for each of many directions the
// radiance of sky or air, the share of the ground's own radiance that comes through, and how open cells lie towards it
// compared with the ordinate that stands for it.
#include "light/light_lattice_buffer.glsl"
#include "light/light_openness.glsl"
#include "shared/atmosphere_tables.h"
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(constant_id = 0) const bool kAir = true;  // false: dummies are bound as the tables
layout(scalar, set = 0, binding = 1) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 2) uniform sampler2D transmittance;
layout(set = 0, binding = 3) uniform sampler2D multi_scattering;
layout(scalar, set = 0, binding = 4) readonly buffer Directions { vec3 directions[]; };  // to look in
layout(scalar, set = 0, binding = 5) writeonly buffer Surroundings { LightSeen seen[]; };
layout(scalar, set = 0, binding = 6) readonly buffer Ranges { uint first_of[]; };  // directions of each ordinate
layout(scalar, set = 0, binding = 7) readonly buffer Pairs { LightPair pairs[]; };
layout(scalar, set = 0, binding = 8) readonly buffer Openness { vec2 openness[]; };  // parts of light_openness.comp
layout(push_constant, scalar) uniform Push {
  uint count;
  uint openness_parts;
};

const uint kSteps = 16u;
const float kLeastOpenness = 1e-4, kMostOpen = 4.0;  // where cells hardly see anything, their ratio means nothing

float ring_openness(uint ring) {
  vec2 sum = vec2(0.0);
  for (uint i = 0u; i < openness_parts; ++i) sum += openness[ring * openness_parts + i];
  return sum.y > 0.0 ? sum.x / sum.y : 1.0;
}
float openness_towards(float cosine) {
  const float ring = openness_ring(cosine);
  const uint below = min(uint(ring), kOpennessRings - 2u);
  return mix(ring_openness(below), ring_openness(below + 1u), ring - float(below));
}

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  const vec3 direction = directions[i];
  const float altitude_m = max(lattice.lowest_m + 0.5 * float(lattice.height) * lattice.layer_m, 1.0);
  const float horizon = horizon_cosine(altitude_m);
  const bool below = direction.z < horizon;
  uint ordinate = 0u;
  while (first_of[ordinate + 1u] <= i) ++ordinate;
  const float ordinate_z = pairs[ordinate / 2u].direction.z;
  const float open = openness_towards(direction.z) /
                     max(openness_towards(ordinate % 2u == 0u ? -ordinate_z : ordinate_z), kLeastOpenness);
  seen[i] = LightSeen(vec3(0.0), below && frame.ground_enabled != 0u ? vec3(1.0) : vec3(0.0), min(open, kMostOpen));
  if (!kAir) return;
  vec3 look = direction;
  const bool ground = below && frame.ground_enabled != 0u;
  if (below && !ground) {  // there is no ground: the horizon mirrors the sky, as the composite draws it
    const float mu = elevation_from_unit(unit_from_elevation(look.z, horizon, true), horizon, false);
    look = vec3(look.xy * sqrt((1.0 - mu * mu) / max(1e-12, 1.0 - look.z * look.z)), mu);
  }
  ViewRay ray;
  ray.altitude_m = altitude_m;
  ray.cos_zenith = look.z;
  ray.sun_cos_zenith = frame.sun_direction.z;
  ray.sun_cos_view = dot(look, frame.sun_direction);
  const ViewMarch march =
      march_segment(transmittance, multi_scattering, ray, air_segment(altitude_m, look.z, ground), kSteps);
  seen[i].radiance =
      frame.sun_irradiance * (march.smooth_light + march.aerosol_light * aerosol_phase(ray.sun_cos_view));
  if (ground) seen[i].of_ground = march.transmittance;
}
