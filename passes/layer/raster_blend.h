// Particles blended as they are drawn, back to front, in images: volume-aware through fragment interlock or ordered
// attachment access ([Yusov14] 5.5), or plain alpha blending, the baseline that every device has.
//
// reads -> writes: draw particles, tables, detail noise, layer scene -> blend state -> layer colour and depth
// cost: fragments (particles times their area in pixels of the layer), each two table fetches and two noise fetches.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/workshop.h"
#include "passes/layer/shading_inputs.h"

namespace nephele {

enum class Backend : std::uint8_t;

class RasterBlend {
 public:
  // backend: interlock, attachment or alpha. The tables must outlive it. For alpha the layer's images are its render
  // targets: attachments.
  RasterBlend(Workshop& make, Backend backend, std::uint32_t layer_width, std::uint32_t layer_height,
              const ShadingVariant& variant);

  struct Inputs {
    const Buffer& frame_constants;
    const Buffer& draw_particles;
    const Buffer& counters;  // FrameCounters: draw is filled
    const ShadingInputs& shading;
    const Image& layer_scene;  // metres to what stands behind, at the layer's size
  };
  void add(FrameBuilder& frame, const Inputs& inputs, const Image& layer_color, const Image& layer_depth);

 private:
  // Of the volume-aware backends: the open segment, where it begins and ends, and what is committed behind it.
  struct State {
    const Image& open;
    const Image& extent;
    const Image& committed;
    const ComputeKernel& clear;
    const ComputeKernel& resolve;
    const Image& interlock_target;  // a render pass needs an attachment
  };
  static State make_state(Workshop& make, Backend backend, std::uint32_t width, std::uint32_t height);

  Backend backend_;
  const RasterPipeline& draw_;
  std::optional<State> state_;  // none: alpha
};

}  // namespace nephele
