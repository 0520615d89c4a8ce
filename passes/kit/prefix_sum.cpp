#include "passes/kit/prefix_sum.h"
#include "nephele_shaders.h"

namespace nephele {

namespace {

struct Push {
  std::uint32_t count, total_index;
};

}  // namespace

PrefixSum::PrefixSum(Workshop& make, const std::string& name, std::uint32_t max_count) : max_count_(max_count) {
  run_ = make.device().tuning().sum_run;
  local_size_ = make.device().tuning().sum_local_size;
  const SpecConstant constants[] = {{0, run_}, {1, local_size_}};
  reduce_ = &make.compute(shaders::prefix_sum_reduce_comp, constants);
  scan_ = &make.compute(shaders::prefix_sum_scan_comp, constants);
  scan_top_ = &make.compute(shaders::prefix_sum_scan_comp_top, constants);
  for (std::uint32_t count = max_count; count > run_;) {
    count = (count + run_ - 1) / run_;
    const std::string level = name + "_sums_" + std::to_string(sums_.size());
    sums_.push_back(&make.buffer(level, VkDeviceSize{count} * sizeof(std::uint32_t)));
  }
}

void PrefixSum::add(FrameBuilder& frame, const std::string& name, const Buffer& values, std::uint32_t n,
                    const Buffer& total, VkDeviceSize total_offset_bytes) {
  NEPHELE_CHECK(n <= max_count_, name, ": ", n, " values, room for ", max_count_);
  NEPHELE_CHECK(total_offset_bytes % sizeof(std::uint32_t) == 0, name, ": total at byte ", total_offset_bytes);

  const auto groups = [&](std::uint32_t threads) { return (threads + local_size_ - 1) / local_size_; };
  struct Level {
    const Buffer* values;
    std::uint32_t count;
  };
  std::vector<Level> levels = {{&values, n}};
  while (levels.back().count > run_) {
    const Level from = levels.back();
    const Level to{sums_[levels.size() - 1], (from.count + run_ - 1) / run_};
    frame.compute({.name = name,
                   .kernel = reduce_,
                   .bindings = {{0, *from.values, Access::words}, {1, *to.values, Access::storage_write}},
                   .push = as_push(from.count),
                   .groups = {groups(to.count), 1, 1}});
    levels.push_back(to);
  }

  const Level top = levels.back();
  const Push push{top.count, static_cast<std::uint32_t>(total_offset_bytes / sizeof(std::uint32_t))};
  frame.compute({.name = name,
                 .kernel = scan_top_,
                 .bindings = {{0, *top.values, Access::storage_read_write}, {1, total, Access::storage_write}},
                 .push = as_push(push)});

  for (std::size_t level = levels.size() - 1; level-- > 0;)
    frame.compute({.name = name,
                   .kernel = scan_,
                   .bindings = {{0, *levels[level].values, Access::storage_read_write},
                                {1, *levels[level + 1].values, Access::storage_read}},
                   .push = as_push(Push{levels[level].count, 0}),
                   .groups = {groups(levels[level + 1].count), 1, 1}});
}

}  // namespace nephele
