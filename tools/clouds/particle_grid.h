// Particles as a volume: the mean extinction in every voxel, a few planes at a time.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/particle_set.h"
#include "engine/scene.h"
#include "tools/clouds/volume_reader.h"

namespace nephele::clouds {

// A particle where it stands.
struct PlacedBody {
  glm::dvec3 center_m{0.0};
  glm::dmat3 shape_m{1.0};  // symmetric, its eigenvalues are the radii
  double extinction_per_m = 0.0;
  std::optional<double> base_m;  // that cuts it
  double top_m = 0.0;
  bool homogeneous = false;  // otherwise of the mean profile
};

std::vector<PlacedBody> bodies_of(const ParticleSet& set, const Placement& at = {});
// Listed particles, and sets as they lie in their files. Fields are made while flying; a scene that has one is refused.
Result<std::vector<PlacedBody>> bodies_of(const Scene& scene);

// The least box of whole voxels that holds all bodies.
VolumeGrid grid_around(const std::vector<PlacedBody>& bodies, double voxel_m);

// Lines through a body, exact along the fastest axis; across it as many in every voxel, at least three along an axis,
// and at least 16 in a body. What they sum to is made the body's own mass. A base cuts what lies below it.
class ParticleGrid : public VolumeReader {
 public:
  // axes: as VolumeReader::axes.
  ParticleGrid(std::vector<PlacedBody> bodies, VolumeGrid grid, std::array<int, 3> axes);

  const VolumeGrid& grid() const override { return grid_; }
  std::array<int, 3> axes() const override { return order_; }
  Result<void> read_planes(std::size_t first, std::size_t count, std::span<float> values) override;

 private:
  struct Lines {  // of a body, across the fastest axis
    glm::dmat3 unit_from_grid;
    std::array<double, 2> begin_m{}, step_m{};  // along the second and the slowest axis
    std::array<int, 2> count{};
    std::array<std::ptrdiff_t, 2> first{}, per_voxel{};  // the first line's number, counted from the grid's bound
    double mass_per_line = 1.0;                          // that makes the sum right
    double low_m = 0.0, high_m = 0.0;                    // along the slowest axis
  };
  void add(const PlacedBody& body, const Lines& lines, std::size_t plane, std::span<double> sums) const;

  std::vector<PlacedBody> bodies_;
  std::vector<Lines> lines_;
  VolumeGrid grid_;
  std::array<int, 3> order_;
};

}  // namespace nephele::clouds
