// The clouds' shadow: transmittance towards the sun in warped light space, for the ground and for light shafts.
//
// reads -> writes: frame constants, light tiles -> RGBA32F image of (kLightTiles * texels_per_tile)^2: opacity, and
// multiplied by it the warped w of the clouds' top, mean and bottom (shaders/kit/cloud_shadow_lookup.glsl has the
// look-up). Half floats would do for the opacity, but they would round the place of clouds seen from 200 km up to steps
// of 500 m.
// cost: every texel that a look-up from the camera's view can reach walks its tile's list until the light is gone; the
// others keep the values of an earlier frame, which nobody reads.
#pragma once

#include <cstdint>

#include "passes/light/light_tiles.h"

namespace nephele {

class CloudShadow {
 public:
  // texels_per_tile: 1, 2, 4 or 8. Near the camera a tile is some 130 m wide.
  CloudShadow(Workshop& make, std::uint32_t texels_per_tile);

  const Image& add(FrameBuilder& frame, const Buffer& constants, const LightTileLists& tiles);

 private:
  const ComputeKernel& tiles_kernel_;
  const ComputeKernel& kernel_;
  std::uint32_t side_;
  Image& shadow_;
  Buffer& shadow_tiles_;
};

}  // namespace nephele
