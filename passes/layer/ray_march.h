// The clouds by marching rays through the particles' own density: the baseline that particles shaded whole are measured
// against. Tiles of 8x8 pixels list their particles nearest first; a ray goes from one occupied stretch to the next in
// jittered steps that grow with the particles and ends where it is opaque; a filter takes out the noise that the jitter
// leaves.
//
// reads -> writes: draw particles nearest first, counters, tables, scene distance -> lists -> layer colour and depth
// cost: samples (steps in occupied space before the ray is opaque) times the particles that overlap there, one density
// fetch each.
#pragma once

#include <cstdint>

#include "passes/layer/screen_lists.h"
#include "passes/layer/shading_inputs.h"

namespace nephele {

class RayMarch {
 public:
  // steps: how many a marched ray takes across eight particle diameters (16 coarse, 512 fine).
  RayMarch(Workshop& make, std::uint32_t steps, std::uint32_t layer_width, std::uint32_t layer_height,
           std::uint32_t visible_capacity, const ShadingVariant& variant);

  struct Inputs {
    const Buffer& frame_constants;
    const Buffer& draw_particles;  // ViewOrder::nearest_point
    const Buffer& counters;
    const ShadingInputs& shading;
    const Image& layer_scene;  // metres to what stands behind, at the layer's size
  };
  void add(FrameBuilder& frame, const Inputs& inputs, const Image& layer_color, const Image& layer_depth);

 private:
  const ComputeKernel& march_;
  const ComputeKernel& reconstruct_;
  ScreenLists lists_;
  Image& marched_;
  Image& marched_noise_;
};

}  // namespace nephele
