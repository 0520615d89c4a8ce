// The final image: sky, sun and ground behind the cloud layer, aerial perspective in front of everything, exposure
// and tone map. A layer of lower resolution is brought to the image's on the way. With atmosphere and cloud shadows,
// one more step before it shades the haze (haze_shadow.h).
//
// reads -> writes: frame constants, atmosphere tables, cloud layer and shadow (each optional) -> HDR and display image,
//   the cloud layer at full size
// cost: a handful of look-ups a pixel; ground pixels pay for its pattern (most near the camera, where it has most
// octaves).
//   Tiles of pixels are sorted by what they may show, each kind has a kernel of its own.
#pragma once

#include <array>
#include <glm/glm.hpp>

#include "engine/frame.h"
#include "passes/sky/atmosphere.h"
#include "passes/sky/haze_shadow.h"

namespace nephele {

struct CompositeInputs {
  const Buffer* frame_constants = nullptr;
  const AtmosphereTables* atmosphere = nullptr;  // null: black sky, no haze
  const Image* layer_color = nullptr;            // cloud layer: radiance times opacity, transmittance; null: no clouds
  const Image* layer_depth = nullptr;            // metres to the first matter, +inf without
  const Image* layer_scene =
      nullptr;  // metres to what stands behind, for upscaling; null: the layer has full size (scale 1)
  const Image* full_color = nullptr;  // where the upscaled layer is kept; null: nowhere
  const Image* full_depth = nullptr;
  const Image* host_distance = nullptr;  // full size, read if FrameConstants::host_scene; never null
  const Image* host_radiance = nullptr;  // likewise
  const Image* cloud_shadow = nullptr;   // as passes/light/cloud_shadow.h makes it; null: no shadows
};

class CompositePass {
 public:
  enum class Layer : std::uint8_t { none, full, upscaled, upscaled_and_kept };

  explicit CompositePass(Device& device);

  // hdr: RGBA32F, linear radiance before exposure; display: RGBA8, sRGB. camera_world_m places the ground's pattern.
  void add(FrameBuilder& frame, const CompositeInputs& inputs, const glm::dvec3& camera_world_m, const Image& hdr,
           const Image& display);

 private:
  struct Kernels {  // of one set of inputs
    ComputeKernel tiles, sun;
    std::array<ComputeKernel, 5> kinds;  // composite_tiles.glsl
  };
  const Kernels& kernels(bool air, bool shadow, Layer layer);

  Device& device_;
  HazeShadow haze_shadow_;
  std::array<Kernels, 16> kernels_;  // those that frames so far have asked for
  Buffer tiles_;                     // for the largest image so far
};

}  // namespace nephele
