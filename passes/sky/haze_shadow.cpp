#include "passes/sky/haze_shadow.h"

#include "nephele_shaders.h"
#include "shared/haze_shadow_volume.h"

namespace nephele {

using namespace shared;

static_assert(kHazeShadowDepth == kHazeShadowSteps / kHazeShadowStepsPerSlice + 1);

HazeShadow::HazeShadow(Workshop& make)
    : kernel_(make.compute(shaders::haze_shadow_comp)),
      volume_(make.image("haze_shadow",
                         {VK_FORMAT_R32G32B32A32_SFLOAT, kHazeShadowWidth, kHazeShadowHeight, kHazeShadowDepth})) {}

const Image& HazeShadow::add(FrameBuilder& frame, const Buffer& frame_constants, const Image& transmittance,
                             const Image& cloud_shadow) {
  frame.compute({.name = "haze_shadow",
                 .kernel = &kernel_,
                 .bindings = {{0, frame_constants, Access::uniform},
                              {1, transmittance, Access::sampled},
                              {2, cloud_shadow, Access::sampled},
                              {3, volume_, Access::storage_write}},
                 .groups = {(kHazeShadowWidth + 7) / 8, (kHazeShadowHeight + 3) / 4, 1}});
  return volume_;
}

}  // namespace nephele
