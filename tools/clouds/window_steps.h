// Between which nodes of a lattice the voxels along an axis lie, and what each does to their moments: common to the fit
// on the CPU and on a device.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace nephele::clouds {

// Thinner voxels (one sees 300 km through them) say nothing of where a cloud begins and ends. Their mass counts.
inline constexpr float kFaintestPerM = 1e-5f;

// What one voxel along one axis does to moments.
struct Step {
  std::size_t node;              // of the lower node, counted from the axis' first
  std::array<double, 2> share;   // of the lower node, of the upper one
  std::array<double, 2> from_m;  // from the node
  std::array<double, 2> square;  // mean square distance of the voxel's matter from the node
  double thickness_m;
  float low_m, high_m;
};

struct AxisSteps {
  std::vector<Step> steps;
  int first_node = 0;
  std::size_t nodes = 0;
};

// soft_edge: of windows (shared/volume_moments.h).
AxisSteps axis_steps(const std::vector<double>& bounds_m, double anchor_m, double spacing_m, double soft_edge);

}  // namespace nephele::clouds
