#include "passes/light/occlusion.h"

#include <algorithm>

#include "nephele_shaders.h"
#include "shared/types.h"

namespace nephele {

using shared::FrameCounters;

Occlusion::Occlusion(Workshop& make, std::uint32_t visible_capacity)
    : occlusion_(make.compute(shaders::occlusion_comp)),
      occlusion_air_(make.compute(shaders::occlusion_comp_air)),
      lights_(make.buffer("particle_lights", std::max(visible_capacity, 1u) * sizeof(shared::ParticleLight))) {}

const Buffer& Occlusion::add(FrameBuilder& frame, const Buffer& constants, const Buffer& particles,
                             const Buffer& visible, const Buffer& counters, const LightTileLists& tiles,
                             const Image* transmittance) {
  ComputeStep step{.name = "occlusion",
                   .kernel = transmittance ? &occlusion_air_ : &occlusion_,
                   .bindings = {{0, constants, Access::uniform},
                                {1, particles, Access::texels},
                                {2, visible, Access::storage_read},
                                {3, counters, Access::storage_read},
                                {4, tiles.occluders, Access::texels},
                                {5, tiles.ranges, Access::words},
                                {6, tiles.list, Access::words},
                                {7, lights_, Access::storage_write}},
                   .indirect = {&counters, offsetof(FrameCounters, visible_groups)}};
  if (transmittance) step.bindings.emplace_back(8, *transmittance, Access::sampled);
  frame.compute(std::move(step));
  return lights_;
}

}  // namespace nephele
