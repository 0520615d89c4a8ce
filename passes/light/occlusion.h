// Sunlight at the visible particles ([Yusov14] 5.3 step 2) and the thickness of the cloud around them.
//
// reads -> writes: frame constants, particles, visible list, counters, light tiles, sun transmittance -> lights
// cost: six walks or so through the lists of the tiles that a particle's sample points lie in, from the sun down to the
// point, and kColumnReachM beyond its centre; lists of some hundred particles near the camera. Emissive and unlit
// particles walk none.
#pragma once

#include "passes/light/light_tiles.h"

namespace nephele {

class Occlusion {
 public:
  Occlusion(Workshop& make, std::uint32_t visible_capacity);

  // Returns one ParticleLight per slot of the visible list. The depths leave out the particle itself and stop at
  // kMaxSunOpticalDepth. transmittance is the table that shaders/kit/light_through_air.glsl reads; without one the
  // sunlight is that of the top of the atmosphere, and the planet alone hides it. Step: "occlusion".
  const Buffer& add(FrameBuilder& frame, const Buffer& constants, const Buffer& particles, const Buffer& visible,
                    const Buffer& counters, const LightTileLists& tiles, const Image* transmittance);

 private:
  const ComputeKernel& occlusion_;
  const ComputeKernel& occlusion_air_;
  const Image& no_transmittance_;  // a dummy of one texel, bound without air and never read
  const Buffer& lights_;
};

}  // namespace nephele
