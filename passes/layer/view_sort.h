// Order of drawing: back to front by the true distance of the drawn centres, equal ones by slot ([Yusov14] 5.2 sorts
// cells on the CPU; here the particles themselves are sorted on the device). Exact blending wants them by their nearest
// points instead, so that whatever lies in front of a particle is known when its turn comes.
//
// reads -> writes: particles, visible list, counters -> draw order
// cost: a 24-bit radix sort (three rounds) of the visible particles.
#pragma once

#include <cstdint>

#include "passes/kit/radix_sort.h"

namespace nephele {

enum class ViewOrder : std::uint32_t { center, nearest_point };

class ViewSort {
 public:
  ViewSort(Workshop& make, std::uint32_t visible_capacity, ViewOrder order = ViewOrder::center);

  // Returns the draw order: slots, that is indices into the visible list and into the lights, farthest first.
  // counters is a FrameCounters.
  const Buffer& add(FrameBuilder& frame, const Buffer& particles, const Buffer& visible, const Buffer& counters);

 private:
  ViewOrder order_;
  const ComputeKernel& keys_;
  RadixSort sort_;
};

}  // namespace nephele
