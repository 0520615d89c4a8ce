#include "passes/layer/shading_volumes.h"

#include "engine/frame.h"
#include "nephele_shaders.h"

namespace nephele {
namespace {

constexpr std::uint32_t kNoiseTexels = 64, kDensityVertices = 96;  // a side

}  // namespace

ShadingVolumes::ShadingVolumes(Kernels& kernels, std::uint32_t particle_seed)
    : detail_noise_(kernels.device(), "detail_noise", {VK_FORMAT_R8_UNORM, kNoiseTexels, kNoiseTexels, kNoiseTexels}),
      particle_density_(kernels.device(), "particle_density",
                        {VK_FORMAT_R16_SFLOAT, kDensityVertices, kDensityVertices, kDensityVertices}) {
  FrameBuilder frame(kernels.device());
  frame.compute({.name = "detail_noise",
                 .kernel = &kernels.compute(shaders::detail_noise_comp),
                 .bindings = {{0, detail_noise_, Access::storage_write}},
                 .groups = {kNoiseTexels / 4, kNoiseTexels / 4, kNoiseTexels / 4}});
  frame.compute({.name = "particle_density",
                 .kernel = &kernels.compute(shaders::particle_density_comp),
                 .bindings = {{0, particle_density_, Access::storage_write}},
                 .push = as_push(particle_seed),
                 .groups = {kDensityVertices / 4, kDensityVertices / 4, kDensityVertices / 4}});
  FrameExecutor(kernels.device()).run(frame);
}

}  // namespace nephele
