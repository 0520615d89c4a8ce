#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "kit/texels.glsl"

// Up one level of a prefix sum: each thread adds up a run of values.
layout(local_size_x_id = 1) in;
layout(constant_id = 0) const uint kRun = 64u;

WORDS(0, values);
layout(scalar, set = 0, binding = 1) writeonly buffer Sums { uint sums[]; };
layout(push_constant) uniform Push { uint count; };

void main() {
  const uint run = gl_GlobalInvocationID.x;
  const uint begin = run * kRun;
  if (begin >= count) return;
  const uint end = min(begin + kRun, count);
  uint sum = 0u;
  for (uint i = begin; i < end; ++i) sum += word_at(values, i);
  sums[run] = sum;
}
