#include "passes/light/light_tiles.h"

#include <algorithm>

#include "nephele_shaders.h"
#include "shared/light.h"

namespace nephele {

using shared::FrameCounters;

LightTiles::LightTiles(Workshop& make, std::uint32_t particle_capacity, std::uint32_t pair_capacity)
    : occluders_kernel_(make.compute(shaders::light_occluders_comp)),
      sun_sort_(make, "sun_sort", std::max(particle_capacity, 1u)),
      pairs_(make, "light_tile", sun_sort_.capacity(), pair_capacity, shared::kLightTiles, shared::kLightTiles),
      occluders_(make.buffer("light_occluders", VkDeviceSize{sun_sort_.capacity()} * sizeof(shared::PackedOccluder))),
      rectangles_(make.buffer("light_rectangles", VkDeviceSize{sun_sort_.capacity()} * sizeof(glm::uvec2))) {}

LightTileLists LightTiles::add(FrameBuilder& frame, const Buffer& constants, const Buffer& particles,
                               const Buffer& counters) {
  frame.compute({.name = "light_tiles",
                 .kernel = &occluders_kernel_,
                 .bindings = {{0, constants, Access::uniform},
                              {1, particles, Access::texels},
                              {2, counters, Access::storage_read},
                              {3, occluders_, Access::storage_write},
                              {4, rectangles_, Access::storage_write},
                              {5, sun_sort_.keys(), Access::storage_write},
                              {6, sun_sort_.values(), Access::storage_write}},
                 .indirect = {&counters, offsetof(FrameCounters, particle_groups)}});
  const RadixSort::Sorted by_height =
      sun_sort_.add(frame, "light_tiles", counters, offsetof(FrameCounters, particle_count), shared::kSunKeyBits);
  const TileLists lists = pairs_.add(frame, "light_tiles", counters,
                                     {.item_count = offsetof(FrameCounters, particle_count),
                                      .item_groups = offsetof(FrameCounters, particle_groups),
                                      .pair_demand = offsetof(FrameCounters, tile_pair_demand),
                                      .pair_count = offsetof(FrameCounters, tile_pair_count),
                                      .pair_groups = offsetof(FrameCounters, tile_pair_groups)},
                                     by_height.values, rectangles_);
  return {occluders_, lists.ranges, lists.list};
}

}  // namespace nephele
