// Stable least-significant-digit radix sort of (uint key, uint value) pairs whose number only the device knows.
//
// reads -> writes: keys(), values(), a count -> the sorted pairs
// cost: ceil(key_bits / 8) rounds; each reads the pairs twice, writes them once and scans one table of 2^digit_bits
// counts a thread, the same however many pairs there are. No barrier inside a shader and no atomics: every thread works
// through its own run of pairs, so the result is the same on every device (the stable order is unique).
#pragma once

#include <cstdint>
#include <string>

#include "passes/kit/prefix_sum.h"

namespace nephele {

class RadixSort {
 public:
  // Owns room for `capacity` pairs, twice.
  RadixSort(Workshop& make, const std::string& name, std::uint32_t capacity);

  // Where the pairs to sort are to be written before add().
  const Buffer& keys() const { return *keys_[0]; }
  const Buffer& values() const { return *values_[0]; }
  std::uint32_t capacity() const { return capacity_; }

  struct Sorted {
    const Buffer& keys;
    const Buffer& values;
  };
  // Sorts the first min(count, capacity) pairs by the low key_bits of their keys, ascending; count is the uint at that
  // byte offset. Higher key bits do not matter. What is returned holds until the pairs are next written or sorted.
  Sorted add(FrameBuilder& frame, const std::string& name, const Buffer& count, VkDeviceSize count_offset_bytes,
             std::uint32_t key_bits);

 private:
  static constexpr std::uint32_t kMaxDigitBits = 8;

  const ComputeKernel& histogram_;
  const ComputeKernel& scatter_;
  std::uint32_t capacity_, local_size_, threads_;
  PrefixSum scan_;
  const Buffer *keys_[2], *values_[2];
  Buffer& counts_;  // by digit, then by thread
  Buffer& total_;   // the scan's total, not used
};

}  // namespace nephele
