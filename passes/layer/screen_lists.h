// The drawn particles by tiles of 8 x 8 pixels of the cloud layer: what the compute ways of drawing clouds
// (tiled_blend.h, ray_march.h) walk.
//
// reads -> writes: draw particles (farthest first), counters -> lists that run from front to back, bounds; in
//   counters screen_pair_*
// cost: one sort of the (tile, particle) pairs.
#pragma once

#include <cstdint>
#include <string>

#include "passes/kit/tile_pairs.h"

namespace nephele {

class ScreenLists {
 public:
  // bytes_per_pair: of the largest buffer that the user keeps for pairs; it limits how many there are room for.
  ScreenLists(Workshop& make, const std::string& name, std::uint32_t layer_width, std::uint32_t layer_height,
              std::uint32_t visible_capacity, VkDeviceSize bytes_per_pair = sizeof(std::uint32_t));

  TileLists add(FrameBuilder& frame, const Buffer& frame_constants, const Buffer& draw_particles,
                const Buffer& counters);

  std::uint32_t columns() const { return columns_; }  // of tiles
  std::uint32_t rows() const { return rows_; }
  std::uint32_t pair_capacity() const { return pairs_.pair_capacity(); }

  // By drawn particle.
  const Buffer& near_m() const { return near_m_; }  // float: no point of it is nearer
  const Buffer& pixels() const { return pixels_; }  // tile_rectangle.h rectangle: the layer's pixels that it may cover

 private:
  std::string name_;
  const ComputeKernel& kernel_;
  std::uint32_t columns_, rows_;
  TilePairs pairs_;
  Buffer& rectangles_;
  Buffer& near_m_;
  Buffer& order_;
  Buffer& pixels_;
};

}  // namespace nephele
