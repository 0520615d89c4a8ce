#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// The particles of the instances, one thread each. Which instance and level a particle belongs to is found among the
// places at which these begin, by halving.
layout(local_size_x = 64) in;

#include "shared/set_instances.h"
layout(scalar, set = 0, binding = 0) readonly buffer Constants { SetConstants constants; };
layout(scalar, set = 0, binding = 1) readonly buffer Own { SetParticleRecord own[]; };
layout(scalar, set = 0, binding = 2) readonly buffer Instances { SetInstanceRecord instances[]; };
layout(scalar, set = 0, binding = 3) readonly buffer Begins { uint begins[]; };
layout(scalar, set = 0, binding = 4) readonly buffer Records { SourceRecord records[]; };
layout(scalar, set = 0, binding = 5) writeonly buffer Particles { Particle particles[]; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= records[constants.source].count) return;
  uint low = 0u, past = 2u * constants.candidates;  // begins[low] <= i < begins[past]
  while (low + 1u < past) {
    const uint middle = (low + past) / 2u;
    if (begins[middle] <= i)
      low = middle;
    else
      past = middle;
  }
  const SetInstanceRecord instance = instances[low / 2u];
  const bool second = (low & 1u) != 0u;
  const uint first = second ? instance.first[1] : instance.first[0];
  const float weight = second ? instance.weight[1] : instance.weight[0];
  const uint flags = second ? instance.flags[1] : instance.flags[0];
  particles[records[constants.source].first + i] =
      set_particle(own[first + i - begins[low]], instance, weight, flags, constants.camera_grid_m.z, constants.source);
}
