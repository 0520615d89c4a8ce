#include "passes/sky/composite.h"

#include <span>

#include "nephele_shaders.h"
#include "shared/world.h"

namespace nephele {
namespace {

constexpr std::uint32_t kTilePx = 8, kKinds = 5;  // composite_tiles.glsl
constexpr std::uint32_t kMostGroups = 65535;      // along one side of a dispatch, on every device

// The head of composite_tiles.glsl's buffer.
struct TileLists {
  glm::uvec3 groups[kKinds];
  std::uint32_t counts[kKinds];
  glm::vec3 sun_at_lens;
};

struct CompositeGrid {
  std::uint32_t columns, rows, groups_across;
};

using Layer = CompositePass::Layer;

const ShaderCode& composite_code(bool air, bool shadow, Layer layer) {
  switch (layer) {
    case Layer::none:
      return air ? shaders::composite_comp_sky : shaders::composite_comp_vacuum;
    case Layer::full:
      if (air) return shadow ? shaders::composite_comp_sky_clouds_shadow : shaders::composite_comp_sky_clouds;
      return shadow ? shaders::composite_comp_vacuum_clouds_shadow : shaders::composite_comp_vacuum_clouds;
    case Layer::upscaled:
      if (air) return shadow ? shaders::composite_comp_sky_upscale_shadow : shaders::composite_comp_sky_upscale;
      return shadow ? shaders::composite_comp_vacuum_upscale_shadow : shaders::composite_comp_vacuum_upscale;
    case Layer::upscaled_and_kept:
      break;
  }
  if (air) return shadow ? shaders::composite_comp_sky_keep_shadow : shaders::composite_comp_sky_keep;
  return shadow ? shaders::composite_comp_vacuum_keep_shadow : shaders::composite_comp_vacuum_keep;
}

}  // namespace

CompositePass::CompositePass(Workshop& make) : device_(make.device()), haze_shadow_(make) {}

const CompositePass::Kernels& CompositePass::kernels(bool air, bool shadow, Layer layer) {
  const bool clouds = layer != Layer::none;
  Kernels& kernels = kernels_[(air ? 8u : 0u) + (shadow ? 4u : 0u) + static_cast<std::size_t>(layer)];
  if (kernels.tiles) return kernels;
  kernels.tiles =
      ComputeKernel(device_, clouds ? shaders::composite_tiles_comp_clouds : shaders::composite_tiles_comp_clear);
  if (air)
    kernels.sun = ComputeKernel(device_, clouds ? shaders::sun_at_lens_comp_clouds : shaders::sun_at_lens_comp_clear);
  for (std::uint32_t kind = 0; kind < kKinds; ++kind) {
    const SpecConstant constants[] = {{0, kind}};
    kernels.kinds[kind] = ComputeKernel(device_, composite_code(air, shadow, layer), constants);
  }
  return kernels;
}

void CompositePass::add(FrameBuilder& frame, const CompositeInputs& inputs, const glm::dvec3& camera_world_m,
                        const Image& hdr, const Image& display) {
  const AtmosphereTables* air = inputs.atmosphere;
  const bool clouds = inputs.layer_color != nullptr;
  const bool shadow = clouds && inputs.cloud_shadow != nullptr;
  const bool keep = inputs.full_color != nullptr, upscale = inputs.layer_scene != nullptr;
  NEPHELE_CHECK(clouds == (inputs.layer_depth != nullptr), "a cloud layer is colour and depth");
  NEPHELE_CHECK(keep == (inputs.full_depth != nullptr) && (!keep || upscale) && (!upscale || clouds),
                "a full-size layer is colour and depth, upscaled");
  const Kernels& with = kernels(air, shadow,
                                !clouds    ? Layer::none
                                : !upscale ? Layer::full
                                : keep     ? Layer::upscaled_and_kept
                                           : Layer::upscaled);

  const VkExtent3D size = display.extent();
  CompositeGrid grid{(size.width + kTilePx - 1) / kTilePx, (size.height + kTilePx - 1) / kTilePx, 1};
  const std::uint32_t tiles = grid.columns * grid.rows;
  grid.groups_across = (tiles + kMostGroups - 1) / kMostGroups;
  const VkDeviceSize bytes = sizeof(TileLists) + VkDeviceSize{kKinds} * tiles * sizeof(std::uint32_t);
  if (!tiles_ || tiles_.bytes() < bytes) tiles_ = Buffer(device_, "composite_tiles", bytes);

  TileLists none{};
  for (glm::uvec3& groups : none.groups) groups = {grid.groups_across, 0, 1};
  const auto head = std::as_bytes(std::span(&none, 1));
  frame.update("composite", tiles_, {head.begin(), head.end()});
  ComputeStep sort{
      .name = "composite",
      .kernel = &with.tiles,
      .bindings = {{0, *inputs.frame_constants, Access::uniform}, {19, tiles_, Access::storage_read_write}},
      .push = as_push(grid),
      .groups = {(tiles + 63) / 64, 1, 1}};
  if (clouds) sort.bindings.emplace_back(9, *inputs.layer_depth, Access::sampled, Sampler::nearest_clamp);
  frame.compute(std::move(sort));
  if (air) {
    ComputeStep sun{.name = "composite",
                    .kernel = &with.sun,
                    .bindings = {{0, *inputs.frame_constants, Access::storage_read},
                                 {3, air->transmittance, Access::sampled},
                                 {19, tiles_, Access::storage_read_write}}};
    if (clouds) sun.bindings.emplace_back(8, *inputs.layer_color, Access::sampled, Sampler::nearest_clamp);
    frame.compute(std::move(sun));
  }

  std::vector<Binding> bindings = {{0, *inputs.frame_constants, Access::uniform},
                                   {1, hdr, Access::storage_write},
                                   {2, display, Access::storage_write},
                                   {14, *inputs.host_distance, Access::sampled, Sampler::nearest_clamp},
                                   {15, *inputs.host_radiance, Access::sampled, Sampler::nearest_clamp},
                                   {19, tiles_, Access::storage_read}};
  if (air) {
    bindings.insert(bindings.end(), {{3, air->transmittance, Access::sampled},
                                     {4, air->sky_irradiance, Access::sampled},
                                     {5, air->sky_smooth, Access::sampled},
                                     {6, air->sky_aerosol, Access::sampled},
                                     {7, air->view_transmittance, Access::sampled},
                                     {10, air->aerial_light, Access::sampled},
                                     {11, air->aerial_transmittance, Access::sampled}});
  }
  if (clouds) {
    bindings.insert(bindings.end(), {{8, *inputs.layer_color, Access::sampled, Sampler::nearest_clamp},
                                     {9, *inputs.layer_depth, Access::sampled, Sampler::nearest_clamp}});
  }
  if (upscale) bindings.push_back({18, *inputs.layer_scene, Access::sampled, Sampler::nearest_clamp});
  if (keep)
    bindings.insert(bindings.end(),
                    {{16, *inputs.full_color, Access::storage_write}, {17, *inputs.full_depth, Access::storage_write}});
  if (shadow) bindings.push_back({12, *inputs.cloud_shadow, Access::sampled});
  if (shadow && air) {
    const Image& haze = haze_shadow_.add(frame, *inputs.frame_constants, air->transmittance, *inputs.cloud_shadow);
    bindings.push_back({13, haze, Access::sampled});
  }

  struct Push {
    glm::ivec2 ground_origin_index;
    glm::vec2 camera_ground_m;
    CompositeGrid grid;
  };
  const shared::GridPlace place = shared::grid_place(camera_world_m);
  for (std::uint32_t kind = 0; kind < kKinds; ++kind) {
    const bool of_clouds = kind == 1 || kind == 3;
    if (of_clouds && !clouds) continue;
    frame.compute({.name = "composite",
                   .kernel = &with.kinds[kind],
                   .bindings = bindings,
                   .push = as_push(Push{place.origin_index, glm::vec2(place.grid_m), grid}),
                   .indirect = {&tiles_, offsetof(TileLists, groups) + kind * sizeof(glm::uvec3)}});
  }
}

}  // namespace nephele
