#include "tools/clouds/volume_verify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/parallel.h"
#include "shared/hash.h"
#include "tools/clouds/particle_chords.h"
#include "tools/clouds/volume_fit.h"

namespace nephele::clouds {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kTwoPi = 6.283185307179586;
constexpr std::size_t kOutlineSide = 160;  // most pixels along a side of the view

struct Random {
  std::uint32_t state;
  double operator()() { return static_cast<double>(shared::unit_float(shared::hash_next(state))); }
};

}  // namespace

double volume_depth(const MemoryVolume& volume, const glm::dvec3& point_m, const glm::dvec3& direction) {
  const VolumeGrid& grid = volume.grid();
  double enter = -kInfinite, leave = kInfinite;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& bounds = grid.bounds_m[static_cast<std::size_t>(axis)];
    if (direction[axis] == 0.0) {
      if (point_m[axis] < bounds.front() || point_m[axis] >= bounds.back()) return 0.0;
      continue;
    }
    const double a = (bounds.front() - point_m[axis]) / direction[axis];
    const double b = (bounds.back() - point_m[axis]) / direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (!(enter < leave)) return 0.0;
  std::array<std::ptrdiff_t, 3> voxel{};
  std::array<double, 3> next{};  // where the ray leaves the voxel across this axis
  const auto crossing = [&](int axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (direction[axis] == 0.0) return kInfinite;
    const auto bound = static_cast<std::size_t>(voxel[i] + (direction[axis] > 0.0 ? 1 : 0));
    return (grid.bounds_m[i][bound] - point_m[axis]) / direction[axis];
  };
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& bounds = grid.bounds_m[static_cast<std::size_t>(axis)];
    const double at = point_m[axis] + direction[axis] * enter;
    const auto above = std::upper_bound(bounds.begin(), bounds.end(), at);
    voxel[static_cast<std::size_t>(axis)] =
        std::clamp<std::ptrdiff_t>(above - bounds.begin() - 1, 0, static_cast<std::ptrdiff_t>(grid.count(axis)) - 1);
    next[static_cast<std::size_t>(axis)] = crossing(axis);
  }
  double depth = 0.0, at = enter;
  while (at < leave) {
    const auto first = static_cast<std::size_t>(std::min_element(next.begin(), next.end()) - next.begin());
    const double end = std::min(next[first], leave);
    if (end > at)
      depth += (end - at) *
               static_cast<double>(volume.at(static_cast<std::size_t>(voxel[0]), static_cast<std::size_t>(voxel[1]),
                                             static_cast<std::size_t>(voxel[2])));
    at = std::max(at, end);
    const int axis = static_cast<int>(first);
    voxel[first] += direction[axis] > 0.0 ? 1 : -1;
    if (voxel[first] < 0 || voxel[first] >= static_cast<std::ptrdiff_t>(grid.count(axis))) break;
    next[first] = crossing(axis);
  }
  return depth;
}

