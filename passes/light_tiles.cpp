#include "passes/light_tiles.h"

#include <algorithm>

#include "shared/light.h"

namespace nephele {

using shared::FrameCounters;

namespace {
constexpr std::uint32_t kTileCount = shared::kLightTiles * shared::kLightTiles;
}

LightTiles::LightTiles(Device& device, std::uint32_t particle_capacity, std::uint32_t pair_capacity)
    : occluders_kernel_(device, shaders::light_occluders_comp),
      count_(device, shaders::light_count_comp),
      emit_(device, shaders::light_emit_comp),
      args_(device, shaders::light_args_comp),
      ranges_kernel_(device, shaders::light_ranges_comp),
      particle_capacity_(std::max(particle_capacity, 1u)),
      pair_capacity_(std::max(pair_capacity, 1u)),
      sun_sort_(device, "sun_sort", particle_capacity_),
      tile_sort_(device, "tile_sort", pair_capacity_),
      scan_(device, particle_capacity_),
      occluders_(device, "light_occluders", particle_capacity_ * sizeof(shared::Occluder)),
      rectangles_(device, "light_rectangles", particle_capacity_ * sizeof(std::uint32_t)),
      places_(device, "light_pair_places", particle_capacity_ * sizeof(std::uint32_t)),
      ranges_(device, "light_tile_ranges", kTileCount * sizeof(glm::uvec2)) {}

LightTileLists LightTiles::add(FrameBuilder& frame, const Buffer& constants, const Buffer& particles,
                               const Buffer& counters) {
  const Indirect per_particle{&counters, offsetof(FrameCounters, particle_groups)};
  const Indirect per_pair{&counters, offsetof(FrameCounters, tile_pair_groups)};

  frame.compute({.name = "light_tiles",
                 .kernel = &occluders_kernel_,
                 .bindings = {{0, constants, Access::uniform},
                              {1, particles, Access::storage_read},
                              {2, counters, Access::storage_read},
                              {3, occluders_, Access::storage_write},
                              {4, rectangles_, Access::storage_write},
                              {5, sun_sort_.keys(), Access::storage_write},
                              {6, sun_sort_.values(), Access::storage_write}},
                 .indirect = per_particle});
  const RadixSort::Sorted by_height =
      sun_sort_.add(frame, "light_tiles", counters, offsetof(FrameCounters, particle_count), shared::kSunKeyBits);
  const Buffer& sun_order = by_height.values;

  frame.compute({.name = "light_tiles",
                 .kernel = &count_,
                 .bindings = {{0, counters, Access::storage_read},
                              {1, sun_order, Access::storage_read},
                              {2, rectangles_, Access::storage_read},
                              {3, places_, Access::storage_write}},
                 .push = as_push(particle_capacity_),
                 .groups = {(particle_capacity_ + 63) / 64, 1, 1}});
  scan_.add(frame, "light_tiles", places_, particle_capacity_, counters, offsetof(FrameCounters, tile_pair_demand));
  frame.compute({.name = "light_tiles",
                 .kernel = &args_,
                 .bindings = {{0, counters, Access::storage_read_write}},
                 .push = as_push(pair_capacity_)});
  frame.compute({.name = "light_tiles",
                 .kernel = &emit_,
                 .bindings = {{0, counters, Access::storage_read},
                              {1, sun_order, Access::storage_read},
                              {2, rectangles_, Access::storage_read},
                              {3, places_, Access::storage_read},
                              {4, tile_sort_.keys(), Access::storage_write},
                              {5, tile_sort_.values(), Access::storage_write}},
                 .push = as_push(pair_capacity_),
                 .indirect = per_particle});
  const RadixSort::Sorted sorted =
      tile_sort_.add(frame, "light_tiles", counters, offsetof(FrameCounters, tile_pair_count), shared::kLightTileBits);

  frame.fill("light_tiles", ranges_, 0);
  frame.compute({.name = "light_tiles",
                 .kernel = &ranges_kernel_,
                 .bindings = {{0, counters, Access::storage_read},
                              {1, sorted.keys, Access::storage_read},
                              {2, ranges_, Access::storage_write}},
                 .indirect = per_pair});
  return {occluders_, ranges_, sorted.values};
}

}  // namespace nephele
