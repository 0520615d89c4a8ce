// Clouds shade the air below and behind them: light shafts and the dark between them.
//
// reads -> writes: frame constants, transmittance, cloud shadow -> light missing from the haze, by pixel and distance
// cost: fixed, whatever the image size: 9 216 rays of 64 steps with one look-up of the shadow each.
#pragma once

#include "engine/workshop.h"

namespace nephele {

class HazeShadow {
 public:
  explicit HazeShadow(Workshop& make);

  // RGBA32F volume, read through shared/haze_shadow_volume.h; cloud_shadow as passes/light/cloud_shadow.h makes it.
  const Image& add(FrameBuilder& frame, const Buffer& frame_constants, const Image& transmittance,
                   const Image& cloud_shadow);

 private:
  const ComputeKernel& kernel_;
  Image& volume_;
};

}  // namespace nephele
