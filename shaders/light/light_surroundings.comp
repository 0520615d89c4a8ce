#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// What clouds see around them without each other, from the middle of their layer: for each of many directions the
// radiance of sky or air, and the share of the ground's own radiance that comes through.
#include "light/light_lattice_buffer.glsl"
#include "shared/atmosphere_tables.h"
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(constant_id = 0) const bool kAir = true;  // false: dummies are bound as the tables
layout(scalar, set = 0, binding = 1) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 2) uniform sampler2D transmittance;
layout(set = 0, binding = 3) uniform sampler2D multi_scattering;
layout(scalar, set = 0, binding = 4) readonly buffer Directions { vec3 directions[]; };  // to look in
struct Seen {
  vec3 radiance, of_ground;
};
layout(scalar, set = 0, binding = 5) writeonly buffer Surroundings { Seen seen[]; };
layout(push_constant, scalar) uniform Push { uint count; };

const uint kSteps = 16u;

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  const vec3 direction = directions[i];
  const float altitude_m = max(lattice.lowest_m + 0.5 * float(lattice.height) * lattice.layer_m, 1.0);
  const float horizon = horizon_cosine(altitude_m);
  const bool below = direction.z < horizon;
  seen[i] = Seen(vec3(0.0), below && frame.ground_enabled != 0u ? vec3(1.0) : vec3(0.0));
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
