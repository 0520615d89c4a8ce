#include "passes/cloud_shadow.h"

#include <bit>

#include "shared/light.h"

namespace nephele {

CloudShadow::CloudShadow(Device& device, std::uint32_t texels_per_tile) : side_(shared::kLightTiles * texels_per_tile) {
  NEPHELE_CHECK(std::has_single_bit(texels_per_tile) && texels_per_tile <= 8, texels_per_tile, " texels a tile");
  const SpecConstant texels{0, texels_per_tile};
  kernel_ = ComputeKernel(device, shaders::cloud_shadow_comp, {&texels, 1});
  shadow_ = Image(device, "cloud_shadow", {.format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = side_, .height = side_});
}

const Image& CloudShadow::add(FrameBuilder& frame, const Buffer& constants, const LightTileLists& tiles) {
  frame.compute({.name = "cloud_shadow",
                 .kernel = &kernel_,
                 .bindings = {{0, constants, Access::uniform},
                              {1, tiles.occluders, Access::storage_read},
                              {2, tiles.ranges, Access::storage_read},
                              {3, tiles.list, Access::storage_read},
                              {4, shadow_, Access::storage_write}},
                 .groups = {side_ * side_ / 64, 1, 1}});
  return shadow_;
}

}  // namespace nephele
