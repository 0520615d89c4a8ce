// The clear atmosphere's tables after Hillaire 2020 (see shared/air.h for the model and its deviations).
//
// reads -> writes: frame constants -> transmittance, sky irradiance (once per ground albedo), sky view, aerial
// perspective (once per altitude of the camera and height of the sun)
// cost: fixed, whatever the image size: marches of 7 680 sky rays by 40 steps and of 2 145 haze rays by 47. The lasting
// tables are made in the first frame only: about as much work as twenty of the camera's.
#pragma once

#include <glm/glm.hpp>

#include "engine/workshop.h"
#include "passes/kit/air_tables.h"
#include "shared/types.h"

namespace nephele {

class AtmospherePass {
 public:
  explicit AtmospherePass(Workshop& make);

  struct Params {
    glm::vec3 ground_albedo{0.0f};
    // Only what stands in the air (clouds, a host's scene) needs this table; the ground does not.
    bool aerial_perspective = true;
  };
  // Appends those steps of a frame whose tables change: the lasting ones in the first frame and when the albedo
  // changes, the camera's when its altitude or the sun's height does, too. buffer holds `constants` when the steps run.
  const AtmosphereTables& add(FrameBuilder& frame, const shared::FrameConstants& constants, const Buffer& buffer,
                              const Params& params);

  const AtmosphereTables& tables() const { return tables_; }

 private:
  void add_lasting(FrameBuilder& frame, const glm::vec3& ground_albedo);
  void add_sky_view(FrameBuilder& frame, const Buffer& buffer);
  void add_aerial(FrameBuilder& frame, const Buffer& buffer);

  const ComputeKernel& transmittance_;
  const ComputeKernel& multi_scattering_;
  const ComputeKernel& sky_irradiance_;
  const ComputeKernel& sky_view_;
  const ComputeKernel& aerial_;
  AtmosphereTables tables_;
};

}  // namespace nephele
