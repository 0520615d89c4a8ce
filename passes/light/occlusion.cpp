#include "passes/light/occlusion.h"

#include <algorithm>

#include "nephele_shaders.h"
#include "shared/types.h"

namespace nephele {

using shared::FrameCounters;

namespace {

// Specialisation constant 0 of occlusion.comp.
constexpr SpecConstant kWithoutAir[] = {{0, VK_FALSE}}, kWithAir[] = {{0, VK_TRUE}};

}  // namespace

Occlusion::Occlusion(Workshop& make, std::uint32_t visible_capacity)
    : occlusion_(make.compute(shaders::occlusion_comp, kWithoutAir)),
      occlusion_air_(make.compute(shaders::occlusion_comp, kWithAir)),
      no_transmittance_(make.image("no_transmittance", {})),
      lights_(make.buffer("particle_lights", std::max(visible_capacity, 1u) * sizeof(shared::ParticleLight))) {}

const Buffer& Occlusion::add(FrameBuilder& frame, const Buffer& constants, const Buffer& particles,
                             const Buffer& visible, const Buffer& counters, const LightTileLists& tiles,
                             const Image* transmittance) {
  frame.compute({.name = "occlusion",
                 .kernel = transmittance ? &occlusion_air_ : &occlusion_,
                 .bindings = {{0, constants, Access::uniform},
                              {1, particles, Access::texels},
                              {2, visible, Access::storage_read},
                              {3, counters, Access::storage_read},
                              {4, tiles.occluders, Access::texels},
                              {5, tiles.ranges, Access::words},
                              {6, tiles.list, Access::words},
                              {7, lights_, Access::storage_write},
                              {8, transmittance ? *transmittance : no_transmittance_, Access::sampled}},
                 .indirect = {&counters, offsetof(FrameCounters, visible_groups)}});
  return lights_;
}

}  // namespace nephele