VolumeTruth::VolumeTruth(const MemoryVolume& volume, std::uint32_t seed) {
  const VolumeGrid& grid = volume.grid();
  std::vector<std::size_t> occupied;
  const auto thickness = [&](std::size_t axis, std::size_t i) {
    return grid.bounds_m[axis][i + 1] - grid.bounds_m[axis][i];
  };
  for (std::size_t z = 0, at = 0; z < grid.count(2); ++z)
    for (std::size_t y = 0; y < grid.count(1); ++y)
      for (std::size_t x = 0; x < grid.count(0); ++x, ++at) {
        const float value = volume.values()[at];
        if (!(value > 0.0f)) continue;
        occupied.push_back(at);
        mass_m2_ += static_cast<double>(value) * thickness(0, x) * thickness(1, y) * thickness(2, z);
      }
  // Through a random point of a random occupied voxel, in a random direction. A volume whose rays are nearly all too
  // thin or too thick yields fewer.
  Random random{seed};
  for (std::size_t tries = 0; !occupied.empty() && rays_.size() < kRays && tries < 20 * kRays; ++tries) {
    const std::size_t at = occupied[std::min(
        occupied.size() - 1, static_cast<std::size_t>(random() * static_cast<double>(occupied.size())))];
    const std::array<std::size_t, 3> voxel{at % grid.count(0), at / grid.count(0) % grid.count(1),
                                           at / grid.count(0) / grid.count(1)};
    Ray ray{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      ray.point_m[static_cast<int>(axis)] = grid.bounds_m[axis][voxel[axis]] + random() * thickness(axis, voxel[axis]);
    const double z = 2.0 * random() - 1.0, turn = kTwoPi * random(), across = std::sqrt(std::max(1.0 - z * z, 0.0));
    ray.direction = {across * std::cos(turn), across * std::sin(turn), z};
    ray.depth = volume_depth(volume, ray.point_m, ray.direction);
    if (ray.depth >= kThinnest && ray.depth <= kThickest) rays_.push_back(ray);
  }
  columns_ = std::min(kOutlineSide, grid.count(0));
  rows_ = std::min(kOutlineSide, grid.count(2));
  const auto pixel = [&](std::size_t axis, std::size_t count) {
    return (grid.bounds_m[axis].back() - grid.bounds_m[axis].front()) / static_cast<double>(count);
  };
  pixel_x_m_ = pixel(0, columns_);
  pixel_z_m_ = pixel(2, rows_);
  for (std::size_t row = 0; row < rows_; ++row)
    for (std::size_t column = 0; column < columns_; ++column) {
      Ray ray{{grid.bounds_m[0].front() + (static_cast<double>(column) + 0.5) * pixel_x_m_, grid.bounds_m[1].front(),
               grid.bounds_m[2].front() + (static_cast<double>(row) + 0.5) * pixel_z_m_},
              {0.0, 1.0, 0.0},
              0.0};
      ray.depth = volume_depth(volume, ray.point_m, ray.direction);
      outline_.push_back(ray);
    }
}

SetErrors VolumeTruth::errors_of(const ParticleSet& set, bool cut) const {
  const ParticleChords chords(set, cut);
  constexpr std::size_t kAtOnce = 64;
  const auto depths_along = [&](const std::vector<Ray>& rays) {
    std::vector<double> depths(rays.size());
    parallel_for(static_cast<int>((rays.size() + kAtOnce - 1) / kAtOnce), [&](int block) {
      const std::size_t begin = static_cast<std::size_t>(block) * kAtOnce;
      for (std::size_t i = begin; i < std::min(begin + kAtOnce, rays.size()); ++i)
        depths[i] = chords.depth(rays[i].point_m, rays[i].direction);
    });
    return depths;
  };
  SetErrors errors{.rays = rays_.size(), .mass_ratio = mass_m2_ > 0.0 ? particle_mass_m2(set) / mass_m2_ : 0.0};
  const std::vector<double> depths = depths_along(rays_);
  double squares = 0.0, log_squares = 0.0;
  std::size_t thick = 0;
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    const double error = std::exp(-depths[i]) - std::exp(-rays_[i].depth);
    squares += error * error;
    if (rays_[i].depth < 1.0) continue;
    const double ratio = std::log(std::max(depths[i], 1e-6) / rays_[i].depth);
    log_squares += ratio * ratio;
    ++thick;
  }
  if (!rays_.empty()) errors.rms_transmittance = std::sqrt(squares / static_cast<double>(rays_.size()));
  if (thick > 0) errors.rms_log_depth = std::sqrt(log_squares / static_cast<double>(thick));

  // The area between the outlines over the length of the volume's, which runs along pixels' edges: 4 / pi too long.
  const std::vector<double> seen = depths_along(outline_);
  const double half = std::log(2.0);
  double area_m2 = 0.0, length_m = 0.0;
  for (std::size_t row = 0; row < rows_; ++row)
    for (std::size_t column = 0; column < columns_; ++column) {
      const std::size_t at = row * columns_ + column;
      const bool dark = outline_[at].depth > half;
      if (dark != (seen[at] > half)) area_m2 += pixel_x_m_ * pixel_z_m_;
      if (column + 1 < columns_ && dark != (outline_[at + 1].depth > half)) length_m += pixel_z_m_;
      if (row + 1 < rows_ && dark != (outline_[at + columns_].depth > half)) length_m += pixel_x_m_;
    }
  if (length_m > 0.0) errors.outline_m = area_m2 / (length_m * kTwoPi / 8.0);
  return errors;
}

}  // namespace nephele::clouds
