#include "tools/path_tracer/extinction_field.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/parallel.h"
#include "shared/ellipsoid.h"
#include "shared/flat_base.h"
#include "shared/light.h"
#include "shared/reference_particle.h"
#include "shared/structure.h"
#include "shared/world.h"
#include "tools/path_tracer/tracking.h"

namespace nephele::truth {

using glm::ivec3;
using glm::vec3;

namespace {

constexpr int kBlockCells = 8;
constexpr double kMaxCells = 4e6;
constexpr float kCellsPerRadius = 4.0f;  // of the middle particle; finer cells bound no better than they cost
constexpr float kSliver = 1e-4f;         // of a cell: how far past its border the next one is looked up
constexpr float kResolution = 0x1p-21f;  // a few units in a float's last place
constexpr float kMatterSteps = 16.0f;    // a cell, in search of the first matter
constexpr float kFarAboveM = 1e30f;      // an altitude above every base
constexpr float kProfilePeak = 0.85f;    // up to this q particle_profile grows; beyond, it is at most kMostProfile
constexpr float kMostProfile = 1.07f;
constexpr float kGuessShare = 0.8f;  // of the mean depth: some rays find gaps

// The distances at which a ray enters and leaves a box.
struct Span {
  float near_m, far_m;
};
Span box_span(const vec3& low, const vec3& high, const vec3& origin, const vec3& inverse) {
  const vec3 a = (low - origin) * inverse, b = (high - origin) * inverse;
  const vec3 enter = glm::min(a, b), leave = glm::max(a, b);
  return {std::max({enter.x, enter.y, enter.z}), std::min({leave.x, leave.y, leave.z})};
}

vec3 inverse_of(const vec3& direction) {
  const auto safe = [](float x) { return 1.0f / (std::abs(x) < 1e-12f ? std::copysign(1e-12f, x) : x); };
  return {safe(direction.x), safe(direction.y), safe(direction.z)};
}

}  // namespace

ExtinctionField::ExtinctionField(std::span<const shared::Particle> particles, const vec3& camera_grid_m,
                                 const vec3& sun_direction, const DensityLattice& lattice)
    : lattice_(lattice), structure_(camera_grid_m), camera_altitude_m_(camera_grid_m.z) {
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const shared::Particle& p = particles[i];
    emitted_.push_back(p.radiance_per_sr);
    if (!(p.extinction_per_m > 0.0f)) continue;
    Packed packed{.center_m = p.center_m,
                  .extinction_per_m = p.extinction_per_m,
                  .base_m = p.base_m,
                  .flags = p.flags,
                  .source = static_cast<std::uint32_t>(i),
                  .structure_depth = shared::structure_depth(shared::mean_radius_m(p.shape), p.flags),
                  .soft_detail = shared::soft_detail(p.flags)};
    const glm::vec4 orientation = shared::unpack_orientation(p.orientation);
    const glm::mat3 to_unit = shared::unit_from_render(p.shape);
    for (int axis = 0; axis < 3; ++axis)
      packed.unit_from_render[axis] = shared::quaternion_rotate_inverse(orientation, to_unit[axis]);
    particles_.push_back(packed);
    emits_ = emits_ || (p.flags & shared::kParticleEmissive) != 0u;
  }
  make_grid();
  fill_cells();
  guess_sun(sun_direction);
}

// Half the extent of an ellipsoid along the axes: the rows of the inverse map.
static vec3 reach_of(const glm::mat3& unit_from_render) {
  const glm::mat3 rows = glm::transpose(glm::inverse(unit_from_render));
  return {glm::length(rows[0]), glm::length(rows[1]), glm::length(rows[2])};
}

