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

class TerrainSurface;

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

  // Whether some of the ground stands out of the plain: a ray from it may meet it again, and it hides the sun.
  bool has_terrain() const { return terrain_ != nullptr; }
  // Whether terrain lets a ray through towards a point of the sun's disc; across, in [-1, 1]^2: which. Always without
  // it.
  bool sun_in_sight(const glm::vec3& p_m, const glm::vec2& across) const;

  // Distance to the ground, terrain included; infinite where the ray misses it or there is none.
  float ground_m(const glm::vec3& p_m, const glm::vec3& direction) const;
  // Of the ground's surface, and a place just above it from which rays may begin.
  glm::vec3 ground_normal(const glm::vec3& p_m) const;
  glm::vec3 off_ground(const glm::vec3& p_m) const;
  // The scene's, of terrain as its height and slope have it; and where the camera sees it with its pattern
  // (shared/ground.h).
  glm::vec3 ground_albedo(const glm::vec3& p_m) const;
  glm::vec3 seen_ground_albedo(const glm::vec3& direction, float distance_m, float pixel_rad) const;

  // Light from beyond all clouds, along a ray that misses the ground.
  glm::vec3 sky(const glm::vec3& p_m, const glm::vec3& direction) const;
  // Of a ray that ends at the ground, so far away. On the way to terrain the light is that of a whole ray, by the share
  // of it that the air before the terrain holds back.
  Air air_to_ground(const glm::vec3& p_m, const glm::vec3& direction, float distance_m) const;
  // Up from the ground, to where the ray meets a cloud.
  Air air_from_ground(const glm::vec3& ground_m, const glm::vec3& p_m, const glm::vec3& direction) const;
  // From the camera to a point in front of it.
  Air air_from_camera(const glm::vec3& direction, float distance_m) const;

  float altitude_m(const glm::vec3& p_m) const;

 private:
  struct AirTables;
  struct SkySlice;
  glm::vec3 vertical(const glm::vec3& p_m) const;
  bool on_terrain(const glm::vec3& p_m) const;
  glm::vec3 land_albedo(const glm::vec3& p_m, float footprint_m) const;
  Air whole_ray(const glm::vec3& p_m, const glm::vec3& direction) const;
  glm::vec3 transmittance_between(const glm::vec3& low_m, const glm::vec3& high_m, const glm::vec3& up) const;
  float cos_zenith(const glm::vec3& p_m, const glm::vec3& direction) const;
  glm::vec3 local(const glm::vec3& p_m, const glm::vec3& direction) const;

  glm::vec3 sun_direction_, sun_irradiance_;
  bool sun_shines_, ground_enabled_;
  glm::vec3 ground_albedo_;
  std::optional<glm::vec3> uniform_sky_;
  glm::dvec3 camera_world_m_;
  float camera_altitude_m_;
  std::unique_ptr<TerrainSurface> terrain_;  // none: a plain
  std::unique_ptr<AirTables> air_;           // none: no atmosphere
};

}  // namespace nephele::truth
