#include "passes/kit/radix_sort.h"
#include "nephele_shaders.h"

#include <algorithm>

namespace nephele {

namespace {

const ComputeKernel& sort_kernel(Workshop& make, const ShaderCode& code) {
  const SpecConstant constants[] = {{0, make.device().tuning().sort_local_size}};
  return make.compute(code, constants);
}

// Each thread sorts an equal run of the pairs: one round of a loop each, and never more than the loop may go.
std::uint32_t thread_count(const Tuning& tuning, std::uint32_t capacity) {
  const auto runs_of = [&](std::uint32_t pairs) { return (capacity - 1) / pairs + 1; };
  return std::clamp(runs_of(tuning.sort_run), 1u, std::max(tuning.sort_max_threads, runs_of(tuning.loop_rounds - 1)));
}

struct Push {
  std::uint32_t count_index, capacity, threads, shift, digit_mask;
};

}  // namespace

RadixSort::RadixSort(Workshop& make, const std::string& name, std::uint32_t capacity)
    : histogram_(sort_kernel(make, shaders::radix_histogram_comp)),
      scatter_(sort_kernel(make, shaders::radix_scatter_comp)),
      capacity_(std::max(capacity, 1u)),
      local_size_(make.device().tuning().sort_local_size),
      threads_(thread_count(make.device().tuning(), capacity_)),
      scan_(make, name + "_digits", threads_ << kMaxDigitBits),
      counts_(make.buffer(name + "_digit_counts", (VkDeviceSize{threads_} << kMaxDigitBits) * sizeof(std::uint32_t))),
      total_(make.buffer(name + "_total", sizeof(std::uint32_t))) {
  for (int side = 0; side < 2; ++side) {
    const VkDeviceSize bytes = VkDeviceSize{capacity_} * sizeof(std::uint32_t);
    keys_[side] = &make.buffer(name + "_keys_" + std::to_string(side), bytes);
    values_[side] = &make.buffer(name + "_values_" + std::to_string(side), bytes);
  }
}

RadixSort::Sorted RadixSort::add(FrameBuilder& frame, const std::string& name, const Buffer& count,
                                 VkDeviceSize count_offset_bytes, std::uint32_t key_bits) {
  NEPHELE_CHECK(key_bits >= 1 && key_bits <= 32, name, ": ", key_bits, " key bits");
  NEPHELE_CHECK(count_offset_bytes % sizeof(std::uint32_t) == 0, name, ": count at byte ", count_offset_bytes);

  // Rounds of equal width: a 14-bit key takes two tables of 128 counts, not one of 256 and one of 64.
  const std::uint32_t rounds = (key_bits + kMaxDigitBits - 1) / kMaxDigitBits;
  const std::uint32_t digit_bits = (key_bits + rounds - 1) / rounds;
  const std::uint32_t groups = (threads_ + local_size_ - 1) / local_size_;

  int from = 0;
  for (std::uint32_t shift = 0; shift < key_bits; shift += digit_bits, from ^= 1) {
    const std::uint32_t bits = std::min(digit_bits, key_bits - shift);
    const Push push{static_cast<std::uint32_t>(count_offset_bytes / sizeof(std::uint32_t)), capacity_, threads_, shift,
                    (1u << bits) - 1u};
    frame.fill(name, counts_, 0);
    frame.compute({.name = name,
                   .kernel = &histogram_,
                   .bindings = {{0, *keys_[from], Access::words},
                                {1, counts_, Access::storage_read_write},
                                {2, count, Access::storage_read}},
                   .push = as_push(push),
                   .groups = {groups, 1, 1}});
    scan_.add(frame, name, counts_, threads_ << bits, total_);
    frame.compute({.name = name,
                   .kernel = &scatter_,
                   .bindings = {{0, *keys_[from], Access::words},
                                {1, *values_[from], Access::words},
                                {2, *keys_[from ^ 1], Access::storage_write},
                                {3, *values_[from ^ 1], Access::storage_write},
                                {4, counts_, Access::storage_read_write},
                                {5, count, Access::storage_read}},
                   .push = as_push(push),
                   .groups = {groups, 1, 1}});
  }
  return {*keys_[from], *values_[from]};
}

}  // namespace nephele
