#include "passes/occlusion.h"

#include <algorithm>

#include "shared/types.h"

namespace nephele {

using shared::FrameCounters;

Occlusion::Occlusion(Device& device, std::uint32_t visible_capacity)
    : occlusion_(device, shaders::occlusion_comp),
      occlusion_air_(device, shaders::occlusion_comp_air),
      smooth_(device, shaders::occlusion_smooth_comp),
      lights_(device, "particle_lights", std::max(visible_capacity, 1u) * sizeof(shared::ParticleLight)) {}

const Buffer& Occlusion::add(FrameBuilder& frame, const Buffer& constants, const Buffer& particles,
                             const Buffer& visible, const Buffer& counters, const LightTileLists& tiles,
                             const Image* transmittance) {
  const Indirect per_visible{&counters, offsetof(FrameCounters, visible_groups)};
  const std::vector<Binding> inputs = {{0, constants, Access::uniform},
                                       {1, particles, Access::storage_read},
                                       {2, visible, Access::storage_read},
                                       {3, counters, Access::storage_read},
                                       {4, tiles.occluders, Access::storage_read},
                                       {5, tiles.ranges, Access::storage_read},
                                       {6, tiles.list, Access::storage_read}};

  ComputeStep estimate{.name = "occlusion", .kernel = &occlusion_, .bindings = inputs, .indirect = per_visible};
  estimate.bindings.emplace_back(7, lights_, Access::storage_write);
  if (transmittance) {
    estimate.kernel = &occlusion_air_;
    estimate.bindings.emplace_back(8, *transmittance, Access::sampled);
  }
  frame.compute(std::move(estimate));

  ComputeStep smooth{.name = "occlusion_smooth", .kernel = &smooth_, .bindings = inputs, .indirect = per_visible};
  smooth.bindings.emplace_back(7, lights_, Access::storage_read_write);
  frame.compute(std::move(smooth));
  return lights_;
}

}  // namespace nephele
