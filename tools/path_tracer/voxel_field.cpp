#include "tools/path_tracer/voxel_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/check.h"
#include "engine/parallel.h"
#include "shared/world.h"
#include "tools/path_tracer/tracking.h"

namespace nephele::truth {

using glm::ivec3;
using glm::vec3;

namespace {

constexpr int kCellVoxels = 4;  // a side of a cell, of the middle voxel's
constexpr double kMaxCells = 8e6;
constexpr float kGuessShare = 0.8f;   // of the depth towards the sun: some rays find gaps
constexpr float kSliver = 1e-4f;      // of a cell: how far past its border the next one is looked up
constexpr float kMatterPerM = 1e-3f;  // from where on extinction counts as matter

double middle_size(const std::vector<double>& bounds) {
  std::vector<double> sizes;
  for (std::size_t i = 1; i < bounds.size(); ++i) sizes.push_back(bounds[i] - bounds[i - 1]);
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2), sizes.end());
  return sizes[sizes.size() / 2];
}

}  // namespace

VoxelField::VoxelField(Voxels voxels, const Placement& at, const glm::dvec3& camera_m, const vec3& sun_direction)
    : voxels_(std::move(voxels)),
      camera_grid_m_(0.0f, 0.0f, static_cast<float>(camera_m.z)),
      origin_m_(at.at_m - camera_m),
      scale_(static_cast<float>(at.scale)),
      cos_heading_(static_cast<float>(std::cos(at.heading_rad))),
      sin_heading_(static_cast<float>(std::sin(at.heading_rad))) {
  glm::dvec3 low_m(0.0), extent_m(0.0), voxel_m(0.0);
  std::size_t count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& bounds = voxels_.bounds_m[static_cast<std::size_t>(axis)];
    NEPHELE_CHECK(bounds.size() >= 2, "axis ", axis, " has no voxel");
    edges_m_[static_cast<std::size_t>(axis)].assign(bounds.begin(), bounds.end());
    low_m[axis] = bounds.front();
    extent_m[axis] = bounds.back() - bounds.front();
    voxel_m[axis] = middle_size(bounds);
    count *= bounds.size() - 1;
  }
  NEPHELE_CHECK(count == voxels_.extinction_per_m.size(), count, " voxels, ", voxels_.extinction_per_m.size(),
                " values");
  glm::dvec3 cell_m = voxel_m * static_cast<double>(kCellVoxels);
  const glm::dvec3 wanted = extent_m / cell_m;
  const double too_many = wanted.x * wanted.y * wanted.z / kMaxCells;
  if (too_many > 1.0) cell_m *= std::cbrt(too_many);
  cells_ = ivec3(glm::ceil(extent_m / cell_m));
  cell_m_ = vec3(cell_m);
  low_m_ = vec3(low_m);

  bounds_per_m_.assign(static_cast<std::size_t>(cells_.x) * cells_.y * cells_.z, 0.0f);
  // Of each cell along an axis: the voxels that it meets, and one more to each side.
  std::array<std::vector<std::pair<std::size_t, std::size_t>>, 3> meets;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& bounds = voxels_.bounds_m[static_cast<std::size_t>(axis)];
    for (int cell = 0; cell < cells_[axis]; ++cell) {
      const double from_m = low_m[axis] + (cell - 0.01) * cell_m[axis];
      const double to_m = low_m[axis] + (cell + 1.01) * cell_m[axis];
      auto first = std::upper_bound(bounds.begin(), bounds.end(), from_m) - bounds.begin();
      auto last = std::upper_bound(bounds.begin(), bounds.end(), to_m) - bounds.begin();
      const auto voxel_count = static_cast<std::ptrdiff_t>(bounds.size()) - 1;
      first = std::clamp<std::ptrdiff_t>(first - 2, 0, voxel_count - 1);
      last = std::clamp<std::ptrdiff_t>(last, 0, voxel_count - 1);
      meets[static_cast<std::size_t>(axis)].emplace_back(first, last);
    }
  }
  const std::size_t nx = voxels_.bounds_m[0].size() - 1, ny = voxels_.bounds_m[1].size() - 1;
  parallel_for(cells_.z, [&](int z) {
    for (int y = 0; y < cells_.y; ++y)
      for (int x = 0; x < cells_.x; ++x) {
        float most = 0.0f;
        for (std::size_t k = meets[2][static_cast<std::size_t>(z)].first;
             k <= meets[2][static_cast<std::size_t>(z)].second; ++k)
          for (std::size_t j = meets[1][static_cast<std::size_t>(y)].first;
               j <= meets[1][static_cast<std::size_t>(y)].second; ++j) {
            const float* row = &voxels_.extinction_per_m[(k * ny + j) * nx];
            for (std::size_t i = meets[0][static_cast<std::size_t>(x)].first;
                 i <= meets[0][static_cast<std::size_t>(x)].second; ++i)
              most = std::max(most, row[i]);
          }
        bounds_per_m_[cell_index({x, y, z})] = most / scale_ * (1 + 1e-5f);
      }
  });

  // The depth towards the sun along the cells' middles, from the mean of their bounds and their middles' extinction.
  sun_guess_.assign(bounds_per_m_.size(), 1.0f);
  const vec3 step_own = own_direction(sun_direction);
  parallel_for(cells_.z, [&](int z) {
    for (int y = 0; y < cells_.y; ++y)
      for (int x = 0; x < cells_.x; ++x) {
        const std::size_t own = cell_index({x, y, z});
        if (bounds_per_m_[own] <= 0.0f) continue;
        const float step_m = scale_ * std::min({cell_m_.x, cell_m_.y, cell_m_.z});
        vec3 p_m = low_m_ + (vec3(x, y, z) + 0.5f) * cell_m_;
        float depth = 0.0f;
        while (depth < 20.0f) {
          p_m += step_m * step_own;
          const ivec3 cell(glm::floor((p_m - low_m_) / cell_m_));
          if (glm::any(glm::lessThan(cell, ivec3(0))) || glm::any(glm::greaterThanEqual(cell, cells_))) break;
          depth += step_m * at_own_place(p_m);
        }
        sun_guess_[own] = std::exp(-kGuessShare * depth);
      }
  });
}

