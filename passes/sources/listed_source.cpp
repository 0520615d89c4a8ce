#include "passes/sources/listed_source.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "nephele_shaders.h"
#include "shared/ellipsoid.h"

namespace nephele {
namespace {

constexpr std::uint32_t kLocalSize = 64;

// Turned clockwise seen from above, as yaw is.
glm::dvec3 turned(const glm::dvec3& v, double heading_rad) {
  const double s = std::sin(heading_rad), c = std::cos(heading_rad);
  return {c * v.x + s * v.y, c * v.y - s * v.x, v.z};
}

shared::EllipsoidShape turned(const shared::EllipsoidShape& own, const Placement& at) {
  if (at.heading_rad == 0.0 && at.scale == 1.0) return own;
  const double s = std::sin(at.heading_rad), c = std::cos(at.heading_rad);
  const glm::dmat3 turn(c, -s, 0, s, c, 0, 0, 0, 1);  // columns
  const glm::dmat3 shape = at.scale * turn * glm::dmat3(shared::shape_matrix(own)) * glm::transpose(turn);
  return {glm::vec3(glm::dvec3(shape[0][0], shape[1][1], shape[2][2])),
          glm::vec3(glm::dvec3(shape[1][0], shape[2][0], shape[2][1]))};
}

std::uint32_t shape_flags(ParticleShape shape) {
  switch (shape) {
    case ParticleShape::reference:
      return shared::kParticleDetail;
    case ParticleShape::homogeneous:
      return shared::kParticleHomogeneous;
    case ParticleShape::soft:
      return shared::kParticleSoft | shared::kMostSoftDetail << shared::kParticleSoftShift;
  }
  return 0;
}

// Half the extent upwards.
double upwards_m(const shared::EllipsoidShape& shape) {
  return glm::length(glm::dvec3(shared::shape_matrix(shape)[2]));
}

shared::PlacedParticle placed(const ListedParticle& p, const Placement& at, const glm::dvec2& world_origin_m,
                              std::uint32_t index) {
  const glm::dvec3 center_m = at.at_m + at.scale * turned(p.center_m, at.heading_rad) - glm::dvec3(world_origin_m, 0.0);
  const auto altitude_m = [&](double own_m) { return static_cast<float>(at.at_m.z + at.scale * own_m); };
  const float scale = static_cast<float>(at.scale);
  shared::PlacedParticle result{};
  result.place = shared::split_place(center_m);
  result.shape = turned(p.ellipsoid, at);
  result.extinction_per_m = p.extinction_per_m * p.density / scale;
  const glm::vec4 orientation = p.orientation.value_or(glm::vec4(0, 0, 0, 1));
  result.orientation = shared::pack_orientation(
      at.heading_rad == 0.0
          ? orientation
          : shared::quaternion_product(shared::yaw_rotation(static_cast<float>(at.heading_rad)), orientation));
  result.flags = shape_flags(p.shape) | (p.radiance ? shared::kParticleEmissive : 0u);
  result.base_m = p.base_m ? altitude_m(*p.base_m) : shared::kNoBaseM;
  result.top_m = altitude_m(p.top_m ? static_cast<double>(*p.top_m) : p.center_m.z + upwards_m(p.ellipsoid));
  result.radiance_per_sr = p.radiance.value_or(glm::vec3(0.0f));
  result.id = shared::hash_uint(index);
  return result;
}

// Weighted by the particles' volumes: what a cloud of them has where it is dense.
float mean_extinction_per_m(std::span<const ListedParticle> particles, double scale) {
  double sum = 0.0, volume = 0.0;
  for (const ListedParticle& p : particles) {
    const double own = static_cast<double>(shared::shape_determinant(p.ellipsoid));
    sum += own * static_cast<double>(p.extinction_per_m) * static_cast<double>(p.density);
    volume += own;
  }
  return volume > 0.0 ? static_cast<float>(sum / volume / scale) : 0.0f;
}

CloudExtent extent_of(std::span<const ListedParticle> particles, const Placement& at) {
  CloudExtent extent{INFINITY, -INFINITY};
  for (const ListedParticle& p : particles) {
    double lowest_m = p.center_m.z - upwards_m(p.ellipsoid);
    if (p.base_m) lowest_m = std::max(lowest_m, static_cast<double>(*p.base_m));
    extent.lowest_m = std::min(extent.lowest_m, static_cast<float>(at.at_m.z + at.scale * lowest_m));
    const double highest_m = p.center_m.z + upwards_m(p.ellipsoid);
    extent.highest_m = std::max(extent.highest_m, static_cast<float>(at.at_m.z + at.scale * highest_m));
  }
  return extent;
}

CloudBounds bounds_of(std::span<const ListedParticle> particles, const Placement& at, const glm::dvec2& world_origin_m,
                      const glm::dvec2& drift_m_per_s) {
  CloudBounds bounds{glm::dvec2(INFINITY), glm::dvec2(-INFINITY), drift_m_per_s};
  for (const ListedParticle& p : particles) {
    const glm::dvec2 center_m(at.at_m + at.scale * turned(p.center_m, at.heading_rad));
    const double across_m = at.scale * static_cast<double>(shared::longest_axis_at_most_m(p.ellipsoid));
    bounds.low_m = glm::min(bounds.low_m, center_m - world_origin_m - across_m);
    bounds.high_m = glm::max(bounds.high_m, center_m - world_origin_m + across_m);
  }
  return bounds;
}

const Buffer& upload(Workshop& make, std::string_view name, std::span<const ListedParticle> particles,
                     const Placement& at, const glm::dvec2& world_origin_m) {
  std::vector<shared::PlacedParticle> all;
  all.reserve(particles.size());
  for (const ListedParticle& particle : particles)
    all.push_back(placed(particle, at, world_origin_m, static_cast<std::uint32_t>(all.size())));
  if (all.empty()) all.emplace_back();  // never read
  return make.uploaded(std::string(name), std::as_bytes(std::span(all)));
}

}  // namespace

ListedSource::ListedSource(Workshop& make, std::string name, const ParticleGroup& group, const glm::dvec2& wind_m_per_s,
                           const glm::dvec2& world_origin_m, std::uint32_t most)
    : CloudSource(std::move(name), std::min(static_cast<std::uint32_t>(group.particles.size()), most)),
      claim_(make.compute(shaders::claim_slots_comp)),
      place_(make.compute(shaders::listed_particles_comp)),
      drift_m_per_s_(group.placement.drifts ? group.placement.wind_m_per_s.value_or(wind_m_per_s) : glm::dvec2(0.0)),
      demand_(static_cast<std::uint32_t>(group.particles.size())),
      extent_(extent_of(group.particles, group.placement)),
      bounds_(bounds_of(group.particles, group.placement, world_origin_m, drift_m_per_s_)),
      extinction_per_m_(mean_extinction_per_m(group.particles, group.placement.scale)),
      has_soft_particles_(std::any_of(group.particles.begin(), group.particles.end(),
                                      [](const ListedParticle& p) { return p.shape == ParticleShape::soft; })),
      placed_(upload(make, name_ + "_placed", std::span(group.particles).first(capacity_), group.placement,
                     world_origin_m)) {}

shared::SplitPlace ListedSource::camera(const FrameView& view) const {
  return shared::split_place(view.in_air(drift_m_per_s_));
}

InputBytes ListedSource::inputs(const FrameView& view) const { return as_inputs(camera(view), placed_.id()); }

void ListedSource::add(FrameBuilder& frame, const FrameView& view, const ParticleSink& sink) {
  struct Claim {
    std::uint32_t source, demand, capacity;
  };
  struct Place {
    shared::SplitPlace camera;
    std::uint32_t source;
  };
  frame.compute({.name = sink.row,
                 .kernel = &claim_,
                 .bindings = {{0, sink.counters, Access::storage_read_write}, {1, sink.records, Access::storage_write}},
                 .push = as_push(Claim{sink.source, demand_, capacity_})});
  frame.compute({.name = sink.row,
                 .kernel = &place_,
                 .bindings = {{0, placed_, Access::storage_read},
                              {1, sink.particles, Access::storage_write},
                              {2, sink.records, Access::storage_read}},
                 .push = as_push(Place{camera(view), sink.source}),
                 .groups = {(capacity_ + kLocalSize - 1) / kLocalSize, 1, 1}});
}

}  // namespace nephele
