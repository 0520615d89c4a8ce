// Volumes that shading samples and that are the same for all renderers and scenes: the tile of the air's structure
// (shaders/shared/structure.h), and the density inside the smooth reference particle.
//
// writes -> R8 image of 128^3; R16F image of 96^3
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

  const Image& structure_tile() const { return structure_tile_; }      // one period
  const Image& particle_density() const { return particle_density_; }  // shaders/layer/particle_density.comp

 private:
  Image structure_tile_, particle_density_;
};

}  // namespace nephele
