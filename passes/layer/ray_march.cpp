#include "passes/layer/ray_march.h"
#include "nephele_shaders.h"

namespace nephele {
namespace {

const ComputeKernel& march_kernel(Workshop& make, std::uint32_t steps, const ShadingVariant& variant) {
  return make.compute(shaders::cloud_march_comp, variant.after({{0, steps}}));
}

}  // namespace

RayMarch::RayMarch(Workshop& make, std::uint32_t steps, std::uint32_t layer_width, std::uint32_t layer_height,
                   std::uint32_t visible_capacity, const ShadingVariant& variant)
    : march_(march_kernel(make, steps, variant)),
      reconstruct_(make.compute(shaders::march_reconstruct_comp)),
      lists_(make, "march_tiles", layer_width, layer_height, visible_capacity),
      marched_(make.image("marched", {VK_FORMAT_R32G32B32A32_SFLOAT, layer_width, layer_height})),
      marched_noise_(make.image("marched_noise", {VK_FORMAT_R16G16B16A16_SFLOAT, layer_width, layer_height})) {}

void RayMarch::add(FrameBuilder& frame, const Inputs& inputs, const Image& layer_color, const Image& layer_depth) {
  const TileLists lists = lists_.add(frame, inputs.frame_constants, inputs.draw_particles, inputs.counters);
  ComputeStep march{.name = "march",
                    .kernel = &march_,
                    .bindings = {{0, inputs.frame_constants, Access::uniform},
                                 {1, inputs.draw_particles, Access::texels},
                                 {2, lists.ranges, Access::storage_read},
                                 {3, lists.list, Access::words},
                                 {4, lists_.near_m(), Access::words},
                                 {7, inputs.layer_scene, Access::sampled, Sampler::nearest_clamp},
                                 {8, inputs.counters, Access::storage_read_write},
                                 {9, marched_, Access::storage_write},
                                 {10, layer_depth, Access::storage_write},
                                 {11, lists_.pixels(), Access::words},
                                 {12, marched_noise_, Access::storage_write}},
                    .groups = {lists_.columns(), lists_.rows(), 1}};
  append_light_bindings(march.bindings, inputs.shading);
  frame.compute(std::move(march));
  frame.compute({.name = "march",
                 .kernel = &reconstruct_,
                 .bindings = {{0, inputs.frame_constants, Access::uniform},
                              {1, marched_, Access::sampled, Sampler::nearest_clamp},
                              {2, marched_noise_, Access::sampled, Sampler::nearest_clamp},
                              {3, layer_color, Access::storage_write}},
                 .groups = {lists_.columns(), lists_.rows(), 1}});
}

}  // namespace nephele
