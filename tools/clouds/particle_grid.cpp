#include "tools/clouds/particle_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <variant>

#include "engine/check.h"
#include "engine/parallel.h"
#include "shared/ellipsoid.h"
#include "shared/light.h"
#include "shared/volume_moments.h"

namespace nephele::clouds {
namespace {

constexpr double kLeastLines = 16.0;
constexpr double kLinesPerVoxel = 3.0;
constexpr double kBallVolume = 4.1887902047863905;

double profile_to(double s, double h2, bool homogeneous) {
  return static_cast<double>(shared::profile_integral(static_cast<float>(s), static_cast<float>(h2),
                                                      homogeneous ? shared::kParticleHomogeneous : 0u));
}

// Clockwise seen from above, as yaw is.
glm::dmat3 turn(double angle_rad) {
  const double s = std::sin(angle_rad), c = std::cos(angle_rad);
  return {c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0};  // columns
}

PlacedBody placed(PlacedBody body, const Placement& at) {
  const glm::dmat3 r = turn(at.heading_rad);
  body.center_m = at.at_m + at.scale * (r * body.center_m);
  body.shape_m = at.scale * (r * body.shape_m * glm::transpose(r));
  body.extinction_per_m /= at.scale;
  if (body.base_m) body.base_m = at.at_m.z + at.scale * *body.base_m;
  body.top_m = at.at_m.z + at.scale * body.top_m;
  return body;
}

PlacedBody body_of(const ListedParticle& p) {
  PlacedBody body;
  body.center_m = p.center_m;
  body.shape_m = glm::dmat3(shared::shape_matrix(p.ellipsoid));
  body.extinction_per_m = static_cast<double>(p.extinction_per_m) * static_cast<double>(p.density);
  if (p.base_m) body.base_m = *p.base_m;
  body.top_m = p.top_m ? static_cast<double>(*p.top_m) : p.center_m.z + glm::length(body.shape_m[2]);
  body.homogeneous = p.shape == ParticleShape::homogeneous;
  return body;
}

double extent_m(const PlacedBody& body, int axis) {
  return glm::length(glm::dvec3(body.shape_m[0][axis], body.shape_m[1][axis], body.shape_m[2][axis]));
}

}  // namespace

std::vector<PlacedBody> bodies_of(const ParticleSet& set, const Placement& at) {
  std::vector<PlacedBody> bodies;
  bodies.reserve(set.particles.size());
  for (const SetParticle& p : set.particles) {
    const glm::dvec3 d(p.diagonal_m), o(p.off_diagonal_m);
    bodies.push_back(placed({.center_m = glm::dvec3(p.center_m),
                             .shape_m = {d.x, o.x, o.y, o.x, d.y, o.z, o.y, o.z, d.z},
                             .extinction_per_m = static_cast<double>(p.extinction_per_m),
                             .base_m = static_cast<double>(p.base_m),
                             .top_m = static_cast<double>(p.top_m),
                             .homogeneous = set.shape == ParticleShape::homogeneous},
                            at));
  }
  return bodies;
}

Result<std::vector<PlacedBody>> bodies_of(const Scene& scene) {
  if (!cloud_fields(scene).empty())
    return Error{"it has a field of clouds, which is made while flying; accepted: listed particles and sets alone"};
  std::vector<PlacedBody> bodies;
  for (const ListedParticle& p : scene.particles) bodies.push_back(body_of(p));
  for (const SceneSource& source : scene.sources) {
    if (const auto* group = std::get_if<ParticleGroup>(&source)) {
      for (const ListedParticle& p : group->particles) bodies.push_back(placed(body_of(p), group->placement));
    } else if (const auto* set = std::get_if<PlacedSet>(&source)) {
      for (const SetInstance& own : set->instances.empty() ? std::vector<SetInstance>{SetInstance{}} : set->instances) {
        Placement inner;
        inner.at_m = own.at_m;
        inner.heading_rad = own.heading_rad;
        inner.scale = own.scale;
        for (const PlacedBody& body : bodies_of(*set->set.set, inner)) bodies.push_back(placed(body, set->placement));
      }
    } else {
      return Error{"it has scattered sets, which have no end; accepted: listed particles and placed sets alone"};
    }
  }
  if (bodies.empty()) return Error{"it has no particles"};
  return bodies;
}

VolumeGrid grid_around(const std::vector<PlacedBody>& bodies, double voxel_m) {
  VolumeGrid grid;
  for (int axis = 0; axis < 3; ++axis) {
    double low = INFINITY, high = -INFINITY;
    for (const PlacedBody& body : bodies) {
      low = std::min(low, body.center_m[axis] - extent_m(body, axis));
      high = std::max(high, body.center_m[axis] + extent_m(body, axis));
    }
    const double first = std::floor(low / voxel_m);
    const double count =
        std::clamp(std::ceil(high / voxel_m) - first, 1.0, 4.0 * static_cast<double>(kMaxVoxelsAlongAxis));
    grid.bounds_m[static_cast<std::size_t>(axis)] =
        even_bounds(static_cast<std::size_t>(count), first * voxel_m, voxel_m);
  }
  return grid;
}

ParticleGrid::ParticleGrid(std::vector<PlacedBody> bodies, VolumeGrid grid, std::array<int, 3> axes)
    : bodies_(std::move(bodies)), grid_(std::move(grid)), order_(axes) {
  lines_.resize(bodies_.size());
  parallel_for(static_cast<int>(bodies_.size()), [&](int index) {
    const PlacedBody& body = bodies_[static_cast<std::size_t>(index)];
    Lines& lines = lines_[static_cast<std::size_t>(index)];
    // Rows of the map are put in the reader's order of axes: the columns of its inverse.
    const glm::dmat3 unit_from_world = glm::inverse(body.shape_m);
    for (int i = 0; i < 3; ++i) lines.unit_from_grid[i] = unit_from_world[order_[static_cast<std::size_t>(i)]];
    for (std::size_t i = 0; i < 2; ++i) {
      const int axis = order_[i + 1];
      const std::vector<double>& bounds = grid_.bounds_m[static_cast<std::size_t>(axis)];
      const double extent = extent_m(body, axis), voxel_m = bounds[1] - bounds[0];
      const double first_m = body.center_m[axis] - extent - bounds.front();
      lines.per_voxel[i] = static_cast<std::ptrdiff_t>(
          std::clamp(std::ceil(kLeastLines * voxel_m / (2.0 * extent)), kLinesPerVoxel, 1e6));
      lines.step_m[i] = voxel_m / static_cast<double>(lines.per_voxel[i]);
      lines.first[i] = static_cast<std::ptrdiff_t>(std::floor(first_m / lines.step_m[i]));
      lines.count[i] = static_cast<int>(std::ceil(2.0 * extent / lines.step_m[i])) + 1;
      lines.begin_m[i] =
          bounds.front() + (static_cast<double>(lines.first[i]) + 0.5) * lines.step_m[i] - body.center_m[axis];
      if (i == 1) {
        lines.low_m = body.center_m[axis] - extent;
        lines.high_m = body.center_m[axis] + extent;
      }
    }
    const glm::dvec3 along = lines.unit_from_grid[0];
    const double per_m = glm::length(along);
    double sum = 0.0;
    for (int k = 0; k < lines.count[1]; ++k)
      for (int j = 0; j < lines.count[0]; ++j) {
        const glm::dvec3 o = lines.unit_from_grid[1] * (lines.begin_m[0] + j * lines.step_m[0]) +
                             lines.unit_from_grid[2] * (lines.begin_m[1] + k * lines.step_m[1]);
        const double b = glm::dot(o, along) / per_m, h2 = 1.0 - (glm::dot(o, o) - b * b);
        if (h2 > 0.0) sum += 2.0 * profile_to(std::sqrt(h2), h2, body.homogeneous);
      }
    const double fill = body.homogeneous ? 1.0 : static_cast<double>(shared::kProfileFill);
    const double mass = body.extinction_per_m * fill * kBallVolume * glm::determinant(body.shape_m);
    lines.mass_per_line = sum > 0.0 ? mass / sum : 0.0;
  });
}

void ParticleGrid::add(const PlacedBody& body, const Lines& lines, std::size_t plane, std::span<double> sums) const {
  const std::vector<double>& fast = grid_.bounds_m[static_cast<std::size_t>(order_[0])];
  const std::vector<double>& second = grid_.bounds_m[static_cast<std::size_t>(order_[1])];
  const std::vector<double>& slow = grid_.bounds_m[static_cast<std::size_t>(order_[2])];
  const double fast_m = fast[1] - fast[0];
  const auto fast_count = static_cast<std::ptrdiff_t>(fast.size() - 1);
  const auto second_count = static_cast<std::ptrdiff_t>(second.size() - 1);
  const auto slow_count = static_cast<std::ptrdiff_t>(slow.size() - 1);
  const glm::dvec3 along = lines.unit_from_grid[0];
  const double per_m = glm::length(along);
  for (int k = 0; k < lines.count[1]; ++k) {
    const double w = lines.begin_m[1] + k * lines.step_m[1];
    const std::ptrdiff_t own = std::max<std::ptrdiff_t>(lines.first[1] + k, 0) / lines.per_voxel[1];
    if (std::clamp<std::ptrdiff_t>(own, 0, slow_count - 1) != static_cast<std::ptrdiff_t>(plane)) continue;
    for (int j = 0; j < lines.count[0]; ++j) {
      const double v = lines.begin_m[0] + j * lines.step_m[0];
      const glm::dvec3 o = lines.unit_from_grid[1] * v + lines.unit_from_grid[2] * w;
      const double b = glm::dot(o, along) / per_m, h2 = 1.0 - (glm::dot(o, o) - b * b);
      if (h2 <= 0.0) continue;
      const double reach = std::sqrt(h2);
      // At s in units of the body, the line is at middle_m + s / per_m along the fastest axis.
      const double middle_m = body.center_m[order_[0]] - b / per_m;
      double begin = -reach;
      if (body.base_m) {
        if (order_[0] == 2) {
          begin = std::clamp((*body.base_m - middle_m) * per_m, -reach, reach);
        } else {
          const double z = body.center_m.z + (order_[1] == 2 ? v : w);
          if (z < *body.base_m) continue;
        }
      }
      const auto row = std::clamp<std::ptrdiff_t>(std::max<std::ptrdiff_t>(lines.first[0] + j, 0) / lines.per_voxel[0],
                                                  0, second_count - 1);
      auto i = std::clamp<std::ptrdiff_t>(
          static_cast<std::ptrdiff_t>(std::floor((middle_m + begin / per_m - fast.front()) / fast_m)), 0,
          fast_count - 1);
      double before = profile_to(begin, h2, body.homogeneous);
      for (; i < fast_count; ++i) {
        const double end =
            i + 1 == fast_count ? reach : std::min((fast[static_cast<std::size_t>(i) + 1] - middle_m) * per_m, reach);
        const double here = profile_to(std::max(end, begin), h2, body.homogeneous);
        sums[static_cast<std::size_t>(row * fast_count + i)] += lines.mass_per_line * (here - before);
        before = here;
        if (end >= reach) break;
      }
    }
  }
}

Result<void> ParticleGrid::read_planes(std::size_t first, std::size_t count, std::span<float> values) {
  NEPHELE_CHECK(values.size() == count * plane_voxels() && first + count <= planes());
  const std::vector<double>& slow = grid_.bounds_m[static_cast<std::size_t>(order_[2])];
  const std::size_t plane_size = plane_voxels();
  double voxel_m3 = 1.0;
  for (const std::vector<double>& bounds : grid_.bounds_m) voxel_m3 *= bounds[1] - bounds[0];
  const double slack = 1e-6 * (slow[1] - slow[0]);
  parallel_for(static_cast<int>(count), [&](int index) {
    const std::size_t plane = first + static_cast<std::size_t>(index);
    std::vector<double> sums(plane_size, 0.0);
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      if (lines_[i].high_m >= slow[plane] - slack && lines_[i].low_m <= slow[plane + 1] + slack)
        add(bodies_[i], lines_[i], plane, sums);
    float* to = values.data() + static_cast<std::size_t>(index) * plane_size;
    for (std::size_t i = 0; i < plane_size; ++i) to[i] = static_cast<float>(sums[i] / voxel_m3);
  });
  return {};
}

}  // namespace nephele::clouds
