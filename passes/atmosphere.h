// The clear atmosphere's tables after Hillaire 2020 (see shared/atmosphere.h for the model and its deviations).
//
// reads -> writes: frame constants -> transmittance, sky irradiance (once per ground albedo), sky view, aerial
// perspective (every frame)
// cost: fixed, whatever the image size: marches of 7 680 sky rays by 40 steps and of 2 145 haze rays by 47. The lasting
// tables are made in the first frame only: about as much work as twenty frames' tables.
#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "engine/frame.h"

namespace nephele {

// All RGBA32F, per unit of the sun's irradiance, read through shared/atmosphere_tables.h with a linear, clamped sampler.
struct AtmosphereTables {
  Image transmittance;         // to the top of the atmosphere: (way to the top, altitude)
  Image multi_scattering;      // mean radiance scattered more than once: (sun's height, altitude)
  Image sky_irradiance;        // of horizontal surfaces: (sun's height, altitude from above | altitude from below)
  Image sky_smooth;            // whole rays from the camera: (azimuth from the sun, elevation above | below the horizon)
  Image sky_aerosol;           // the same, aerosol's single scattering before its phase function
  Image view_transmittance;    // of those rays: (1, elevation)
  Image aerial_light;          // between camera and distance: (azimuth, elevation, distance)
  Image aerial_transmittance;  // the same
};

class AtmospherePass {
 public:
  explicit AtmospherePass(Device& device);

  struct Params {
    glm::vec3 ground_albedo{0.0f};
    bool aerial_perspective = true;  // only what stands in the air (clouds, a host's scene) needs that table; the ground does not
  };
  // Appends the steps of a frame. The lasting tables are included when this is the first call or the albedo has
  // changed, so every frame built must also be run, in order. frame_constants is a FrameConstants.
  const AtmosphereTables& add(FrameBuilder& frame, const Buffer& frame_constants, const Params& params);

  const AtmosphereTables& tables() const { return tables_; }

 private:
  void add_lasting(FrameBuilder& frame, const glm::vec3& ground_albedo);

  ComputeKernel transmittance_, multi_scattering_, sky_irradiance_, sky_view_, aerial_;
  AtmosphereTables tables_;
  bool has_transmittance_ = false;
  std::optional<glm::vec3> albedo_;  // of the lasting tables
};

}  // namespace nephele
