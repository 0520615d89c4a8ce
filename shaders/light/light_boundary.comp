#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// The radiance that enters the lattice along each ordinate: the mean over the directions nearest to it of what lies
// there, as far as cells see it. An ordinate that stands for the horizon is eleven degrees steep and passes over clouds
// that hide the horizon; what they hide they replace by light of their own, the mean of all cells'. The ground is as
// bright as the light that the last sweep let through the floor makes it, on average over the window; before the first
// sweep, as the beam and a clear sky make it.
#include "light/light_lattice_buffer.glsl"
#include "light/light_openness.glsl"
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(constant_id = 0) const bool kAir = true;  // false: dummies are bound as the tables
layout(scalar, set = 0, binding = 1) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 2) uniform sampler2D transmittance;
layout(set = 0, binding = 3) uniform sampler2D sky_irradiance;
layout(scalar, set = 0, binding = 4) readonly buffer Surroundings { LightSeen seen[]; };
layout(scalar, set = 0, binding = 5) readonly buffer Ranges { uint first_of[]; };  // directions of each ordinate
layout(scalar, set = 0, binding = 6) readonly buffer Pairs { LightPair pairs[]; };
layout(scalar, set = 0, binding = 7) readonly buffer Sums { vec4 sums[]; };
layout(scalar, set = 0, binding = 8) readonly buffer Floor { float beam_at_floor[]; };
layout(scalar, set = 0, binding = 9) writeonly buffer Boundary { vec4 boundary[]; };  // LightCells::boundary
layout(push_constant, scalar) uniform Push {
  uint floor_count;
  uint swept;  // 1: sums are of a sweep
};

#include "kit/light_through_air.glsl"

vec3 ground_radiance() {
  if (frame.ground_enabled == 0u) return vec3(0.0);
  const float sine = frame.sun_direction.z;
  const vec3 sun =
      kAir ? sun_irradiance_at(transmittance, frame, 0.0, sine) : frame.sun_irradiance * sun_visibility(0.0, sine);
  vec3 sky = vec3(0.0);
  if (kAir) sky = frame.sun_irradiance * sky_irradiance_from_above(sky_irradiance, 0.0, sine);
  float beam = 0.0;
  for (uint i = 0u; i < floor_count; ++i) beam += beam_at_floor[i];
  vec4 more = vec4(0.0);  // irradiance from the clouds, less what they hide
  if (swept != 0u)
    for (uint pair = 0u; pair < kLightPairs; ++pair) {
      vec4 sum = vec4(0.0);
      for (uint part = 0u; part < 64u; ++part) sum += sums[64u * pair + part];
      // A line stands for a tube; length_m times its section is a cell's volume.
      more += 4.0 * kPi * kLightOrdinateShare * lattice.layer_m /
              (pairs[pair].length_m * float(lattice.side * lattice.side)) * sum;
    }
  const vec3 irradiance =
      sun * (max(sine, 0.0) * beam / float(floor_count) + more.x) + sky + frame.light_unit * more.yzw;
  return frame.ground_albedo / kPi * max(irradiance, vec3(0.0));
}

void main() {
  const uint ordinate = gl_GlobalInvocationID.x;
  if (ordinate >= kLightOrdinates) return;
  const vec3 ground = ground_radiance();
  const float share = 1.0 / float(first_of[ordinate + 1u] - first_of[ordinate]);
  vec3 seen_mean = vec3(0.0), plain_mean = vec3(0.0);
  float open = 0.0;
  for (uint i = first_of[ordinate]; i < first_of[ordinate + 1u]; ++i) {
    const vec3 radiance = share / frame.light_unit * (seen[i].radiance + seen[i].of_ground * ground);
    plain_mean += radiance;
    seen_mean += seen[i].openness * radiance;
    open += share * seen[i].openness;
  }
  vec4 clouds = vec4(0.0, plain_mean);  // before any sweep nothing better is known
  if (swept != 0u) {
    vec4 sum = vec4(0.0), count = vec4(0.0);
    for (uint part = 0u; part < 64u; ++part) {
      sum += sums[64u * kLightPairs + part];
      count += sums[64u * (kLightPairs + 1u) + part];
    }
    clouds = sum / max(count, vec4(1.0));
  }
  boundary[kLightOrdinates + ordinate] = vec4(0.0, plain_mean);
  boundary[ordinate] = max(vec4(0.0, seen_mean) + (1.0 - open) * clouds, vec4(0.0));
}
