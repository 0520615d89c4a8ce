#include "passes/layer/screen_lists.h"

#include <algorithm>

#include "nephele_shaders.h"
#include "shared/screen_bounds.h"
#include "shared/types.h"

namespace nephele {
namespace {

using shared::FrameCounters;

// Room for pairs: a cloud field has some tens a tile, a few large particles near the camera cover every tile.
constexpr std::uint32_t kPairsPerTile = 256;
constexpr std::uint32_t kPairsPerParticle = 8;
constexpr VkDeviceSize kMinPairs = 1u << 20;
constexpr VkDeviceSize kMaskBytes = 8;  // of a pair: the largest array of pairs that shaders read as words

std::uint32_t tiles_across(std::uint32_t pixels) {
  return (pixels + shared::kScreenTilePx - 1) / shared::kScreenTilePx;
}

std::uint32_t room_for_pairs(const Workshop& make, VkDeviceSize tiles, VkDeviceSize particles,
                             VkDeviceSize bytes_per_pair) {
  const VkDeviceSize wanted = std::max(kPairsPerTile * tiles + kPairsPerParticle * particles, kMinPairs);
  return static_cast<std::uint32_t>(std::min({tiles * particles, wanted, make.device().max_elements(kMaskBytes),
                                              make.device().info().max_storage_buffer_bytes / bytes_per_pair}));
}

}  // namespace

ScreenLists::ScreenLists(Workshop& make, const std::string& name, std::uint32_t layer_width, std::uint32_t layer_height,
                         std::uint32_t visible_capacity, VkDeviceSize bytes_per_pair)
    : name_(name),
      kernel_(make.compute(shaders::screen_tiles_comp)),
      columns_(tiles_across(layer_width)),
      rows_(tiles_across(layer_height)),
      pairs_(make, name, visible_capacity, room_for_pairs(make, columns_ * rows_, visible_capacity, bytes_per_pair),
             columns_, rows_),
      rectangles_(make.buffer(name + "_rectangles", VkDeviceSize{visible_capacity} * sizeof(glm::uvec2))),
      near_m_(make.buffer(name + "_near", VkDeviceSize{visible_capacity} * sizeof(float))),
      order_(make.buffer(name + "_order", VkDeviceSize{visible_capacity} * sizeof(std::uint32_t))),
      pixels_(make.buffer(name + "_pixels", VkDeviceSize{visible_capacity} * sizeof(glm::uvec2))) {
  NEPHELE_CHECK(visible_capacity <= shared::kMaxScreenParticles, visible_capacity, " particles");
}

TileLists ScreenLists::add(FrameBuilder& frame, const Buffer& frame_constants, const Buffer& draw_particles,
                           const Buffer& counters) {
  frame.compute({.name = name_,
                 .kernel = &kernel_,
                 .bindings = {{0, frame_constants, Access::uniform},
                              {1, draw_particles, Access::texels},
                              {2, counters, Access::storage_read},
                              {3, rectangles_, Access::storage_write},
                              {4, near_m_, Access::storage_write},
                              {5, order_, Access::storage_write},
                              {6, pixels_, Access::storage_write}},
                 .indirect = {&counters, offsetof(FrameCounters, visible_groups)}});
  return pairs_.add(frame, name_, counters,
                    {.item_count = offsetof(FrameCounters, visible_count),
                     .item_groups = offsetof(FrameCounters, visible_groups),
                     .pair_demand = offsetof(FrameCounters, screen_pair_demand),
                     .pair_count = offsetof(FrameCounters, screen_pair_count),
                     .pair_groups = offsetof(FrameCounters, screen_pair_groups)},
                    order_, rectangles_);
}

}  // namespace nephele
