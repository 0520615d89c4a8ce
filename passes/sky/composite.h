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
#include <cstdint>
#include <glm/glm.hpp>

#include "engine/workshop.h"
#include "passes/sky/atmosphere.h"
#include "passes/sky/haze_shadow.h"

namespace nephele {

struct CompositeInputs {
  const Buffer* frame_constants = nullptr;
  const AtmosphereTables* atmosphere = nullptr;  // null: black sky, no haze
  const Image* layer_color = nullptr;            // cloud layer: radiance times opacity, transmittance; null: no clouds
  const Image* layer_depth = nullptr;            // metres to the first matter, +inf without
  // Metres to what stands behind, for upscaling; null: the layer has full size (scale 1).
  const Image* layer_scene = nullptr;
  const Image* full_color = nullptr;  // where the upscaled layer is kept; null: nowhere
  const Image* full_depth = nullptr;
  const Image* host_distance = nullptr;  // full size, read if FrameConstants::host_scene; never null
  const Image* host_radiance = nullptr;  // likewise
  const Image* cloud_shadow = nullptr;   // as passes/light/cloud_shadow.h makes it; null: no shadows
};

class CompositePass {
 public:
  // For images of up to this size.
  CompositePass(Workshop& make, std::uint32_t width, std::uint32_t height);

  // hdr: RGBA32F, linear radiance before exposure; display: RGBA8, sRGB. camera_world_m places the ground's pattern.
  void add(FrameBuilder& frame, const CompositeInputs& inputs, const glm::dvec3& camera_world_m, const Image& hdr,
           const Image& display);

 private:
  struct Parts {  // of a frame: the specialisation constants of composite.comp
    bool air, clouds, upscale, keep_layer, shadow;
  };
  struct PartKernels {  // for one set of parts
    const ComputeKernel* tiles;
    const ComputeKernel* sun;
    std::array<const ComputeKernel*, 5> kinds;  // composite_tiles.glsl
  };
  PartKernels kernels(const Parts& parts) const;

  Workshop& make_;
  HazeShadow haze_shadow_;
  // Dummies of one texel. Those for stored images are images of their own: what is both stored and sampled in one frame
  // would need barriers.
  const Image& no_image_;
  const Image& no_volume_;
  const Image& no_full_color_;
  const Image& no_full_depth_;
  const Buffer& tiles_;
};

}  // namespace nephele
