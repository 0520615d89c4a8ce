// A volume of voxels as a participating medium: extinction constant inside a voxel, nothing outside the volume. What an
// imported set is judged against.
//
// Tracking runs on a uniform grid of cells that bound the extinction in and around them (Woodcock 1965). Rays run
// straight in the volume's own frame, as if the ground were flat; where a voxel is looked up the planet's curvature
// counts, and the cells' bounds reach a voxel farther than the cells. So places are exact within the distance at which
// the ground has dropped by a voxel: 14 km for voxels of 16 m.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/scene.h"
#include "tools/path_tracer/medium.h"

namespace nephele::truth {

struct Voxels {
  std::array<std::vector<double>, 3> bounds_m;  // along x, y, z, ascending; one more than there are voxels
  std::vector<float> extinction_per_m;          // x fastest; not negative
};

class VoxelField final : public Medium {
 public:
  // at: where the frame of the bounds stands, as a set's does. camera_m: in the air that the volume stands still in.
  VoxelField(Voxels voxels, const Placement& at, const glm::dvec3& camera_m, const glm::vec3& sun_direction);

  float extinction_per_m(const glm::vec3& p_m) const override;
  float collide(const glm::vec3& origin_m, const glm::vec3& direction, float end_m, Random& random) const override;
  float transmittance(const glm::vec3& origin_m, const glm::vec3& direction, float end_m,
                      Random& random) const override;
  float first_matter_m(const glm::vec3& origin_m, const glm::vec3& direction, float end_m) const override;
  float sun_guess(const glm::vec3& p_m) const override;

 private:
  glm::vec3 own_place(const glm::vec3& p_m) const;    // in the volume's frame, the planet's curvature undone
  glm::vec3 own_direction(const glm::vec3& v) const;  // metres in the volume's frame, a metre of the ray each
  float at_own_place(const glm::vec3& own_m) const;   // extinction of the world's metres
  std::size_t cell_index(const glm::ivec3& cell) const;
  // Calls visit(cell, near_m, far_m) for every cell with matter along the ray, in order, until it returns true.
  template <class Visit>
  void walk(const glm::vec3& origin_m, const glm::vec3& direction, float end_m, Visit&& visit) const;

  Voxels voxels_;
  std::array<std::vector<float>, 3> edges_m_;  // bounds as floats
  glm::vec3 camera_grid_m_, origin_m_;         // of the volume's frame, from the camera
  float scale_, cos_heading_, sin_heading_;
  glm::vec3 low_m_, cell_m_;  // of the grid of cells, in the volume's frame
  glm::ivec3 cells_;
  std::vector<float> bounds_per_m_;  // no less than the extinction anywhere in the cell
  std::vector<float> sun_guess_;
};

}  // namespace nephele::truth
