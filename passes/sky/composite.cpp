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

std::uint32_t tiles_across(std::uint32_t pixels) { return (pixels + kTilePx - 1) / kTilePx; }

VkDeviceSize tile_bytes(std::uint32_t tiles) {
  return sizeof(TileLists) + VkDeviceSize{kKinds} * tiles * sizeof(std::uint32_t);
}

// constant_id in composite.comp; composite_tiles.comp and sun_at_lens.comp have kClouds alone.
enum Constant : std::uint32_t { kKind, kAir, kClouds, kUpscale, kKeepLayer, kShadow };

}  // namespace

CompositePass::CompositePass(Workshop& make, std::uint32_t width, std::uint32_t height)
    : make_(make),
      haze_shadow_(make),
      no_image_(make.image("no_image", {})),
      no_volume_(make.image("no_volume", {.force_3d = true})),
      no_full_color_(make.image("no_full_color", {})),
      no_full_depth_(make.image("no_full_depth", {.format = VK_FORMAT_R32_SFLOAT})),
      tiles_(make.buffer("composite_tiles", tile_bytes(tiles_across(width) * tiles_across(height)))) {}

CompositePass::PartKernels CompositePass::kernels(const Parts& parts) const {
  const SpecConstant clouds[] = {{kClouds, parts.clouds}};
  PartKernels kernels{
      &make_.compute(shaders::composite_tiles_comp, clouds), &make_.compute(shaders::sun_at_lens_comp, clouds), {}};
  for (std::uint32_t kind = 0; kind < kKinds; ++kind) {
    const SpecConstant constants[] = {{kKind, kind},
                                      {kAir, parts.air},
                                      {kClouds, parts.clouds},
                                      {kUpscale, parts.upscale},
                                      {kKeepLayer, parts.keep_layer},
                                      {kShadow, parts.shadow}};
    kernels.kinds[kind] = &make_.compute(shaders::composite_comp, constants);
  }
  return kernels;
}

void CompositePass::add(FrameBuilder& frame, const CompositeInputs& inputs, const glm::dvec3& camera_world_m,
                        const Image& hdr, const Image& display) {
  const AtmosphereTables* air = inputs.atmosphere;
  const Parts parts{.air = air != nullptr,
                    .clouds = inputs.layer_color != nullptr,
                    .upscale = inputs.layer_scene != nullptr,
                    .keep_layer = inputs.full_color != nullptr,
                    .shadow = inputs.layer_color && inputs.cloud_shadow};
  NEPHELE_CHECK(parts.clouds == (inputs.layer_depth != nullptr), "a cloud layer is colour and depth");
  NEPHELE_CHECK(parts.keep_layer == (inputs.full_depth != nullptr) && (!parts.keep_layer || parts.upscale) &&
                    (!parts.upscale || parts.clouds),
                "a full-size layer is colour and depth, upscaled");
  const PartKernels with = kernels(parts);
  if (parts.clouds) {  // the sun may rise or set at any time: what it takes without shadows, or with them, is ready
    Parts other = parts;
    other.shadow = !parts.shadow;
    kernels(other);
  }
  // What the frame lacks, no kernel touches: a dummy stands at its binding.
  const auto image_or_none = [this](const Image* image) -> const Image& { return image ? *image : no_image_; };
  const Image &layer_color = image_or_none(inputs.layer_color), &layer_depth = image_or_none(inputs.layer_depth),
              &transmittance = air ? air->transmittance : no_image_;

  const VkExtent3D size = display.extent();
  CompositeGrid grid{tiles_across(size.width), tiles_across(size.height), 1};
  const std::uint32_t tiles = grid.columns * grid.rows;
  grid.groups_across = (tiles + kMostGroups - 1) / kMostGroups;
  NEPHELE_CHECK(tiles_.bytes() >= tile_bytes(tiles), "an image of ", size.width, "x", size.height);

  TileLists none{};
  for (glm::uvec3& groups : none.groups) groups = {grid.groups_across, 0, 1};
  const auto head = std::as_bytes(std::span(&none, 1));
  frame.update("composite", tiles_, {head.begin(), head.end()});
  frame.compute({.name = "composite",
                 .kernel = with.tiles,
                 .bindings = {{0, *inputs.frame_constants, Access::uniform},
                              {9, layer_depth, Access::sampled, Sampler::nearest_clamp},
                              {19, tiles_, Access::storage_read_write}},
                 .push = as_push(grid),
                 .groups = {(tiles + 63) / 64, 1, 1}});
  if (air)
    frame.compute({.name = "composite",
                   .kernel = with.sun,
                   .bindings = {{0, *inputs.frame_constants, Access::storage_read},
                                {3, transmittance, Access::sampled},
                                {8, layer_color, Access::sampled, Sampler::nearest_clamp},
                                {19, tiles_, Access::storage_read_write}}});
  const Image& haze_shadow = parts.shadow && air
                                 ? haze_shadow_.add(frame, *inputs.frame_constants, transmittance, *inputs.cloud_shadow)
                                 : no_volume_;

  const std::vector<Binding> bindings = {
      {0, *inputs.frame_constants, Access::uniform},
      {1, hdr, Access::storage_write},
      {2, display, Access::storage_write},
      {3, transmittance, Access::sampled},
      {4, air ? air->sky_irradiance : no_image_, Access::sampled},
      {5, air ? air->sky_smooth : no_image_, Access::sampled},
      {6, air ? air->sky_aerosol : no_image_, Access::sampled},
      {7, air ? air->view_transmittance : no_image_, Access::sampled},
      {8, layer_color, Access::sampled, Sampler::nearest_clamp},
      {9, layer_depth, Access::sampled, Sampler::nearest_clamp},
      {10, air ? air->aerial_light : no_volume_, Access::sampled},
      {11, air ? air->aerial_transmittance : no_volume_, Access::sampled},
      {12, image_or_none(parts.shadow ? inputs.cloud_shadow : nullptr), Access::sampled},
      {13, haze_shadow, Access::sampled},
      {14, *inputs.host_distance, Access::sampled, Sampler::nearest_clamp},
      {15, *inputs.host_radiance, Access::sampled, Sampler::nearest_clamp},
      {16, parts.keep_layer ? *inputs.full_color : no_full_color_, Access::storage_write},
      {17, parts.keep_layer ? *inputs.full_depth : no_full_depth_, Access::storage_write},
      {18, image_or_none(inputs.layer_scene), Access::sampled, Sampler::nearest_clamp},
      {19, tiles_, Access::storage_read}};
  struct Push {
    glm::ivec2 ground_origin_index;
    glm::vec2 camera_ground_m;
    CompositeGrid grid;
  };
  const shared::GridPlace place = shared::grid_place(camera_world_m);
  for (std::uint32_t kind = 0; kind < kKinds; ++kind) {
    const bool of_clouds = kind == 1 || kind == 3;
    if (of_clouds && !parts.clouds) continue;
    frame.compute({.name = "composite",
                   .kernel = with.kinds[kind],
                   .bindings = bindings,
                   .push = as_push(Push{place.origin_index, glm::vec2(place.grid_m), grid}),
                   .indirect = {&tiles_, offsetof(TileLists, groups) + kind * sizeof(glm::uvec3)}});
  }
}

}  // namespace nephele
