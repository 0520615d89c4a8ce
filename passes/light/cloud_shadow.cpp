#include "passes/light/cloud_shadow.h"

#include <bit>

#include "nephele_shaders.h"
#include "shared/light.h"

namespace nephele {
namespace {

constexpr std::uint32_t kTiles = shared::kLightTiles * shared::kLightTiles;

const ComputeKernel& kernel_for(Workshop& make, const ShaderCode& code, std::uint32_t texels_per_tile) {
  const SpecConstant texels{0, texels_per_tile};
  return make.compute(code, {&texels, 1});
}

}  // namespace

CloudShadow::CloudShadow(Workshop& make, std::uint32_t texels_per_tile)
    : tiles_kernel_(kernel_for(make, shaders::shadow_tiles_comp, texels_per_tile)),
      kernel_(kernel_for(make, shaders::cloud_shadow_comp, texels_per_tile)),
      side_(shared::kLightTiles * texels_per_tile),
      shadow_(make.image("cloud_shadow", {.format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = side_, .height = side_})),
      shadow_tiles_(make.buffer("shadow_tiles", (4 + kTiles) * sizeof(std::uint32_t))) {
  NEPHELE_CHECK(std::has_single_bit(texels_per_tile) && texels_per_tile <= 8, texels_per_tile, " texels a tile");
}

const Image& CloudShadow::add(FrameBuilder& frame, const Buffer& constants, const LightTileLists& tiles) {
  const std::uint32_t none[] = {0, 1, 1, 0};  // groups of an indirect dispatch, tiles
  frame.update("cloud_shadow", shadow_tiles_, as_push(none));
  frame.compute({.name = "cloud_shadow",
                 .kernel = &tiles_kernel_,
                 .bindings = {{0, constants, Access::uniform}, {1, shadow_tiles_, Access::storage_read_write}},
                 .groups = {(kTiles + 63) / 64, 1, 1}});
  frame.compute({.name = "cloud_shadow",
                 .kernel = &kernel_,
                 .bindings = {{0, constants, Access::uniform},
                              {1, tiles.occluders, Access::texels},
                              {2, tiles.ranges, Access::storage_read},
                              {3, tiles.list, Access::words},
                              {4, shadow_, Access::storage_write},
                              {5, shadow_tiles_, Access::storage_read}},
                 .indirect = {&shadow_tiles_, 0}});
  return shadow_;
}

}  // namespace nephele
