#include "passes/layer/tiled_blend.h"

#include <algorithm>

#include "nephele_shaders.h"
#include "shared/exact_blend.h"
#include "shared/screen_bounds.h"
#include "shared/types.h"

namespace nephele {

using shared::FrameCounters;

namespace {

// listed: for the tiles of a list, not all with short lists.
const ComputeKernel& shade_kernel(Workshop& make, const ShaderCode& code, bool listed, const ShadingVariant& variant) {
  return make.compute(
      code, variant.after({{0, make.device().tuning().exact_places}, {1, listed}, {2, shared::kShortPlaces}}));
}

// Longest list that shade_short_kernel takes.
std::uint32_t short_list(const Workshop& make, BlendMode mode) {
  return make.device().tuning().pixel_columns && mode == BlendMode::volume ? shared::kColumnPlaces
                                                                           : shared::kShortPlaces;
}

// A column of pixels a thread, or a pixel.
const ComputeKernel& shade_short_kernel(Workshop& make, const GpuTables& tables, BlendMode mode,
                                        const ShadingVariant& variant) {
  const bool volume = mode == BlendMode::volume;
  if (!make.device().tuning().pixel_columns)
    return shade_kernel(make, volume ? shaders::cloud_tiles_comp_volume : shaders::cloud_tiles_comp_exact, false,
                        variant);
  return make.compute(volume ? shaders::cloud_columns_comp_volume : shaders::cloud_columns_comp_exact,
                      variant.after({{2, short_list(make, mode)}, {10, tables.optical_depth().desc().width}}));
}

const ComputeKernel& shade_long_kernel(Workshop& make, BlendMode mode, const ShadingVariant& variant) {
  return shade_kernel(
      make, mode == BlendMode::exact ? shaders::cloud_tiles_comp_exact_long : shaders::cloud_tiles_comp_volume, true,
      variant);
}

const ComputeKernel& shade_page_kernel(Workshop& make, BlendMode mode, const ShadingVariant& variant) {
  return make.compute(mode == BlendMode::exact ? shaders::cloud_pages_comp_exact : shaders::cloud_pages_comp_volume,
                      variant.after({{1, true}}));
}

// What cloud_pages.comp keeps of a tile's pixels between two pages.
VkDeviceSize paged_tile_bytes(BlendMode mode) {
  const VkDeviceSize pixel_bytes =
      mode == BlendMode::exact ? 24 + shared::kExactSlots * sizeof(shared::BlendSegment) : 3 * sizeof(glm::vec4);
  return shared::kScreenTilePx * shared::kScreenTilePx * pixel_bytes;
}

VkDeviceSize bytes_per_pair(BlendMode mode) {
  return std::max<VkDeviceSize>(sizeof(glm::uvec2), paged_tile_bytes(mode) / shared::kPagePlaces + 1);
}

}  // namespace

TiledBlend::TiledBlend(Workshop& make, const GpuTables& tables, BlendMode mode, std::uint32_t layer_width,
                       std::uint32_t layer_height, std::uint32_t visible_capacity, const ShadingVariant& variant)
    : masks_kernel_(make.compute(shaders::screen_masks_comp)),
      begins_kernel_(make.compute(shaders::screen_begins_comp)),
      shade_short_(shade_short_kernel(make, tables, mode, variant)),
      shade_long_(shade_long_kernel(make, mode, variant)),
      lists_(make, "screen_tiles", layer_width, layer_height, visible_capacity, bytes_per_pair(mode)),
      short_list_(short_list(make, mode)),
      pages_(visible_capacity > shared::kPagePlaces ? (visible_capacity + shared::kPagePlaces - 1) / shared::kPagePlaces
                                                    : 0),
      masks_(make.buffer("screen_masks", VkDeviceSize{lists_.pair_capacity()} * sizeof(glm::uvec2))),
      begins_m_(make.buffer("screen_begins", VkDeviceSize{lists_.pair_capacity()} * sizeof(float))),
      long_tiles_(make.buffer("screen_long_tiles", VkDeviceSize{3 + lists_.rows() + lists_.columns() * lists_.rows()} *
                                                       sizeof(std::uint32_t))),
      paged_tiles_(make.buffer("screen_paged_tiles", long_tiles_.bytes())) {
  // Tables and scene aside, a renderer may be asked for the other blend at any time: its kernels are ready, too.
  for (const BlendMode either : {BlendMode::volume, BlendMode::exact}) {
    shade_short_kernel(make, tables, either, variant);
    shade_long_kernel(make, either, variant);
    shade_page_kernel(make, either, variant);
  }
  if (pages_ == 0) return;
  shade_page_ = &shade_page_kernel(make, mode, variant);
  paged_pixels_ =
      &make.buffer("screen_paged_pixels", (lists_.pair_capacity() / shared::kPagePlaces) * paged_tile_bytes(mode));
}

void TiledBlend::add(FrameBuilder& frame, const Inputs& inputs, const Image& layer_color, const Image& layer_depth) {
  const TileLists lists = lists_.add(frame, inputs.frame_constants, inputs.draw_particles, inputs.counters);
  frame.compute({.name = "screen_tiles",
                 .kernel = &masks_kernel_,
                 .bindings = {{0, inputs.frame_constants, Access::uniform},
                              {1, inputs.draw_particles, Access::texels},
                              {2, inputs.counters, Access::storage_read},
                              {3, lists.tiles, Access::words},
                              {4, lists.list, Access::words},
                              {5, lists_.pixels(), Access::words},
                              {6, masks_, Access::storage_write}},
                 .push = as_push(lists_.columns()),
                 .indirect = {&inputs.counters, offsetof(FrameCounters, screen_pair_groups)}});
  frame.fill("screen_tiles", long_tiles_, 0);
  frame.fill("screen_tiles", paged_tiles_, 0);
  frame.compute({.name = "screen_tiles",
                 .kernel = &begins_kernel_,
                 .bindings = {{0, lists.ranges, Access::storage_read},
                              {1, lists.list, Access::words},
                              {2, lists_.near_m(), Access::words},
                              {3, begins_m_, Access::storage_write},
                              {4, long_tiles_, Access::storage_read_write},
                              {5, paged_tiles_, Access::storage_read_write}},
                 .push = as_push(glm::uvec3(lists_.columns(), lists_.rows(), short_list_)),
                 .groups = {(lists_.columns() * lists_.rows() + 31) / 32, 1, 1}});
  const auto shade_step = [&](const ComputeKernel& kernel, const Buffer& tiles) -> ComputeStep {
    return ComputeStep{.name = "shade_blend",
                       .kernel = &kernel,
                       .bindings = {{0, inputs.frame_constants, Access::uniform},
                                    {1, inputs.draw_particles, Access::texels},
                                    {5, lists.ranges, Access::storage_read},
                                    {6, lists.list, Access::words},
                                    {7, begins_m_, Access::words},
                                    {8, inputs.counters, Access::storage_read_write},
                                    {9, layer_color, Access::storage_write},
                                    {10, layer_depth, Access::storage_write},
                                    {11, inputs.layer_scene, Access::sampled, Sampler::nearest_clamp},
                                    {12, tiles, Access::storage_read},
                                    {13, masks_, Access::words}},
                       .indirect = {&tiles, 0}};
  };
  ComputeStep every_tile = shade_step(shade_short_, long_tiles_);
  append_chord_bindings(every_tile.bindings, inputs.shading, bool{inputs.shading.tables.packed_optical_depth()});
  every_tile.indirect = {};
  every_tile.groups = {lists_.columns(), lists_.rows(), 1};
  frame.compute(std::move(every_tile));
  ComputeStep listed = shade_step(shade_long_, long_tiles_);
  append_chord_bindings(listed.bindings, inputs.shading, false);
  frame.compute(std::move(listed));
  for (std::uint32_t page = 0; page < pages_; ++page) {
    ComputeStep step = shade_step(*shade_page_, paged_tiles_);
    append_chord_bindings(step.bindings, inputs.shading, false);
    step.bindings.emplace_back(14, *paged_pixels_, Access::storage_read_write);
    step.push = as_push(page);
    frame.compute(std::move(step));
  }
}

}  // namespace nephele
