#include "passes/tiled_blend.h"

#include <algorithm>

#include "shared/screen_bounds.h"
#include "shared/types.h"

namespace nephele {

using shared::FrameCounters;

namespace {

// Room for pairs: a cloud field has some tens a tile, a few large particles near the camera cover every tile.
constexpr std::uint32_t kPairsPerTile = 256;
constexpr std::uint32_t kPairsPerParticle = 8;

std::uint32_t tiles_across(std::uint32_t pixels) { return (pixels + shared::kScreenTilePx - 1) / shared::kScreenTilePx; }

std::uint32_t pair_capacity(const Device& device, std::uint32_t tiles, std::uint32_t particles) {
  const VkDeviceSize wanted = VkDeviceSize{tiles} * std::min(kPairsPerTile, particles) + VkDeviceSize{kPairsPerParticle} * particles;
  return static_cast<std::uint32_t>(std::min(wanted, device.info().max_storage_buffer_bytes / sizeof(std::uint32_t)));
}

}  // namespace

const char* blend_mode_name(BlendMode mode) { return mode == BlendMode::exact ? "exact" : "volume"; }

TiledBlend::TiledBlend(Device& device, BlendMode, std::uint32_t layer_width, std::uint32_t layer_height,
                       std::uint32_t visible_capacity)
    : tiles_(device, shaders::screen_tiles_comp),
      begins_kernel_(device, shaders::screen_begins_comp),
      shade_(device, shaders::cloud_tiles_comp_volume),
      columns_(tiles_across(layer_width)),
      rows_(tiles_across(layer_height)),
      pairs_(device, "screen_tile", visible_capacity, pair_capacity(device, columns_ * rows_, visible_capacity), columns_, rows_),
      rectangles_(device, "screen_rectangles", VkDeviceSize{visible_capacity} * sizeof(glm::uvec2)),
      near_m_(device, "screen_near", VkDeviceSize{visible_capacity} * sizeof(float)),
      order_(device, "screen_order", VkDeviceSize{visible_capacity} * sizeof(std::uint32_t)),
      begins_m_(device, "screen_begins", VkDeviceSize{pairs_.pair_capacity()} * sizeof(float)) {}

void TiledBlend::add(FrameBuilder& frame, const Inputs& inputs, const Image& layer_color, const Image& layer_depth) {
  frame.compute({.name = "screen_tiles",
                 .kernel = &tiles_,
                 .bindings = {{0, inputs.frame_constants, Access::uniform},
                              {1, inputs.draw_particles, Access::storage_read},
                              {2, inputs.counters, Access::storage_read},
                              {3, rectangles_, Access::storage_write},
                              {4, near_m_, Access::storage_write},
                              {5, order_, Access::storage_write}},
                 .indirect = {&inputs.counters, offsetof(FrameCounters, visible_groups)}});
  const TileLists lists = pairs_.add(frame, "screen_tiles", inputs.counters,
                                     {.item_count = offsetof(FrameCounters, visible_count),
                                      .item_groups = offsetof(FrameCounters, visible_groups),
                                      .pair_demand = offsetof(FrameCounters, screen_pair_demand),
                                      .pair_count = offsetof(FrameCounters, screen_pair_count),
                                      .pair_groups = offsetof(FrameCounters, screen_pair_groups)},
                                     order_, rectangles_);
  frame.compute({.name = "screen_tiles",
                 .kernel = &begins_kernel_,
                 .bindings = {{0, lists.ranges, Access::storage_read},
                              {1, lists.list, Access::storage_read},
                              {2, near_m_, Access::storage_read},
                              {3, begins_m_, Access::storage_write}},
                 .push = as_push(pairs_.tile_count()),
                 .groups = {(pairs_.tile_count() + 31) / 32, 1, 1}});
  frame.compute({.name = "shade_blend",
                 .kernel = &shade_,
                 .bindings = {{0, inputs.frame_constants, Access::uniform},
                              {1, inputs.draw_particles, Access::storage_read},
                              {2, inputs.tables.optical_depth(), Access::sampled},
                              {3, inputs.tables.multiple_scattering(), Access::sampled},
                              {4, inputs.detail_noise, Access::sampled, Sampler::linear_repeat},
                              {5, lists.ranges, Access::storage_read},
                              {6, lists.list, Access::storage_read},
                              {7, begins_m_, Access::storage_read},
                              {8, inputs.counters, Access::storage_read_write},
                              {9, layer_color, Access::storage_write},
                              {10, layer_depth, Access::storage_write}},
                 .groups = {columns_, rows_, 1}});
}

}  // namespace nephele
