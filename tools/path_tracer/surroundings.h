// Everything around the clouds: sun, sky, ground and air. Light in the clear air comes from the atmosphere's own model
// (shared/atmosphere_tables.h), which is no transport in clouds; where clouds shade the ground or light it, the tracer
// finds out by itself.
//
// The air acts between camera and cloud, on the sun's and the sky's light that reaches a point, and between ground and
// cloud; not inside clouds or from one to another. The planet's curvature turns the zenith, but tables are made for the
// sun's height at the camera.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "engine/scene.h"

namespace nephele::truth {

// What a stretch of clear air adds to and leaves of the light behind it.
struct Air {
  glm::vec3 light{0.0f};
  glm::vec3 transmittance{1.0f};
};

class Surroundings {
 public:
  // uniform_sky: this radiance from everywhere, instead of atmosphere and air. top_m: altitude up to which light is
  // asked for.
  Surroundings(const Scene& scene, std::optional<glm::vec3> uniform_sky, float top_m);
  ~Surroundings();

  const glm::vec3& sun_direction() const { return sun_direction_; }
  // Of a surface that faces the sun, without clouds.
  glm::vec3 sun_irradiance(const glm::vec3& p_m) const;
  bool sun_shines() const { return sun_shines_; }

  // Distance to the ground; infinite where the ray misses it or there is none.
  float ground_m(const glm::vec3& p_m, const glm::vec3& direction) const;
  glm::vec3 ground_normal(const glm::vec3& p_m) const;
  // The scene's, and where the camera sees it with its pattern (shared/ground.h).
  const glm::vec3& ground_albedo() const { return ground_albedo_; }
  glm::vec3 seen_ground_albedo(const glm::vec3& direction, float distance_m, float pixel_rad) const;

  // Light from beyond all clouds, along a ray that misses the ground.
  glm::vec3 sky(const glm::vec3& p_m, const glm::vec3& direction) const;
  // Of a ray that ends at the ground.
  Air air_to_ground(const glm::vec3& p_m, const glm::vec3& direction) const;
  // Up from the ground, to where the ray meets a cloud.
  Air air_from_ground(const glm::vec3& ground_m, const glm::vec3& p_m, const glm::vec3& direction) const;
  // From the camera to a point in front of it.
  Air air_from_camera(const glm::vec3& direction, float distance_m) const;

  float altitude_m(const glm::vec3& p_m) const;

 private:
  struct AirTables;
  struct SkySlice;
  float cos_zenith(const glm::vec3& p_m, const glm::vec3& direction) const;
  glm::vec3 local(const glm::vec3& p_m, const glm::vec3& direction) const;

  glm::vec3 sun_direction_, sun_irradiance_;
  bool sun_shines_, ground_enabled_;
  glm::vec3 ground_albedo_;
  std::optional<glm::vec3> uniform_sky_;
  glm::dvec3 camera_world_m_;
  float camera_altitude_m_;
  std::unique_ptr<AirTables> air_;  // none: no atmosphere
};

}  // namespace nephele::truth
