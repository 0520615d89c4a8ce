#include "passes/ray_march.h"

#include <algorithm>

#include "shared/screen_bounds.h"
#include "shared/types.h"

namespace nephele {
namespace {

using shared::FrameCounters;

constexpr std::uint32_t kDensityVertices = 96;  // a side; what the lattice costs in accuracy: ray_march_test.cpp

// Room for pairs, as for the tiled backend: some tens a tile, and a few large particles that cover every tile.
constexpr std::uint32_t kPairsPerTile = 256, kPairsPerParticle = 8;
constexpr VkDeviceSize kMinPairs = 1u << 20;

std::uint32_t tiles_across(std::uint32_t pixels) { return (pixels + shared::kScreenTilePx - 1) / shared::kScreenTilePx; }

std::uint32_t pair_capacity(const Device& device, VkDeviceSize tiles, VkDeviceSize particles) {
  const VkDeviceSize wanted = std::max(kPairsPerTile * tiles + kPairsPerParticle * particles, kMinPairs);
  return static_cast<std::uint32_t>(std::min({tiles * particles, wanted, device.info().max_storage_buffer_bytes / sizeof(std::uint32_t)}));
}

ComputeKernel march_kernel(Device& device, std::uint32_t steps) {
  const SpecConstant constants[] = {{0, steps}};
  return ComputeKernel(device, shaders::cloud_march_comp, constants);
}

}  // namespace

RayMarch::RayMarch(Device& device, std::uint32_t steps, std::uint32_t layer_width, std::uint32_t layer_height, std::uint32_t visible_capacity)
    : density_kernel_(device, shaders::march_density_comp),
      tiles_(device, shaders::march_tiles_comp),
      march_(march_kernel(device, steps)),
      columns_(tiles_across(layer_width)),
      rows_(tiles_across(layer_height)),
      pairs_(device, "march_tile", visible_capacity, pair_capacity(device, columns_ * rows_, visible_capacity), columns_, rows_),
      rectangles_(device, "march_rectangles", VkDeviceSize{visible_capacity} * sizeof(glm::uvec2)),
      near_m_(device, "march_near", VkDeviceSize{visible_capacity} * sizeof(float)),
      order_(device, "march_order", VkDeviceSize{visible_capacity} * sizeof(std::uint32_t)),
      pixels_(device, "march_pixels", VkDeviceSize{visible_capacity} * sizeof(glm::uvec2)),
      density_(device, "march_density", {VK_FORMAT_R16_SFLOAT, kDensityVertices, kDensityVertices, kDensityVertices}) {}

void RayMarch::add(FrameBuilder& frame, const Inputs& inputs, const Image& layer_color, const Image& layer_depth) {
  if (!density_ready_) {
    frame.compute({.name = "march_density",
                   .kernel = &density_kernel_,
                   .bindings = {{0, density_, Access::storage_write}},
                   .push = as_push(inputs.tables.parameters().particle_seed),
                   .groups = {kDensityVertices / 4, kDensityVertices / 4, kDensityVertices / 4}});
    density_ready_ = true;
  }
  frame.compute({.name = "march_tiles",
                 .kernel = &tiles_,
                 .bindings = {{0, inputs.frame_constants, Access::uniform},
                              {1, inputs.draw_particles, Access::storage_read},
                              {2, inputs.counters, Access::storage_read},
                              {3, rectangles_, Access::storage_write},
                              {4, near_m_, Access::storage_write},
                              {5, order_, Access::storage_write},
                              {6, pixels_, Access::storage_write}},
                 .indirect = {&inputs.counters, offsetof(FrameCounters, visible_groups)}});
  const TileLists lists = pairs_.add(frame, "march_tiles", inputs.counters,
                                     {.item_count = offsetof(FrameCounters, visible_count),
                                      .item_groups = offsetof(FrameCounters, visible_groups),
                                      .pair_demand = offsetof(FrameCounters, screen_pair_demand),
                                      .pair_count = offsetof(FrameCounters, screen_pair_count),
                                      .pair_groups = offsetof(FrameCounters, screen_pair_groups)},
                                     order_, rectangles_);
  frame.compute({.name = "march",
                 .kernel = &march_,
                 .bindings = {{0, inputs.frame_constants, Access::uniform},
                              {1, inputs.draw_particles, Access::storage_read},
                              {2, lists.ranges, Access::storage_read},
                              {3, lists.list, Access::storage_read},
                              {4, near_m_, Access::storage_read},
                              {5, density_, Access::sampled},
                              {6, inputs.tables.multiple_scattering(), Access::sampled},
                              {7, inputs.layer_scene, Access::sampled, Sampler::nearest_clamp},
                              {8, inputs.counters, Access::storage_read_write},
                              {9, layer_color, Access::storage_write},
                              {10, layer_depth, Access::storage_write},
                              {11, pixels_, Access::storage_read}},
                 .groups = {columns_, rows_, 1}});
}

}  // namespace nephele
