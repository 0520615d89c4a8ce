#include "passes/kit/tile_pairs.h"
#include "nephele_shaders.h"

#include <algorithm>
#include <bit>

namespace nephele {
namespace {

struct Push {
  std::uint32_t item_count_at, pair_demand_at, pair_count_at, pair_groups_at;
  std::uint32_t item_capacity, pair_capacity;
  std::uint32_t tile_columns;
};

// An item may cover every tile, and each row takes a round more.
const ComputeKernel& emit_kernel(Workshop& make, std::uint32_t tile_columns, std::uint32_t tile_rows) {
  const std::uint32_t columns_a_round = 1 + tile_columns * tile_rows / (make.device().tuning().loop_rounds / 2 + 1);
  const SpecConstant constants[] = {{0, columns_a_round}};
  return make.compute(shaders::tile_emit_comp, constants);
}

std::uint32_t word(VkDeviceSize offset_bytes) {
  return static_cast<std::uint32_t>(offset_bytes / sizeof(std::uint32_t));
}

}  // namespace

TilePairs::TilePairs(Workshop& make, const std::string& name, std::uint32_t item_capacity, std::uint32_t pair_capacity,
                     std::uint32_t tile_columns, std::uint32_t tile_rows)
    : count_(make.compute(shaders::tile_count_comp)),
      args_(make.compute(shaders::tile_args_comp)),
      emit_(emit_kernel(make, tile_columns, tile_rows)),
      ranges_kernel_(make.compute(shaders::tile_ranges_comp)),
      item_capacity_(std::max(item_capacity, 1u)),
      pair_capacity_(std::max(pair_capacity, 1u)),
      tile_columns_(tile_columns),
      tile_rows_(tile_rows),
      sort_(make, name + "_sort", pair_capacity_),
      scan_(make, name + "_items", item_capacity_),
      places_(make.buffer(name + "_places", VkDeviceSize{item_capacity_} * sizeof(std::uint32_t))),
      ranges_(make.buffer(name + "_ranges", VkDeviceSize{tile_count()} * 2 * sizeof(std::uint32_t))) {
  NEPHELE_CHECK(tile_columns >= 1 && tile_rows >= 1 && tile_columns < 65536 && tile_rows < 65536, name);
}

TileLists TilePairs::add(FrameBuilder& frame, const std::string& name, const Buffer& counters, const CounterOffsets& at,
                         const Buffer& order, const Buffer& rectangles) {
  const PushConstants push = as_push(Push{word(at.item_count), word(at.pair_demand), word(at.pair_count),
                                          word(at.pair_groups), item_capacity_, pair_capacity_, tile_columns_});
  frame.compute({.name = name,
                 .kernel = &count_,
                 .bindings = {{0, counters, Access::storage_read},
                              {1, order, Access::words},
                              {2, rectangles, Access::words},
                              {3, places_, Access::storage_write}},
                 .push = push,
                 .groups = {(item_capacity_ + 63) / 64, 1, 1}});
  scan_.add(frame, name, places_, item_capacity_, counters, at.pair_demand);
  frame.compute(
      {.name = name, .kernel = &args_, .bindings = {{0, counters, Access::storage_read_write}}, .push = push});
  frame.compute({.name = name,
                 .kernel = &emit_,
                 .bindings = {{0, counters, Access::storage_read},
                              {1, order, Access::words},
                              {2, rectangles, Access::words},
                              {3, places_, Access::words},
                              {4, sort_.keys(), Access::storage_write},
                              {5, sort_.values(), Access::storage_write}},
                 .push = push,
                 .indirect = {&counters, at.item_groups}});
  const std::uint32_t tile_bits = std::max<std::uint32_t>(1, std::bit_width(tile_count() - 1));
  const RadixSort::Sorted sorted = sort_.add(frame, name, counters, at.pair_count, tile_bits);

  frame.fill(name, ranges_, 0);
  frame.compute({.name = name,
                 .kernel = &ranges_kernel_,
                 .bindings = {{0, counters, Access::storage_read},
                              {1, sorted.keys, Access::words},
                              {2, ranges_, Access::storage_write}},
                 .push = push,
                 .indirect = {&counters, at.pair_groups}});
  return {ranges_, sorted.values, sorted.keys};
}

}  // namespace nephele
