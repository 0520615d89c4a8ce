#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
#include "kit/texels.glsl"

// Radix sort: each thread counts the digits of its run of keys. Counts are laid out digit by digit, then thread by
// thread, so that their prefix sum is the place of each thread's first key with each digit.
layout(local_size_x_id = 0) in;

WORDS(0, keys);
layout(scalar, set = 0, binding = 1) buffer Counts { uint counts[]; };  // zero before
layout(scalar, set = 0, binding = 2) readonly buffer Count { uint key_count[]; };
layout(push_constant) uniform Push {
  uint count_index;
  uint capacity;
  uint threads;
  uint shift;
  uint digit_mask;
};

void main() {
  const uint thread = gl_GlobalInvocationID.x;
  if (thread >= threads) return;
  const uint count = min(key_count[count_index], capacity);
  const uint run = (count + threads - 1u) / threads;
  const uint end = min((thread + 1u) * run, count);
  for (uint i = thread * run; i < end; ++i) counts[((word_at(keys, i) >> shift) & digit_mask) * threads + thread] += 1u;
}
