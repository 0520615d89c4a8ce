#include "passes/sky/atmosphere.h"

#include <array>

#include "nephele_shaders.h"
#include "shared/air.h"

namespace nephele {
namespace {

using namespace shared;

Image& table(Workshop& make, const char* name, std::uint32_t width, std::uint32_t height, std::uint32_t depth = 1) {
  return make.image(name, {.format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = width, .height = height, .depth = depth});
}

std::array<std::uint32_t, 3> groups(const Image& image, std::uint32_t local_x, std::uint32_t local_y) {
  const VkExtent3D extent = image.extent();
  return {(extent.width + local_x - 1) / local_x, (extent.height + local_y - 1) / local_y, 1};
}

}  // namespace

AtmospherePass::AtmospherePass(Workshop& make)
    : transmittance_(make.compute(shaders::atmosphere_transmittance_comp)),
      multi_scattering_(make.compute(shaders::atmosphere_multi_scattering_comp)),
      sky_irradiance_(make.compute(shaders::atmosphere_sky_irradiance_comp)),
      sky_view_(make.compute(shaders::atmosphere_sky_view_comp)),
      aerial_(make.compute(shaders::atmosphere_aerial_comp)),
      tables_{.transmittance = table(make, "transmittance", kTransmittanceWidth, kTransmittanceHeight),
              .multi_scattering = table(make, "multi_scattering", kMultiScatteringWidth, kMultiScatteringHeight),
              .sky_irradiance =
                  table(make, "sky_irradiance", kSkyIrradianceWidth, kSkyIrradianceBlocks * kSkyIrradianceHeight),
              .sky_smooth = table(make, "sky_smooth", kSkyViewWidth, kSkyViewHeight),
              .sky_aerosol = table(make, "sky_aerosol", kSkyViewWidth, kSkyViewHeight),
              .view_transmittance = table(make, "view_transmittance", 1, kSkyViewHeight),
              .aerial_light = table(make, "aerial_light", kAerialAzimuths, kAerialElevations, kAerialDistances),
              .aerial_transmittance =
                  table(make, "aerial_transmittance", kAerialAzimuths, kAerialElevations, kAerialDistances)} {}

const AtmosphereTables& AtmospherePass::add(FrameBuilder& frame, const FrameConstants& constants, const Buffer& buffer,
                                            const Params& params) {
  add_lasting(frame, params.ground_albedo);
  const InputBytes needed = as_inputs(constants.camera_grid_m.z, constants.sun_direction.z, params.ground_albedo);
  if (!frame.stands(&tables_.sky_smooth, needed)) add_sky_view(frame, buffer);
  if (params.aerial_perspective && !frame.stands(&tables_.aerial_light, needed)) add_aerial(frame, buffer);
  return tables_;
}

void AtmospherePass::add_sky_view(FrameBuilder& frame, const Buffer& buffer) {
  frame.compute({.name = "sky_view",
                 .kernel = &sky_view_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, tables_.transmittance, Access::sampled},
                              {2, tables_.multi_scattering, Access::sampled},
                              {3, tables_.sky_smooth, Access::storage_write},
                              {4, tables_.sky_aerosol, Access::storage_write},
                              {5, tables_.view_transmittance, Access::storage_write}},
                 .groups = groups(tables_.sky_smooth, 8, 8)});
}

void AtmospherePass::add_aerial(FrameBuilder& frame, const Buffer& buffer) {
  frame.compute({.name = "aerial_perspective",
                 .kernel = &aerial_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, tables_.transmittance, Access::sampled},
                              {2, tables_.multi_scattering, Access::sampled},
                              {3, tables_.aerial_light, Access::storage_write},
                              {4, tables_.aerial_transmittance, Access::storage_write}},
                 .groups = groups(tables_.aerial_light, 8, 8)});
}

void AtmospherePass::add_lasting(FrameBuilder& frame, const glm::vec3& ground_albedo) {
  if (!frame.stands(&tables_.transmittance, {}, Keep::lasting))
    frame.compute({.name = "transmittance",
                   .kernel = &transmittance_,
                   .bindings = {{0, tables_.transmittance, Access::storage_write}},
                   .groups = groups(tables_.transmittance, 8, 8)});
  if (frame.stands(&tables_.multi_scattering, as_inputs(ground_albedo), Keep::lasting)) return;
  frame.compute(
      {.name = "multi_scattering",
       .kernel = &multi_scattering_,
       .bindings = {{0, tables_.transmittance, Access::sampled}, {1, tables_.multi_scattering, Access::storage_write}},
       .push = as_push(ground_albedo),
       .groups = groups(tables_.multi_scattering, 8, 4)});
  frame.compute({.name = "sky_irradiance",
                 .kernel = &sky_irradiance_,
                 .bindings = {{0, tables_.transmittance, Access::sampled},
                              {1, tables_.multi_scattering, Access::sampled},
                              {2, tables_.sky_irradiance, Access::storage_write}},
                 .push = as_push(ground_albedo),
                 .groups = groups(tables_.sky_irradiance, 8, 4)});
}

}  // namespace nephele