void ExtinctionField::make_grid() {
  if (particles_.empty()) {
    first_.assign(2, 0);
    bounds_per_m_.assign(1, 0.0f);
    block_filled_.assign(1, 0);
    cut_.assign(1, 0);
    return;
  }
  low_m_ = vec3(kNever);
  high_m_ = vec3(-kNever);
  std::vector<float> radii;
  for (const Packed& p : particles_) {
    const vec3 reach = reach_of(p.unit_from_render);
    low_m_ = glm::min(low_m_, p.center_m - reach);
    high_m_ = glm::max(high_m_, p.center_m + reach);
    radii.push_back(std::cbrt(1.0f / std::abs(glm::determinant(p.unit_from_render))));
  }
  std::nth_element(radii.begin(), radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2), radii.end());
  const glm::dvec3 extent(high_m_ - low_m_);
  cell_m_ = std::max(radii[radii.size() / 2] / kCellsPerRadius,
                     static_cast<float>(std::cbrt(extent.x * extent.y * extent.z / kMaxCells)));
  size_ = ivec3(glm::ceil((high_m_ - low_m_) / cell_m_)) + 1;
  blocks_ = (size_ + kBlockCells - 1) / kBlockCells;
}

void ExtinctionField::fill_cells() {
  if (particles_.empty()) return;
  struct Entry {
    std::uint32_t cell, particle;
  };
  std::vector<Entry> entries;
  bounds_per_m_.assign(static_cast<std::size_t>(size_.x) * size_.y * size_.z, 0.0f);
  block_filled_.assign(static_cast<std::size_t>(blocks_.x) * blocks_.y * blocks_.z, 0);
  cut_.assign(bounds_per_m_.size(), 0);
  const float half_m = 0.5f * cell_m_ * (1 + 2 * kSliver);  // a ray may be a sliver outside the cell it is looked up in
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    const Packed& p = particles_[i];
    const vec3 reach = reach_of(p.unit_from_render) + vec3(kSliver * cell_m_);
    const vec3 half_extent =
        half_m * (glm::abs(p.unit_from_render[0]) + glm::abs(p.unit_from_render[1]) + glm::abs(p.unit_from_render[2]));
    const ivec3 from = cell_at(p.center_m - reach), to = cell_at(p.center_m + reach);
    for (int z = from.z; z <= to.z; ++z)
      for (int y = from.y; y <= to.y; ++y)
        for (int x = from.x; x <= to.x; ++x) {
          const vec3 center_m = low_m_ + (vec3(x, y, z) + 0.5f) * cell_m_;
          const vec3 center = p.unit_from_render * (center_m - p.center_m);
          float bound;
          if ((p.flags & shared::kParticleHomogeneous) != 0u) {
            const vec3 nearest = glm::max(glm::abs(center) - half_extent, 0.0f);
            bound = glm::dot(nearest, nearest) < 1.0f ? 1.0f : 0.0f;
          } else if (p.structure_depth > 0.0f) {  // whatever the noise
            const vec3 nearest = glm::max(glm::abs(center) - half_extent, 0.0f);
            bound =
                shared::structured_density(glm::dot(nearest, nearest), 1.0f, shared::structure_skin(p.structure_depth));
          } else if (p.soft_detail >= 0.0f) {
            const vec3 nearest = glm::max(glm::abs(center) - half_extent, 0.0f);
            const float q = std::max(1.0f - glm::dot(nearest, nearest), 0.0f);
            bound = (q > kProfilePeak ? kMostProfile : shared::particle_profile(q, 0u)) *
                    shared::soft_variation(p.soft_detail, 1.0f);
          } else {
            bound = lattice_.bound(center, half_extent);
          }
          const vec3 farthest = glm::abs(center_m) + half_m;  // where the planet has curved away most
          bound *= shared::base_fade(
              shared::altitude_m({farthest.x, farthest.y, center_m.z + half_m}, camera_altitude_m_) - p.base_m);
          if (!(bound > 0.0f)) continue;
          const std::size_t cell = index({x, y, z});
          const vec3 nearest = glm::max(glm::abs(center_m) - half_m, 0.0f);
          if (shared::altitude_m({nearest.x, nearest.y, center_m.z - half_m}, camera_altitude_m_) <
              p.base_m + shared::kBaseFadeM)
            cut_[cell] = 1;
          bounds_per_m_[cell] += bound * p.extinction_per_m * (1 + 1e-5f);  // rounding
          block_filled_[block_index({x, y, z})] = 1;
          entries.push_back({static_cast<std::uint32_t>(cell), static_cast<std::uint32_t>(i)});
        }
  }
  first_.assign(bounds_per_m_.size() + 1, 0);
  for (const Entry& entry : entries) ++first_[entry.cell + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  list_.resize(entries.size());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (const Entry& entry : entries) list_[next[entry.cell]++] = entry.particle;
}

