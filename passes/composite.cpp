#include "passes/composite.h"

#include "shared/world.h"

namespace nephele {

CompositePass::CompositePass(Device& device)
    : haze_shadow_(device),
      sky_(device, shaders::composite_comp_sky),
      sky_clouds_(device, shaders::composite_comp_sky_clouds),
      sky_clouds_shadow_(device, shaders::composite_comp_sky_clouds_shadow),
      vacuum_(device, shaders::composite_comp_vacuum),
      vacuum_clouds_(device, shaders::composite_comp_vacuum_clouds),
      vacuum_clouds_shadow_(device, shaders::composite_comp_vacuum_clouds_shadow) {}

void CompositePass::add(FrameBuilder& frame, const CompositeInputs& inputs, const glm::dvec3& camera_world_m,
                        const Image& hdr, const Image& display) {
  const AtmosphereTables* air = inputs.atmosphere;
  const bool clouds = inputs.cloud_color != nullptr;
  const bool shadow = clouds && inputs.cloud_shadow != nullptr;
  NEPHELE_CHECK(clouds == (inputs.cloud_depth != nullptr), "a cloud layer is colour and depth");
  const ComputeKernel* kernel = air ? (shadow ? &sky_clouds_shadow_ : clouds ? &sky_clouds_ : &sky_)
                                    : (shadow ? &vacuum_clouds_shadow_ : clouds ? &vacuum_clouds_ : &vacuum_);
  std::vector<Binding> bindings = {{0, *inputs.frame_constants, Access::uniform},
                                   {1, hdr, Access::storage_write},
                                   {2, display, Access::storage_write},
                                   {14, *inputs.host_distance, Access::sampled, Sampler::nearest_clamp},
                                   {15, *inputs.host_radiance, Access::sampled, Sampler::nearest_clamp}};
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
    bindings.insert(bindings.end(), {{8, *inputs.cloud_color, Access::sampled, Sampler::nearest_clamp},
                                     {9, *inputs.cloud_depth, Access::sampled, Sampler::nearest_clamp}});
  }
  if (shadow) bindings.push_back({12, *inputs.cloud_shadow, Access::sampled});
  if (shadow && air) {
    const Image& haze = haze_shadow_.add(frame, *inputs.frame_constants, air->transmittance, *inputs.cloud_shadow);
    bindings.push_back({13, haze, Access::sampled});
  }

  struct Push {
    glm::ivec2 ground_origin_index;
    glm::vec2 camera_ground_m;
  };
  const shared::GridPlace place = shared::grid_place(camera_world_m);
  const VkExtent3D size = display.extent();
  frame.compute({.name = "composite",
                 .kernel = kernel,
                 .bindings = std::move(bindings),
                 .push = as_push(Push{place.origin_index, glm::vec2(place.grid_m)}),
                 .groups = {(size.width + 7) / 8, (size.height + 7) / 8, 1}});
}

}  // namespace nephele