std::size_t VoxelField::cell_index(const ivec3& cell) const {
  return (static_cast<std::size_t>(cell.z) * cells_.y + cell.y) * cells_.x + cell.x;
}

vec3 VoxelField::own_direction(const vec3& v) const {
  return vec3(cos_heading_ * v.x - sin_heading_ * v.y, sin_heading_ * v.x + cos_heading_ * v.y, v.z) / scale_;
}

vec3 VoxelField::own_place(const vec3& p_m) const {
  return own_direction(shared::grid_from_render(p_m, camera_grid_m_) - camera_grid_m_ - origin_m_);
}

float VoxelField::at_own_place(const vec3& own_m) const {
  std::size_t at = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const std::vector<float>& edges = edges_m_[static_cast<std::size_t>(axis)];
    const auto above = std::upper_bound(edges.begin(), edges.end(), own_m[axis]);
    if (above == edges.begin() || above == edges.end()) return 0.0f;
    at = at * (edges.size() - 1) + static_cast<std::size_t>(above - edges.begin() - 1);
  }
  return voxels_.extinction_per_m[at] / scale_;
}

float VoxelField::extinction_per_m(const vec3& p_m) const { return at_own_place(own_place(p_m)); }

template <class Visit>
void VoxelField::walk(const vec3& origin_m, const vec3& direction, float end_m, Visit&& visit) const {
  const vec3 start = (own_direction(origin_m - origin_m_) - low_m_) / cell_m_;
  const vec3 step = own_direction(direction) / cell_m_;  // cells a metre
  vec3 inverse;
  for (int axis = 0; axis < 3; ++axis)
    inverse[axis] = 1.0f / (std::abs(step[axis]) < 1e-12f ? std::copysign(1e-12f, step[axis]) : step[axis]);
  const vec3 a = -start * inverse, b = (vec3(cells_) - start) * inverse;
  const vec3 enter = glm::min(a, b), leave = glm::max(a, b);
  float at_m = std::max({0.0f, enter.x, enter.y, enter.z});
  const float last_m = std::min({end_m, leave.x, leave.y, leave.z});
  const float sliver_m = kSliver * scale_ * std::min({cell_m_.x, cell_m_.y, cell_m_.z});
  while (at_m < last_m) {
    const float inside_m = at_m + sliver_m + 5e-7f * at_m;
    const ivec3 cell = glm::clamp(ivec3(glm::floor(start + inside_m * step)), ivec3(0), cells_ - 1);
    const vec3 low = (vec3(cell) - start) * inverse, high = (vec3(cell + 1) - start) * inverse;
    const vec3 out = glm::max(low, high);
    const float next_m = std::max(std::min({out.x, out.y, out.z}), inside_m);
    const std::size_t index = cell_index(cell);
    if (bounds_per_m_[index] > 0.0f && visit(index, at_m, std::min(next_m, last_m))) return;
    at_m = next_m;
  }
}

float VoxelField::collide(const vec3& origin_m, const vec3& direction, float end_m, Random& random) const {
  return track_collision(
      random, [&](auto&& visit) { walk(origin_m, direction, end_m, visit); },
      [&](std::size_t cell) { return bounds_per_m_[cell]; },
      [&](std::size_t, float at_m, float) { return extinction_per_m(origin_m + at_m * direction); });
}

float VoxelField::transmittance(const vec3& origin_m, const vec3& direction, float end_m, Random& random) const {
  return track_transmittance(
      random, [&](auto&& visit) { walk(origin_m, direction, end_m, visit); },
      [&](std::size_t cell) { return bounds_per_m_[cell]; },
      [&](std::size_t, float at_m, float) { return extinction_per_m(origin_m + at_m * direction); });
}

float VoxelField::first_matter_m(const vec3& origin_m, const vec3& direction, float end_m) const {
  const float step_m = 0.25f / kCellVoxels * scale_ * std::min({cell_m_.x, cell_m_.y, cell_m_.z});
  float found_m = kNever;
  walk(origin_m, direction, end_m, [&](std::size_t, float near_m, float far_m) {
    for (float at_m = near_m; at_m < far_m; at_m += step_m) {
      if (extinction_per_m(origin_m + at_m * direction) < kMatterPerM) continue;
      found_m = at_m;
      return true;
    }
    return false;
  });
  return found_m;
}

float VoxelField::sun_guess(const vec3& p_m) const {
  const ivec3 cell = glm::clamp(ivec3(glm::floor((own_place(p_m) - low_m_) / cell_m_)), ivec3(0), cells_ - 1);
  return sun_guess_[cell_index(cell)];
}

}  // namespace nephele::truth
