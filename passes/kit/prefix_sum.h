// Exclusive prefix sum of 32-bit counts: the deterministic way to give every thread its place in an output.
//
// reads -> writes: values -> values (in place), total
// cost: two reads and one write a value; one dispatch a level up and one down, a run of values a thread and level.
// No thread waits for another inside a dispatch, so it is right on every device and quick on lavapipe, where
// a barrier inside a shader costs more than another dispatch.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/workshop.h"

namespace nephele {

class PrefixSum {
 public:
  // Scratch for sums of up to max_count values; one object may serve many sums of a frame.
  PrefixSum(Workshop& make, const std::string& name, std::uint32_t max_count);

  // Replaces values[0, n) by their exclusive prefix sum (modulo 2^32) and writes their total, one uint, at that
  // byte offset of `total`, a buffer other than `values`. n <= max_count; n = 0 gives a total of 0.
  void add(FrameBuilder& frame, const std::string& name, const Buffer& values, std::uint32_t n, const Buffer& total,
           VkDeviceSize total_offset_bytes = 0);

 private:
  std::uint32_t run_, local_size_;  // values that a thread sums in turn; threads of a workgroup
  const ComputeKernel* reduce_;
  const ComputeKernel* scan_;
  const ComputeKernel* scan_top_;
  std::uint32_t max_count_;
  std::vector<const Buffer*> sums_;  // *sums_[k]: one value for every run_^(k+1) values
};

}  // namespace nephele
