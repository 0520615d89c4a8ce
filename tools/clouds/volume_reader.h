// A volume of extinction as the importer sees it, whatever file it lies in: a box of voxels on three sets of parallel
// bounds, read a few planes at a time, so that no volume has to fit in memory. Inside a voxel the extinction is
// constant.
#pragma once

#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/result.h"

namespace nephele::clouds {

struct VolumeGrid {
  // Along x (east), y (north), z (up): where voxels begin and end, ascending; one more than there are voxels. They need
  // not be even: levels of a weather model are not.
  std::array<std::vector<double>, 3> bounds_m;
  // Where the frame of the bounds has its origin in the world. It moves nothing; it only says where the windows of the
  // fit stand, so that a volume that moves or is cropped keeps its nodes.
  glm::dvec3 anchor_m{0.0};

  std::size_t count(int axis) const { return bounds_m[static_cast<std::size_t>(axis)].size() - 1; }
  std::size_t voxels() const { return count(0) * count(1) * count(2); }
};

// count + 1 bounds from `first_m` on, `voxel_m` apart.
std::vector<double> even_bounds(std::size_t count, double first_m, double voxel_m);

inline constexpr std::size_t kMaxVoxelsAlongAxis = 65536;
inline constexpr std::size_t kMaxPlaneVoxels = std::size_t{1} << 26;  // a plane is held in memory

// One line if there are too few or too many voxels, or bounds do not rise.
Result<void> check_grid(const VolumeGrid& grid);

class VolumeReader {
 public:
  virtual ~VolumeReader() = default;

  virtual const VolumeGrid& grid() const = 0;

  // The axes in the order in which values lie in memory, the fastest first; planes are cut across the last one.
  virtual std::array<int, 3> axes() const { return {0, 1, 2}; }

  // The extinction (1/m) of `count` planes from `first` on. Values may be negative (they are taken for 0) or not finite
  // (the fit refuses them).
  virtual Result<void> read_planes(std::size_t first, std::size_t count, std::span<float> values) = 0;

  // What was assumed that the file does not say, each a sentence: for the statistics.
  virtual std::vector<std::string> assumptions() const { return {}; }

  // The times of all steps of a file that has such; the reader is of one of them.
  virtual std::vector<double> times_s() const { return {}; }

  std::size_t planes() const { return grid().count(axes()[2]); }
  std::size_t plane_voxels() const { return grid().count(axes()[0]) * grid().count(axes()[1]); }
};

// A volume in memory, x fastest.
class MemoryVolume : public VolumeReader {
 public:
  MemoryVolume(VolumeGrid grid, std::vector<float> extinction_per_m);

  const VolumeGrid& grid() const override { return grid_; }
  Result<void> read_planes(std::size_t first, std::size_t count, std::span<float> values) override;

  const std::vector<float>& values() const { return extinction_per_m_; }
  float at(std::size_t x, std::size_t y, std::size_t z) const {
    return extinction_per_m_[(z * grid_.count(1) + y) * grid_.count(0) + x];
  }

 private:
  VolumeGrid grid_;
  std::vector<float> extinction_per_m_;
};

// The whole volume, for what must look at it from all sides; negative values become 0. An error above max_voxels.
Result<MemoryVolume> load_volume(VolumeReader& reader, std::size_t max_voxels);

}  // namespace nephele::clouds
