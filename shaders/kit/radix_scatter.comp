#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
#include "kit/texels.glsl"

// Radix sort: each thread moves its run of pairs, in order, to the places that the summed counts give it.
layout(local_size_x_id = 0) in;

WORDS(0, keys_in);
WORDS(1, values_in);
layout(scalar, set = 0, binding = 2) writeonly buffer KeysOut { uint keys_out[]; };
layout(scalar, set = 0, binding = 3) writeonly buffer ValuesOut { uint values_out[]; };
layout(scalar, set = 0, binding = 4) buffer Places { uint places[]; };
layout(scalar, set = 0, binding = 5) readonly buffer Count { uint key_count[]; };
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
  for (uint i = thread * run; i < end; ++i) {
    const uint key = word_at(keys_in, i);
    const uint column = ((key >> shift) & digit_mask) * threads + thread;
    const uint place = places[column];
    places[column] = place + 1u;
    keys_out[place] = key;
    values_out[place] = word_at(values_in, i);
  }
}
