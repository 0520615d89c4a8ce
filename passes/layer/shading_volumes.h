// Volumes that shading samples and that are the same for all renderers and scenes: the fine noise that particles have
// at their edges, and the density inside the reference particle.
//
// writes -> R8 image of 64^3; R16F image of 96^3
// cost: once, at the start.
#pragma once

#include <cstdint>

#include "engine/kernels.h"
#include "engine/resources.h"

namespace nephele {

class ShadingVolumes {
 public:
  // Made when this returns. particle_seed: of the reference particle (TableParameters).
  ShadingVolumes(Kernels& kernels, std::uint32_t particle_seed);

  const Image& detail_noise() const { return detail_noise_; }          // one period
  const Image& particle_density() const { return particle_density_; }  // shaders/layer/particle_density.comp

 private:
  Image detail_noise_, particle_density_;
};

}  // namespace nephele
