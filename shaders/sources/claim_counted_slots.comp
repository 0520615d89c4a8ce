#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/types.h"

// claim_slots.comp for a source whose number of particles the device has counted. One thread.
layout(local_size_x = 1) in;

layout(scalar, set = 0, binding = 0) buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 1) writeonly buffer Records { SourceRecord records[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Total { uint demand; };
layout(push_constant) uniform Push {
  uint source;
  uint capacity;
};

void main() {
  const uint first = counters.particle_count;
  const uint count = min(demand, capacity);
  records[source].first = first;
  records[source].count = count;
  records[source].demand = demand;
  records[source].groups = uvec3((count + 63u) / 64u, 1u, 1u);
  counters.particle_count = first + count;
  counters.particle_demand += demand;
  counters.particle_groups.x = (first + count + 63u) / 64u;
}
