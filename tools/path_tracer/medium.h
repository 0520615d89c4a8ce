// What a path goes through: extinction at a point, and free paths through it. Clouds of particles (extinction_field.h)
// and volumes of voxels (voxel_field.h) are two of it.
#pragma once

#include <glm/glm.hpp>
#include <limits>

#include "tools/path_tracer/random.h"

namespace nephele::truth {

class Medium {
 public:
  static constexpr float kNever = std::numeric_limits<float>::infinity();

  // The share of emissive matter at a point, and its radiance, weighted by extinction.
  struct Emission {
    float share = 0;
    glm::vec3 radiance_per_sr{0.0f};
  };

  virtual ~Medium() = default;

  // At a point of render space, per metre.
  virtual float extinction_per_m(const glm::vec3& p_m) const = 0;
  virtual Emission emission(const glm::vec3& /*p_m*/) const { return {}; }
  virtual bool emits() const { return false; }
  // Distance to a collision before end_m, exponentially distributed in optical depth; kNever when there is none.
  virtual float collide(const glm::vec3& origin_m, const glm::vec3& direction, float end_m, Random& random) const = 0;
  // Unbiased estimate of the transmittance up to end_m, by ratio tracking (Novak et al. 2014).
  virtual float transmittance(const glm::vec3& origin_m, const glm::vec3& direction, float end_m,
                              Random& random) const = 0;
  // Distance to the first point that counts as matter; kNever without one.
  virtual float first_matter_m(const glm::vec3& origin_m, const glm::vec3& direction, float end_m) const = 0;
  // A rough transmittance towards the sun at p: for deciding where to spend samples, never for radiance.
  virtual float sun_guess(const glm::vec3& p_m) const = 0;
};

}  // namespace nephele::truth
