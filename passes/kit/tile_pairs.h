// Lists of items by tile: from the rectangle of tiles that each item covers to one array of items sorted by tile, each
// tile's run in the order that the items were given in. Light tiles and screen tiles are made of these.
//
// reads -> writes: order, rectangles, a count -> ranges, list; the pairs' demand, count and dispatch in the counters
// cost: one prefix sum over the item capacity and one radix sort of the pairs by tile.
#pragma once

#include <cstdint>
#include <string>

#include "passes/kit/radix_sort.h"

namespace nephele {

// Tile t's items are list[ranges[t].x .. ranges[t].y), t = row * columns + column.
struct TileLists {
  const Buffer& ranges;  // uvec2 per tile
  const Buffer& list;    // uint
  const Buffer& tiles;   // uint: the tile of each place
};

class TilePairs {
 public:
  TilePairs(Workshop& make, const std::string& name, std::uint32_t item_capacity, std::uint32_t pair_capacity,
            std::uint32_t tile_columns, std::uint32_t tile_rows);

  // Where in the counters buffer these stand, in bytes. Items and their dispatch (64 a group) are given, the pairs'
  // are written: pairs past the capacity, those of the last items, are left out and counted in the demand.
  struct CounterOffsets {
    VkDeviceSize item_count, item_groups, pair_demand, pair_count, pair_groups;
  };
  // order: indices of the items, in the lists' order; rectangles: a tile_rectangle.h rectangle by item index.
  TileLists add(FrameBuilder& frame, const std::string& name, const Buffer& counters, const CounterOffsets& at,
                const Buffer& order, const Buffer& rectangles);

  std::uint32_t pair_capacity() const { return pair_capacity_; }
  std::uint32_t tile_count() const { return tile_columns_ * tile_rows_; }

 private:
  const ComputeKernel& count_;
  const ComputeKernel& args_;
  const ComputeKernel& emit_;
  const ComputeKernel& ranges_kernel_;
  std::uint32_t item_capacity_, pair_capacity_, tile_columns_, tile_rows_;
  RadixSort sort_;
  PrefixSum scan_;
  Buffer& places_;
  Buffer& ranges_;
};

}  // namespace nephele
