#include "tools/clouds/volume_reader.h"

#include <algorithm>
#include <cmath>

#include "engine/check.h"

namespace nephele::clouds {
namespace {

constexpr std::size_t kSlabVoxels = std::size_t{1} << 22;
constexpr double kMostM = 1e7;

}  // namespace

std::vector<double> even_bounds(std::size_t count, double first_m, double voxel_m) {
  std::vector<double> bounds(count + 1);
  for (std::size_t i = 0; i <= count; ++i) bounds[i] = first_m + static_cast<double>(i) * voxel_m;
  return bounds;
}

Result<void> check_grid(const VolumeGrid& grid) {
  constexpr const char* kAxisNames[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& bounds = grid.bounds_m[static_cast<std::size_t>(axis)];
    if (bounds.size() < 2 || bounds.size() - 1 > kMaxVoxelsAlongAxis)
      return Error{concat(bounds.empty() ? 0 : bounds.size() - 1, " voxels along ", kAxisNames[axis],
                          "; accepted: 1 to ", kMaxVoxelsAlongAxis)};
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      if (!(std::abs(bounds[i]) <= kMostM))
        return Error{
            concat("a bound along ", kAxisNames[axis], " is ", bounds[i], " m; accepted: -", kMostM, " to ", kMostM)};
      if (i > 0 && !(bounds[i] > bounds[i - 1]))
        return Error{
            concat("bounds along ", kAxisNames[axis], " do not rise: ", bounds[i - 1], " m, then ", bounds[i], " m")};
    }
  }
  for (int axis = 0; axis < 3; ++axis)
    if (grid.count(axis) * grid.count((axis + 1) % 3) > kMaxPlaneVoxels)
      return Error{concat(grid.count(0), " x ", grid.count(1), " x ", grid.count(2), " voxels; accepted: at most ",
                          kMaxPlaneVoxels, " in a plane")};
  return {};
}

MemoryVolume::MemoryVolume(VolumeGrid grid, std::vector<float> extinction_per_m)
    : grid_(std::move(grid)), extinction_per_m_(std::move(extinction_per_m)) {
  NEPHELE_CHECK(extinction_per_m_.size() == grid_.voxels(), extinction_per_m_.size(), " ", grid_.voxels());
}

Result<void> MemoryVolume::read_planes(std::size_t first, std::size_t count, std::span<float> values) {
  const std::size_t plane = plane_voxels();
  NEPHELE_CHECK(values.size() == count * plane && first + count <= planes());
  std::copy_n(extinction_per_m_.begin() + static_cast<std::ptrdiff_t>(first * plane), count * plane, values.begin());
  return {};
}

Result<MemoryVolume> load_volume(VolumeReader& reader, std::size_t max_voxels) {
  const VolumeGrid& grid = reader.grid();
  if (grid.voxels() > max_voxels)
    return Error{
        concat("a volume of ", grid.voxels(), " voxels; accepted where all of it is looked at: at most ", max_voxels)};
  std::vector<float> all(grid.voxels());
  const std::array<int, 3> axes = reader.axes();
  const std::array<std::size_t, 3> strides{1, grid.count(0), grid.count(0) * grid.count(1)};
  const auto stride = [&](int i) { return strides[static_cast<std::size_t>(axes[static_cast<std::size_t>(i)])]; };
  const std::size_t plane = reader.plane_voxels(), planes = reader.planes();
  const std::size_t at_once = std::clamp<std::size_t>(kSlabVoxels / plane, 1, planes);
  std::vector<float> slab(at_once * plane);
  for (std::size_t first = 0; first < planes; first += at_once) {
    const std::size_t count = std::min(at_once, planes - first);
    const std::span<float> values = std::span(slab).first(count * plane);
    if (auto ok = reader.read_planes(first, count, values); !ok) return ok.error();
    std::size_t at = 0;
    for (std::size_t p = first; p < first + count; ++p)
      for (std::size_t j = 0; j < grid.count(axes[1]); ++j)
        for (std::size_t i = 0; i < grid.count(axes[0]); ++i, ++at)
          all[p * stride(2) + j * stride(1) + i * stride(0)] = std::max(values[at], 0.0f);
  }
  return MemoryVolume(grid, std::move(all));
}

}  // namespace nephele::clouds
