// Terrain for the path tracer: where a ray in render space meets it, and what it is like there. In double precision and
// by formulas of its own; what it shares with the renderer are the heights (engine/terrain_grid.h) and the albedo of
// land (shared/heightfield.h).
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "engine/scene.h"
#include "engine/terrain_grid.h"

namespace nephele::truth {

class TerrainSurface {
 public:
  // camera_world_m: the origin of render space.
  TerrainSurface(const Terrain& terrain, const glm::dvec3& camera_world_m);

  // Distance to the surface, infinite without one. A ray that begins on it leaves it first. Patch by patch; over one
  // the difference of altitudes is taken as quadratic along the ray.
  double hit_m(const glm::dvec3& origin_m, const glm::dvec3& direction) const;

  // Is the place above (or below) the lattice of heights?
  bool covers(const glm::dvec3& p_m) const;

  struct Land {
    glm::dvec3 normal;  // render space; smooth: slopes at vertices are central differences, between them bilinear
    double altitude_m;  // of the place itself
    double slope;       // root of terrain_steepness
    glm::dvec2 from_camera_m;  // over the ground
  };
  Land land(const glm::dvec3& p_m) const;

 private:
  struct Over {
    glm::dvec2 place;  // in spacings from the lattice's first vertex
    double altitude_m;
  };
  Over over(const glm::dvec3& p_m) const;
  glm::dvec2 from_camera_m(const glm::dvec3& p_m) const;
  double patch_m(const glm::ivec2& cell, const glm::dvec2& place) const;
  double step_over_m(const glm::dvec3& origin_m, const glm::dvec3& direction, double at_m, bool& hit) const;

  static constexpr int kBlock = 16;  // patches
  TerrainGrid grid_;
  std::vector<float> steepness_;
  glm::dvec2 camera_;  // over the lattice, in spacings
  double center_m_;    // of the planet, below the camera
  glm::ivec2 blocks_;
  std::vector<float> block_highest_m_;
};

}  // namespace nephele::truth
