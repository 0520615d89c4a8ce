// Sunlight at the visible particles ([Yusov14] 5.3 step 2).
//
// reads -> writes: frame constants, particles, visible list, counters, light tiles, sun transmittance -> lights
// cost: about four walks a particle through the lists of the light tiles that its sample points lie in, each from the
// sun down to the point. A list has some hundred particles near the camera. No list is walked for particles that emit
// light or that no sunlight reaches.
#pragma once

#include <cstdint>
#include <optional>

#include "passes/light/light_tiles.h"

namespace nephele {

class Occlusion {
 public:
  // near_m: with the light field, how near to the camera a particle's own depths are wanted; else all are.
  Occlusion(Workshop& make, std::uint32_t visible_capacity, std::optional<float> near_m);

  // Returns one ParticleLight per slot of the visible list. The depths leave out the particle itself and stop at
  // kMaxSunOpticalDepth. transmittance is the table that shaders/kit/light_through_air.glsl reads; without one the
  // sunlight is that of the top of the atmosphere, and the planet alone hides it. Step: "occlusion".
  const Buffer& add(FrameBuilder& frame, const Buffer& constants, const Buffer& particles, const Buffer& visible,
                    const Buffer& counters, const LightTileLists& tiles, const Image* transmittance);

 private:
  const ComputeKernel& occlusion_;
  const ComputeKernel& occlusion_air_;
  float near_m_;
  const Image& no_transmittance_;  // a dummy of one texel, bound without air and never read
  const Buffer& lights_;
};

}  // namespace nephele