ivec3 ExtinctionField::cell_at(const vec3& p_m) const {
  return glm::clamp(ivec3((p_m - low_m_) / cell_m_), ivec3(0), size_ - 1);
}

std::size_t ExtinctionField::block_index(const ivec3& cell) const {
  const ivec3 block = cell / kBlockCells;
  return (static_cast<std::size_t>(block.z) * blocks_.y + block.y) * blocks_.x + block.x;
}

float ExtinctionField::particle_extinction(const Packed& particle, Place& place) const {
  const vec3 p = particle.unit_from_render * (place.p_m - particle.center_m);
  if (glm::dot(p, p) >= 1.0f) return 0.0f;
  const float faded = particle.extinction_per_m * shared::base_fade(place.altitude_m - particle.base_m);
  if ((particle.flags & shared::kParticleHomogeneous) != 0u) return faded;
  if (place.noise < 0.0f && (particle.structure_depth > 0.0f || particle.soft_detail > 0.0f)) {
    place.noise = structure_(place.p_m);
    place.broad = structure_.broad(place.p_m);
  }
  if (particle.soft_detail >= 0.0f)
    return faded * shared::particle_profile(1.0f - glm::dot(p, p), 0u) *
           shared::soft_variation(particle.soft_detail, place.noise);
  if (particle.structure_depth > 0.0f) {
    return faded * shared::structured_density(
                       glm::dot(p, p), shared::displaced_radius(particle.structure_depth, place.noise, place.broad),
                       shared::structure_skin(particle.structure_depth));
  }
  return faded * lattice_(p);
}

// Up to where the sum passes `enough`.
float ExtinctionField::extinction_in_cell(std::size_t cell, const vec3& p_m, float enough) const {
  Place place{p_m, cut_[cell] != 0 ? shared::altitude_m(p_m, camera_altitude_m_) : kFarAboveM, -1.0f};
  float sum = 0.0f;
  for (std::uint32_t i = first_[cell]; i < first_[cell + 1] && sum <= enough; ++i)
    sum += particle_extinction(particles_[list_[i]], place);
  return sum;
}

float ExtinctionField::extinction_per_m(const vec3& p_m) const {
  if (glm::any(glm::lessThan(p_m, low_m_)) || glm::any(glm::greaterThan(p_m, high_m_))) return 0.0f;
  return extinction_in_cell(index(cell_at(p_m)), p_m);
}

ExtinctionField::Emission ExtinctionField::emission(const vec3& p_m) const {
  const std::size_t cell = index(cell_at(p_m));
  Place place{p_m, shared::altitude_m(p_m, camera_altitude_m_), -1.0f};
  float all = 0.0f, emissive = 0.0f;
  Emission result;
  for (std::uint32_t i = first_[cell]; i < first_[cell + 1]; ++i) {
    const Packed& particle = particles_[list_[i]];
    const float extinction = particle_extinction(particle, place);
    all += extinction;
    if ((particle.flags & shared::kParticleEmissive) == 0u) continue;
    emissive += extinction;
    result.radiance_per_sr += extinction * emitted_[particle.source];
  }
  if (emissive <= 0.0f) return {};
  result.share = emissive / all;
  result.radiance_per_sr /= emissive;
  return result;
}

