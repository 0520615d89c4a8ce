#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/in_view.h"
#include "kit/texels.glsl"

// Which particles the camera may see: 1 or 0 each. Past the last one stands 0, because the prefix sum that follows runs
// over the whole capacity and one more.
layout(local_size_x = 64) in;

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
PARTICLES(1, particles);
layout(scalar, set = 0, binding = 2) readonly buffer Counters { FrameCounters counters; };
layout(scalar, set = 0, binding = 3) writeonly buffer Places { uint places[]; };
void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i < counters.particle_count) places[i] = particle_visible(frame, particle_at(particles, i)) ? 1u : 0u;
}
