#include "passes/layer/raster_blend.h"

#include <array>
#include <limits>

#include "nephele_shaders.h"
#include "passes/layer/cloud_layer.h"
#include "shared/blend.h"
#include "shared/types.h"

namespace nephele {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

RasterDesc draw_desc(Backend backend, const ShadingVariant& variant) {
  RasterDesc desc;
  desc.constants = variant.after({});
  desc.vertex = &shaders::cloud_vert;
  if (backend == Backend::attachment) {
    desc.fragment = &shaders::cloud_frag_attachment;
    desc.color_formats.assign(3, VK_FORMAT_R32G32B32A32_SFLOAT);
    desc.ordered = true;
  } else if (backend == Backend::interlock) {
    desc.fragment = &shaders::cloud_frag_interlock;
    desc.color_formats = {VK_FORMAT_R8_UNORM};
    desc.blends = {Blend::none};
  } else {
    desc.fragment = &shaders::cloud_frag_alpha;
    desc.color_formats = {VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R32_SFLOAT};
    desc.blends = {Blend::over, Blend::minimum};
  }
  return desc;
}

std::array<std::uint32_t, 3> groups_of_8(const Image& image) {
  return {(image.desc().width + 7) / 8, (image.desc().height + 7) / 8, 1};
}

}  // namespace

RasterBlend::RasterBlend(Workshop& make, Backend backend, std::uint32_t layer_width, std::uint32_t layer_height,
                         const ShadingVariant& variant)
    : backend_(backend), draw_(make.raster(draw_desc(backend, variant))) {
  if (backend != Backend::alpha) state_.emplace(make_state(make, backend, layer_width, layer_height));
}

RasterBlend::State RasterBlend::make_state(Workshop& make, Backend backend, std::uint32_t width, std::uint32_t height) {
  const bool attachment = backend == Backend::attachment;
  const ImageDesc four_floats{VK_FORMAT_R32G32B32A32_SFLOAT, width, height, 1, attachment};
  const bool interlock = backend == Backend::interlock;
  const ImageDesc target{VK_FORMAT_R8_UNORM, interlock ? width : 1, interlock ? height : 1, 1, true};
  return {make.image("blend_open", four_floats),      make.image("blend_extent", four_floats),
          make.image("blend_committed", four_floats), make.compute(shaders::cloud_clear_comp),
          make.compute(shaders::cloud_resolve_comp),  make.image("interlock_target", target)};
}

void RasterBlend::add(FrameBuilder& frame, const Inputs& inputs, const Image& layer_color, const Image& layer_depth) {
  RasterStep step;
  step.name = "shade_blend";
  step.pipeline = &draw_;
  step.bindings = {{0, inputs.frame_constants, Access::uniform},
                   {1, inputs.draw_particles, Access::storage_read},
                   {8, inputs.layer_scene, Access::sampled, Sampler::nearest_clamp}};
  append_chord_bindings(step.bindings, inputs.shading, false);
  step.indirect = {&inputs.counters, offsetof(shared::FrameCounters, draw)};
  if (!state_) {
    step.color = {&layer_color, &layer_depth};
    step.clear = {{0, 0, 0, 1}, {kInfinity, 0, 0, 0}};
    frame.raster(std::move(step));
    return;
  }
  const Image* images[] = {&state_->open, &state_->extent, &state_->committed};
  if (backend_ == Backend::attachment) {
    for (std::uint32_t i = 0; i < 3; ++i) {
      step.bindings.emplace_back(5 + i, *images[i], Access::color_ordered);
      step.color.push_back(images[i]);
    }
    step.clear = {{0, 0, 0, 0}, {0, 0, shared::kNoMatterM, 0}, {0, 0, 0, 1}};
  } else {
    frame.compute({.name = "shade_blend",
                   .kernel = &state_->clear,
                   .bindings = {{0, state_->open, Access::storage_write},
                                {1, state_->extent, Access::storage_write},
                                {2, state_->committed, Access::storage_write}},
                   .groups = groups_of_8(state_->open)});
    for (std::uint32_t i = 0; i < 3; ++i) step.bindings.emplace_back(5 + i, *images[i], Access::storage_read_write);
    step.color = {&state_->interlock_target};
    step.clear = {{0, 0, 0, 0}};
  }
  frame.raster(std::move(step));
  frame.compute({.name = "resolve",
                 .kernel = &state_->resolve,
                 .bindings = {{0, state_->open, Access::sampled},
                              {1, state_->extent, Access::sampled},
                              {2, state_->committed, Access::sampled},
                              {3, layer_color, Access::storage_write},
                              {4, layer_depth, Access::storage_write}},
                 .groups = groups_of_8(layer_color)});
}

}  // namespace nephele
