#version 460
#extension GL_EXT_scalar_block_layout : require
// variants: - top=TOP

// Down one level of a prefix sum: each thread scans its run, starting from the sum of all runs before it.
// The top level is one run, which starts from 0 and gives the total.
layout(local_size_x_id = 1) in;
layout(constant_id = 0) const uint kRun = 64u;

layout(scalar, set = 0, binding = 0) buffer Values { uint values[]; };
#ifdef TOP
layout(scalar, set = 0, binding = 1) writeonly buffer Total { uint total[]; };
#else
layout(scalar, set = 0, binding = 1) readonly buffer Sums { uint sums[]; };
#endif
layout(push_constant) uniform Push {
  uint count;
  uint total_index;
};

void main() {
  const uint run = gl_GlobalInvocationID.x;
#ifdef TOP
  if (run > 0u) return;
  uint sum = 0u;
#else
  if (run * kRun >= count) return;
  uint sum = sums[run];
#endif
  const uint begin = run * kRun;
  const uint end = min(begin + kRun, count);
  for (uint i = begin; i < end; ++i) {
    const uint value = values[i];
    values[i] = sum;
    sum += value;
  }
#ifdef TOP
  total[total_index] = sum;
#endif
}
