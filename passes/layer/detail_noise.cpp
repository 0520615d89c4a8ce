#include "passes/layer/detail_noise.h"

#include "engine/frame.h"
#include "nephele_shaders.h"

namespace nephele {
namespace {

constexpr std::uint32_t kTexels = 64;  // a side

}  // namespace

DetailNoise::DetailNoise(Kernels& kernels)
    : image_(kernels.device(), "detail_noise", {VK_FORMAT_R8_UNORM, kTexels, kTexels, kTexels}) {
  FrameBuilder frame(kernels.device());
  frame.compute({.name = "detail_noise",
                 .kernel = &kernels.compute(shaders::detail_noise_comp),
                 .bindings = {{0, image_, Access::storage_write}},
                 .groups = {kTexels / 4, kTexels / 4, kTexels / 4}});
  FrameExecutor(kernels.device()).run(frame);
}

}  // namespace nephele
