#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/screen_bounds.h"
#include "shared/in_view.h"
#include "kit/texels.glsl"

// Sort keys of the visible particles: ascending keys are falling distances, of the drawn centres or of bounds on the
// nearest points. A key holds the 24 bits below the sign of the distance's float that matter: the exponents of 4 mm to
// 16 777 km and 19 bits of mantissa, so particles whose distances differ by less than 2e-6 of them are drawn in the
// order of their slots.
layout(local_size_x = 64) in;

PARTICLES(0, particles);
layout(scalar, set = 0, binding = 1) readonly buffer Visible { uint visible[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 3) writeonly buffer Keys { uint keys[]; };
layout(scalar, set = 0, binding = 4) writeonly buffer Slots { uint slots[]; };
layout(push_constant) uniform Push { uint by_nearest_point; };

const uint kKeyMax = 0xFFFFFFu;
const float kNearestM = 1.0 / 256.0;

void main() {
  const uint slot = gl_GlobalInvocationID.x;
  if (slot >= counters.visible_count) return;
  const Particle p = particle_at(particles, visible[slot]);
  float distance_m = length(p.center_m);
  if (by_nearest_point != 0u)
    distance_m = near_bound_m(p.center_m, ellipsoid_extent(p.shape, p.center_m / max(distance_m, 1e-6)));
  distance_m = max(distance_m, kNearestM);
  keys[slot] = kKeyMax - min((floatBitsToUint(distance_m) - floatBitsToUint(kNearestM)) >> 4u, kKeyMax);
  slots[slot] = slot;
}
