#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/listed_particles.h"

// Listed particles into render space and into the slots that claim_slots.comp has given their source.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) readonly buffer Listed { PlacedParticle listed[]; };
layout(scalar, set = 0, binding = 1) writeonly buffer Particles { Particle particles[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Records { SourceRecord records[]; };
layout(push_constant, scalar) uniform Push {
  SplitPlace camera;
  uint source;
};

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= records[source].count) return;
  // Exact order of operations: the high parts cancel first.
  precise const vec3 high = listed[i].place.high_m - camera.high_m;
  precise const vec3 low = listed[i].place.low_m - camera.low_m;
  precise const vec3 offset = high + low;
  const ivec2 units = listed[i].place.unit - camera.unit;
  particles[records[source].first + i] =
      listed_particle(listed[i], offset + vec3(vec2(units) * kOriginUnitM, 0.0), camera.high_m.z, source);
}
