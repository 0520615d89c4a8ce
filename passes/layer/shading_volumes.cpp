#include "passes/layer/shading_volumes.h"

#include "engine/frame.h"
#include "nephele_shaders.h"
#include "shared/structure.h"

namespace nephele {
namespace {

constexpr std::uint32_t kDensityVertices = 96;  // a side

}  // namespace

ShadingVolumes::ShadingVolumes(Kernels& kernels, std::uint32_t particle_seed)
    : structure_tile_(
          kernels.device(), "structure_tile",
          {VK_FORMAT_R8_UNORM, shared::kStructureTexels, shared::kStructureTexels, shared::kStructureTexels}),
      particle_density_(kernels.device(), "particle_density",
                        {VK_FORMAT_R16_SFLOAT, kDensityVertices, kDensityVertices, kDensityVertices}) {
  FrameBuilder frame(kernels.device());
  frame.compute({.name = "structure_tile",
                 .kernel = &kernels.compute(shaders::structure_tile_comp),
                 .bindings = {{0, structure_tile_, Access::storage_write}},
                 .groups = {shared::kStructureTexels / 4, shared::kStructureTexels / 4, shared::kStructureTexels / 4}});
  frame.compute({.name = "particle_density",
                 .kernel = &kernels.compute(shaders::particle_density_comp),
                 .bindings = {{0, particle_density_, Access::storage_write}},
                 .push = as_push(particle_seed),
                 .groups = {kDensityVertices / 4, kDensityVertices / 4, kDensityVertices / 4}});
  FrameExecutor(kernels.device()).run(frame);
}

}  // namespace nephele
