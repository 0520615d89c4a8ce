// Radiance along a ray by path tracing through clouds and surroundings: every order of scattering, albedo 1, no bias.
//
// A path goes backwards from the eye. At every collision the sun is looked for (next-event estimation with ratio
// tracking), at once and past one more scattering in the peak about the sun; then the path scatters by the phase
// function, until it leaves for the sky; the ground reflects diffusely. Nothing is cut off: only Russian roulette ends
// paths early, at the ground and where the sun's light is faint.
#pragma once

#include <glm/glm.hpp>

#include "tools/path_tracer/directions.h"
#include "tools/path_tracer/medium.h"
#include "tools/path_tracer/surroundings.h"

namespace nephele::truth {

// One path's estimates.
struct PathSample {
  glm::vec3 radiance{0.0f};  // the whole picture: clouds, air, ground, sky
  glm::vec3 cloud{0.0f};     // the cloud layer alone, without the air in front of it
  float transmittance = 0;   // of the clouds, up to the ground
};

class PathTracer {
 public:
  PathTracer(const Medium& field, const Surroundings& surroundings, const Phase& phase)
      : field_(field), surroundings_(surroundings), phase_(phase) {}

  // A ray of the camera, which is the origin of render space. pixel_rad: the pixel's height, for the ground's pattern.
  PathSample camera_ray(const glm::vec3& direction, float pixel_rad, Random& random) const;

  // Radiance that arrives at a point from a direction, without any air in front of the first collision.
  glm::vec3 arriving(const glm::vec3& p_m, const glm::vec3& direction, Random& random) const;

 private:
  struct Path;
  // Light scattered by the clouds at p into a ray that arrived along the direction, and by everything behind.
  glm::vec3 from_cloud(const glm::vec3& p_m, const glm::vec3& direction, Random& random) const;
  // Light that leaves the ground at p.
  glm::vec3 from_ground(const glm::vec3& p_m, const glm::vec3& albedo, Random& random) const;
  glm::vec3 follow(Path path, Random& random) const;
  bool scatter_in_cloud(Path& path, Random& random) const;
  glm::vec3 look_sunward(const Path& path, Random& random) const;
  bool sun_in_sight(const glm::vec3& p_m, Random& random) const;
  glm::vec3 sunlight(const glm::vec3& p_m, float effort, Random& random) const;
  float sun_effort(float phase, const glm::vec3& p_m) const;  // how often to look: always where it is bright
  void reflect_from_ground(Path& path, const glm::vec3& albedo, Random& random) const;

  const Medium& field_;
  const Surroundings& surroundings_;
  const Phase& phase_;
};

}  // namespace nephele::truth