template <class Visit>
void ExtinctionField::walk(const vec3& origin_m, const vec3& direction, float end_m, Visit&& visit) const {
  const vec3 inverse = inverse_of(direction);
  const Span whole = box_span(low_m_, high_m_, origin_m, inverse);
  const float last_m = std::min(end_m, whole.far_m);
  const float grid_per_m = 1.0f / cell_m_;
  float at_m = std::max(0.0f, whole.near_m);
  while (at_m < last_m) {
    // Rays from the ground may come from 100 km away, where a sliver of a cell is less than a float resolves.
    const float sliver_m = kSliver * cell_m_ + kResolution * at_m;
    const vec3 p = origin_m + (at_m + sliver_m) * direction;
    const ivec3 cell = glm::clamp(ivec3((p - low_m_) * grid_per_m), ivec3(0), size_ - 1);
    const bool filled = block_filled_[block_index(cell)] != 0;
    const ivec3 corner = filled ? cell : cell / kBlockCells * kBlockCells;
    const vec3 low = low_m_ + vec3(corner) * cell_m_;
    const vec3 high = low + (filled ? cell_m_ : cell_m_ * kBlockCells);
    const float leave_m = std::max(box_span(low, high, origin_m, inverse).far_m, at_m + sliver_m);
    const std::size_t i = index(cell);
    if (filled && bounds_per_m_[i] > 0.0f && visit(i, at_m, std::min(leave_m, last_m))) return;
    at_m = leave_m;
  }
}

float ExtinctionField::collide(const vec3& origin_m, const vec3& direction, float end_m, Random& random) const {
  return track_collision(
      random, [&](auto&& visit) { walk(origin_m, direction, end_m, visit); },
      [&](std::size_t cell) { return bounds_per_m_[cell]; },
      [&](std::size_t cell, float at_m, float enough) {
        return extinction_in_cell(cell, origin_m + at_m * direction, enough);
      });
}

float ExtinctionField::transmittance(const vec3& origin_m, const vec3& direction, float end_m, Random& random) const {
  return track_transmittance(
      random, [&](auto&& visit) { walk(origin_m, direction, end_m, visit); },
      [&](std::size_t cell) { return bounds_per_m_[cell]; },
      [&](std::size_t cell, float at_m, float enough) {
        return extinction_in_cell(cell, origin_m + at_m * direction, enough);
      });
}

float ExtinctionField::first_matter_m(const vec3& origin_m, const vec3& direction, float end_m) const {
  float found_m = kNever;
  walk(origin_m, direction, end_m, [&](std::size_t cell, float near_m, float far_m) {
    for (float at_m = near_m; at_m < far_m; at_m += cell_m_ / kMatterSteps) {
      const vec3 p_m = origin_m + at_m * direction;
      Place place{p_m, shared::altitude_m(p_m, camera_altitude_m_), -1.0f};
      for (std::uint32_t i = first_[cell]; i < first_[cell + 1]; ++i) {
        const Packed& particle = particles_[list_[i]];
        if (particle_extinction(particle, place) < shared::kFirstMatterDensity * particle.extinction_per_m) continue;
        found_m = at_m;
        return true;
      }
    }
    return false;
  });
  return found_m;
}

// Mean extinction of every cell from a few points, then the depth along cell centres.
void ExtinctionField::guess_sun(const vec3& sun_direction) {
  const std::size_t cells = bounds_per_m_.size();
  std::vector<float> mean_per_m(cells, 0.0f);
  const auto for_filled = [&](auto&& visit) {
    parallel_for(particles_.empty() ? 0 : size_.z, [&](int z) {
      for (int y = 0; y < size_.y; ++y)
        for (int x = 0; x < size_.x; ++x)
          if (const std::size_t cell = index({x, y, z}); bounds_per_m_[cell] > 0.0f)
            visit(cell, low_m_ + (vec3(x, y, z) + 0.5f) * cell_m_);
    });
  };
  for_filled([&](std::size_t cell, const vec3& center_m) {
    for (const vec3& corner : {vec3(1, 1, 1), vec3(1, -1, -1), vec3(-1, 1, -1), vec3(-1, -1, 1)})
      mean_per_m[cell] += 0.25f * extinction_in_cell(cell, center_m + 0.25f * cell_m_ * corner);
  });
  sun_guess_.assign(cells, 1.0f);
  for_filled([&](std::size_t cell, const vec3& center_m) {
    float depth = 0.0f;
    walk(center_m, sun_direction, kNever, [&](std::size_t passed, float near_m, float far_m) {
      depth += mean_per_m[passed] * (far_m - near_m);
      return depth > 20.0f;
    });
    sun_guess_[cell] = std::exp(-kGuessShare * depth);
  });
}

float ExtinctionField::sun_guess(const vec3& p_m) const { return sun_guess_[index(cell_at(p_m))]; }

}  // namespace nephele::truth
