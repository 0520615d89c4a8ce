// The final image: sky, sun and ground behind the cloud layer, aerial perspective in front of everything, exposure
// and tone map. With atmosphere and cloud shadows, one more step before it shades the haze (haze_shadow.h).
//
// reads -> writes: frame constants, atmosphere tables, cloud layer and shadow (each optional) -> HDR and display image
// cost: a handful of look-ups a pixel; ground pixels pay for its pattern (most near the camera, where it has most octaves).
#pragma once

#include <glm/glm.hpp>

#include "engine/frame.h"
#include "passes/atmosphere.h"
#include "passes/haze_shadow.h"

namespace nephele {

struct CompositeInputs {
  const Buffer* frame_constants = nullptr;
  const AtmosphereTables* atmosphere = nullptr;  // null: black sky, no haze
  const Image* cloud_color = nullptr;            // full size: radiance times opacity, transmittance; null: no clouds
  const Image* cloud_depth = nullptr;            // full size: metres to the first matter, +inf without
  const Image* host_distance = nullptr;          // full size, read if FrameConstants::host_scene; never null
  const Image* host_radiance = nullptr;          // likewise
  const Image* cloud_shadow = nullptr;           // as passes/cloud_shadow.h makes it; null: no shadows
};

class CompositePass {
 public:
  explicit CompositePass(Device& device);

  // hdr: RGBA32F, linear radiance before exposure; display: RGBA8, sRGB. camera_world_m places the ground's pattern.
  void add(FrameBuilder& frame, const CompositeInputs& inputs, const glm::dvec3& camera_world_m, const Image& hdr,
           const Image& display);

 private:
  HazeShadow haze_shadow_;
  ComputeKernel sky_, sky_clouds_, sky_clouds_shadow_, vacuum_, vacuum_clouds_, vacuum_clouds_shadow_;
};

}  // namespace nephele
