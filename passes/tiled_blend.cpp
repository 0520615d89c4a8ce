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
constexpr VkDeviceSize kMinPairs = 1u << 20;

std::uint32_t tiles_across(std::uint32_t pixels) { return (pixels + shared::kScreenTilePx - 1) / shared::kScreenTilePx; }

// Turns (shaded particles) of one pixel of the exact blend before it merges. Lavapipe ends every loop of eight threads
// once all of theirs have gone round 65 535 times, and a turn takes a handful of rounds.
constexpr std::uint32_t kTurnsOnCpu = 4096, kTurnsOnGpu = 1u << 18;

bool on_cpu(const Device& device) { return device.info().type == VK_PHYSICAL_DEVICE_TYPE_CPU; }

ComputeKernel shade_kernel(Device& device, const ShaderCode& code, std::uint32_t pixels_per_thread) {
  const std::uint32_t turns = (on_cpu(device) ? kTurnsOnCpu : kTurnsOnGpu) / pixels_per_thread;
  const SpecConstant constants[] = {{0, 64 / pixels_per_thread}, {1, pixels_per_thread}, {2, turns}};
  return ComputeKernel(device, code, constants);
}

ComputeKernel shade_short_kernel(Device& device, BlendMode mode) {
  if (mode == BlendMode::exact) return shade_kernel(device, shaders::cloud_tiles_comp_exact, on_cpu(device) ? 8 : 1);
  if (!on_cpu(device)) return shade_kernel(device, shaders::cloud_tiles_comp_volume, 1);
  return ComputeKernel(device, shaders::cloud_columns_comp);
}

std::uint32_t pair_capacity(const Device& device, std::uint32_t tiles, std::uint32_t particles) {
  const VkDeviceSize all = VkDeviceSize{tiles} * particles;
  const VkDeviceSize wanted = std::max(VkDeviceSize{kPairsPerTile} * tiles + VkDeviceSize{kPairsPerParticle} * particles, kMinPairs);
  return static_cast<std::uint32_t>(std::min({all, wanted, device.info().max_storage_buffer_bytes / sizeof(std::uint32_t)}));
}

}  // namespace

const char* blend_mode_name(BlendMode mode) { return mode == BlendMode::exact ? "exact" : "volume"; }

TiledBlend::TiledBlend(Device& device, BlendMode mode, std::uint32_t layer_width, std::uint32_t layer_height,
                       std::uint32_t visible_capacity)
    : tiles_(device, shaders::screen_tiles_comp),
      begins_kernel_(device, shaders::screen_begins_comp),
      shade_short_(shade_short_kernel(device, mode)),
      shade_long_(shade_kernel(device, mode == BlendMode::exact ? shaders::cloud_tiles_comp_exact_long : shaders::cloud_tiles_comp_volume, 1)),
      columns_(tiles_across(layer_width)),
      rows_(tiles_across(layer_height)),
      pairs_(device, "screen_tile", visible_capacity, pair_capacity(device, columns_ * rows_, visible_capacity), columns_, rows_),
      rectangles_(device, "screen_rectangles", VkDeviceSize{visible_capacity} * sizeof(glm::uvec2)),
      near_m_(device, "screen_near", VkDeviceSize{visible_capacity} * sizeof(float)),
      order_(device, "screen_order", VkDeviceSize{visible_capacity} * sizeof(std::uint32_t)),
      pixels_(device, "screen_pixels", VkDeviceSize{visible_capacity} * sizeof(glm::uvec2)),
      entries_(device, "screen_entries", VkDeviceSize{pairs_.pair_capacity()} * sizeof(std::uint32_t)),
      draw_texels_(device, "draw_texels", {VK_FORMAT_R32G32B32A32_SFLOAT, shared::kDrawTexelsPerParticle * shared::kDrawParticlesPerRow,
                                           (visible_capacity + shared::kDrawParticlesPerRow - 1) / shared::kDrawParticlesPerRow}),
      long_tiles_(device, "screen_long_tiles", VkDeviceSize{3 + rows_ + columns_ * rows_} * sizeof(std::uint32_t)),
      begins_m_(device, "screen_begins", VkDeviceSize{pairs_.pair_capacity()} * sizeof(float)) {
  NEPHELE_CHECK(visible_capacity <= shared::kMaxScreenParticles, visible_capacity, " particles");
}

void TiledBlend::add(FrameBuilder& frame, const Inputs& inputs, const Image& layer_color, const Image& layer_depth) {
  frame.compute({.name = "screen_tiles",
                 .kernel = &tiles_,
                 .bindings = {{0, inputs.frame_constants, Access::uniform},
                              {1, inputs.draw_particles, Access::storage_read},
                              {2, inputs.counters, Access::storage_read},
                              {3, rectangles_, Access::storage_write},
                              {4, near_m_, Access::storage_write},
                              {5, order_, Access::storage_write},
                              {6, pixels_, Access::storage_write},
                              {7, draw_texels_, Access::storage_write}},
                 .indirect = {&inputs.counters, offsetof(FrameCounters, visible_groups)}});
  const TileLists lists = pairs_.add(frame, "screen_tiles", inputs.counters,
                                     {.item_count = offsetof(FrameCounters, visible_count),
                                      .item_groups = offsetof(FrameCounters, visible_groups),
                                      .pair_demand = offsetof(FrameCounters, screen_pair_demand),
                                      .pair_count = offsetof(FrameCounters, screen_pair_count),
                                      .pair_groups = offsetof(FrameCounters, screen_pair_groups)},
                                     order_, rectangles_);
  frame.fill("screen_tiles", long_tiles_, 0);
  frame.compute({.name = "screen_tiles",
                 .kernel = &begins_kernel_,
                 .bindings = {{0, lists.ranges, Access::storage_read},
                              {1, lists.list, Access::storage_read},
                              {2, near_m_, Access::storage_read},
                              {3, pixels_, Access::storage_read},
                              {4, entries_, Access::storage_write},
                              {5, begins_m_, Access::storage_write},
                              {6, long_tiles_, Access::storage_read_write}},
                 .push = as_push(glm::uvec2(columns_, rows_)),
                 .groups = {(pairs_.tile_count() + 31) / 32, 1, 1}});
  const auto shade = [&](const ComputeKernel& kernel, std::uint32_t long_lists) {
    ComputeStep step{.name = "shade_blend",
                     .kernel = &kernel,
                     .bindings = {{0, inputs.frame_constants, Access::uniform},
                                  {1, draw_texels_, Access::sampled, Sampler::nearest_clamp},
                                  {2, inputs.tables.optical_depth(), Access::sampled},
                                  {3, inputs.tables.multiple_scattering(), Access::sampled},
                                  {4, inputs.detail_noise, Access::sampled, Sampler::linear_repeat},
                                  {5, lists.ranges, Access::storage_read},
                                  {6, entries_, Access::storage_read},
                                  {7, begins_m_, Access::storage_read},
                                  {8, inputs.counters, Access::storage_read_write},
                                  {9, layer_color, Access::storage_write},
                                  {10, layer_depth, Access::storage_write},
                                  {11, inputs.layer_scene, Access::sampled, Sampler::nearest_clamp},
                                  {12, long_tiles_, Access::storage_read}},
                     .push = as_push(long_lists),
                     .groups = {columns_, rows_, 1}};
    if (long_lists == 1) step.indirect = {&long_tiles_, 0};
    frame.compute(std::move(step));
  };
  shade(shade_short_, 0);
  shade(shade_long_, 1);
}

}  // namespace nephele
