// The particles that the camera may see: a list of their indices, ascending.
//
// reads -> writes: frame constants, particles, particle_* of the counters -> visible list; visible_* and draw of the
// counters
// cost: one test a particle and a prefix sum over the capacity.
#pragma once

#include <cstdint>

#include "passes/kit/prefix_sum.h"

namespace nephele {

class Visibility {
 public:
  Visibility(Workshop& make, std::uint32_t particle_capacity);

  // Returns the list: uint, visible_count of them. Steps: "visibility".
  const Buffer& add(FrameBuilder& frame, const Buffer& frame_constants, const Buffer& particles,
                    const Buffer& counters);

 private:
  const ComputeKernel& test_;
  const ComputeKernel& list_;
  std::uint32_t capacity_;
  PrefixSum scan_;
  const Buffer& places_;
  const Buffer& visible_;
};

}  // namespace nephele
