#include "passes/light/occlusion.h"

#include <algorithm>

#include "nephele_shaders.h"
#include "shared/types.h"

namespace nephele {

using shared::FrameCounters;

namespace {

const ComputeKernel& kernel(Workshop& make, bool air, bool light_field) {
  const SpecConstant constants[] = {{0, air}, {20, light_field}};
  return make.compute(shaders::occlusion_comp, constants);
}

}  // namespace

Occlusion::Occlusion(Workshop& make, std::uint32_t visible_capacity, std::optional<float> near_m)
    : occlusion_(kernel(make, false, near_m.has_value())),
      occlusion_air_(kernel(make, true, near_m.has_value())),
      near_m_(near_m.value_or(0.0f)),
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
                 .push = as_push(near_m_),
                 .indirect = {&counters, offsetof(FrameCounters, visible_groups)}});
  return lights_;
}

}  // namespace nephele
