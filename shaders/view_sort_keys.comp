#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/types.h"

// Sort keys of the visible particles: ascending keys are falling distances of the drawn centres. A key holds the 24
// bits below the sign of the distance's float that matter: the exponents of 4 mm to 16 777 km and 19 bits of mantissa,
// so centres whose distances differ by less than 2e-6 of them are drawn in the order of their slots.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) readonly buffer Particles { Particle particles[]; };
layout(scalar, set = 0, binding = 1) readonly buffer Visible { uint visible[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 3) writeonly buffer Keys { uint keys[]; };
layout(scalar, set = 0, binding = 4) writeonly buffer Slots { uint slots[]; };

const uint kKeyMax = 0xFFFFFFu;
const float kNearestM = 1.0 / 256.0;

void main() {
  const uint slot = gl_GlobalInvocationID.x;
  if (slot >= counters.visible_count) return;
  const float distance_m = max(length(particles[visible[slot]].center_m), kNearestM);
  keys[slot] = kKeyMax - min((floatBitsToUint(distance_m) - floatBitsToUint(kNearestM)) >> 4u, kKeyMax);
  slots[slot] = slot;
}
