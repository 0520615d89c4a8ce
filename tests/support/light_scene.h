// Random particle scenes for the light passes, and the truth they are compared with: every particle against every
// ray, in doubles, by ray-ellipsoid intersection and quadrature.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "passes/light/light_tiles.h"
#include "passes/light/occlusion.h"
#include "shared/atmosphere_tables.h"
#include "shared/flat_base.h"
#include "shared/light.h"
#include "tests/support/shapes.h"
#include "tests/support/test_device.h"

namespace nephele::test {

using glm::dvec3;
using shared::FrameConstants;
using shared::FrameCounters;
using shared::Particle;

inline shared::FrameConstants light_constants(double azimuth_deg, double elevation_deg) {
  const double a = glm::radians(azimuth_deg), e = glm::radians(elevation_deg);
  FrameConstants constants;
  std::memset(&constants, 0, sizeof constants);
  const dvec3 sun(std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e));
  constants.sun_direction = glm::vec3(sun);
  constants.sun_irradiance = glm::vec3(1.0f, 0.9f, 0.8f);
  constants.light_from_render = shared::make_light_from_render(sun);
  constants.camera_grid_m = glm::vec3(100.0f, -200.0f, 1500.0f);
  constants.view_distance_m = 80000.0f;
  return constants;
}

// Anything within `range_m` of the camera: round or flat, turned, homogeneous or not, a third of them with a base.
inline Particle random_particle(std::mt19937& random, float range_m) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  Particle particle;
  std::memset(&particle, 0, sizeof particle);
  particle.center_m = range_m * glm::vec3(2 * unit(random) - 1, 2 * unit(random) - 1, 0.4f * unit(random) - 0.2f);
  const dvec3 radius_m(60 + 200 * unit(random), 60 + 200 * unit(random), 40 + 160 * unit(random));
  particle.shape = shape_along(random_axes(random), radius_m);
  particle.orientation = shared::pack_orientation(shared::random_rotation(unit(random), unit(random), unit(random)));
  particle.extinction_per_m = 0.002f + 0.04f * unit(random);
  particle.flags = random() % 2 ? shared::kParticleHomogeneous : 0u;
  const float altitude = shared::altitude_m(particle.center_m, 1500.0f);
  particle.base_m = random() % 3 ? shared::kNoBaseM : altitude + float(radius_m.z) * (1.6f * unit(random) - 0.8f);
  return particle;
}

struct Medium {
  double r2;      // squared radius in unit space
  double height;  // over the base plane, metres
};

inline double density_at(const Particle& particle, Medium at) {
  if (at.r2 >= 1.0 || at.height < 0.0) return 0.0;
  if (particle.flags & shared::kParticleHomogeneous) return particle.extinction_per_m;
  const double q = 1.0 - at.r2;
  return particle.extinction_per_m * q * q *
         (double(shared::kProfile2) + q * (double(shared::kProfile3) + q * double(shared::kProfile4)));
}

// A particle's unit space, in doubles and without the shared headers.
struct UnitSpace {
  UnitSpace(const Particle& particle, double camera_altitude_m)
      : center(particle.center_m), from_render(unit_matrix_of(particle.shape)) {
    const double r = 6360000.0;
    const double altitude = std::sqrt(center.x * center.x + center.y * center.y +
                                      (center.z + camera_altitude_m + r) * (center.z + camera_altitude_m + r)) -
                            r;
    base = double(particle.base_m) - altitude;  // over the centre
  }
  dvec3 direction(dvec3 v) const { return from_render * v; }
  dvec3 point(dvec3 p) const { return direction(p - center); }

  dvec3 center;
  glm::dmat3 from_render;
  double base;
};

inline double extinction_in(const Particle& particle, dvec3 point, double camera_altitude_m) {
  const UnitSpace space(particle, camera_altitude_m);
  const dvec3 q = space.point(point);
  return density_at(particle, {dot(q, q), point.z - space.center.z - space.base});
}

// Optical depth of one particle from a point towards the sun.
inline double depth_through(const Particle& particle, dvec3 point, dvec3 sun, double camera_altitude_m) {
  const UnitSpace space(particle, camera_altitude_m);
  const dvec3 q = space.point(point), d = space.direction(sun);
  const double a = dot(d, d), b = dot(q, d), discriminant = b * b - a * (dot(q, q) - 1.0);
  if (discriminant <= 0.0) return 0.0;
  double from = std::max(0.0, (-b - std::sqrt(discriminant)) / a), to = (-b + std::sqrt(discriminant)) / a;
  const double height = point.z - space.center.z - space.base;
  if (sun.z > 1e-9)
    from = std::max(from, -height / sun.z);
  else if (sun.z < -1e-9)
    to = std::min(to, -height / sun.z);
  else if (height < 0.0)
    return 0.0;
  if (from >= to) return 0.0;
  // The profile is a polynomial of degree 8 along the chord: five Gauss points are exact.
  const glm::dvec2 points[] = {{0.0, 0.5688888888888889},
                               {0.5384693101056831, 0.4786286704993665},
                               {-0.5384693101056831, 0.4786286704993665},
                               {0.9061798459386640, 0.2369268850561891},
                               {-0.9061798459386640, 0.2369268850561891}};
  double sum = 0.0;
  for (const glm::dvec2& point_weight : points) {
    const double t = 0.5 * (from + to) + 0.5 * (to - from) * point_weight.x;
    const dvec3 at = q + t * d;
    sum += 0.5 * point_weight.y * density_at(particle, {std::min(dot(at, at), 1.0 - 1e-12), 1.0});
  }
  return sum * (to - from);
}

inline constexpr std::uint32_t kNobody = 0xFFFFFFFFu;

// Through all particles but one, as the passes count it.
inline double true_depth(const std::vector<Particle>& particles, dvec3 point, dvec3 sun, std::uint32_t except) {
  double sum = 0.0;
  for (std::uint32_t i = 0; i < particles.size(); ++i)
    if (i != except) sum += depth_through(particles[i], point, sun, 1500.0);
  return std::min(sum, double(shared::kMaxSunOpticalDepth));
}

// Device buffers of a scene, sized to it with some room behind.
struct LightScene {
  LightScene(const FrameConstants& frame_constants, std::vector<Particle> all, std::vector<std::uint32_t> seen)
      : constants_value(frame_constants), particles_value(std::move(all)), visible_value(std::move(seen)) {
    Device& device = test_device();
    const std::size_t n = particles_value.size(), m = visible_value.size();
    constants = Buffer(device, "constants", sizeof constants_value);
    constants.write(std::as_bytes(std::span(&constants_value, 1)));
    particles = Buffer(device, "particles", (n + 1) * sizeof(Particle));
    std::vector<Particle> padded = particles_value;
    padded.resize(n + 1, random_garbage());
    particles.write_vector(padded);
    visible = Buffer(device, "visible", (m + 1) * sizeof(std::uint32_t));
    std::vector<std::uint32_t> slots = visible_value;
    slots.resize(m + 1, 0u);
    visible.write_vector(slots);
    counters = Buffer(device, "counters", sizeof(FrameCounters));
    FrameCounters counts{};
    counts.particle_count = counts.particle_demand = static_cast<std::uint32_t>(n);
    counts.visible_count = counts.visible_demand = static_cast<std::uint32_t>(m);
    counts.particle_groups = glm::uvec3((n + 63) / 64, 1, 1);
    counts.visible_groups = glm::uvec3((m + 63) / 64, 1, 1);
    counters.write(std::as_bytes(std::span(&counts, 1)));
  }

  static Particle random_garbage() {
    Particle particle;
    std::memset(&particle, 0x7F, sizeof particle);
    return particle;
  }
  FrameCounters read_counters() const {
    FrameCounters counts;
    counters.read(std::as_writable_bytes(std::span(&counts, 1)));
    return counts;
  }
  std::uint32_t particle_capacity() const { return static_cast<std::uint32_t>(particles_value.size() + 1); }
  std::uint32_t visible_capacity() const { return static_cast<std::uint32_t>(visible_value.size() + 1); }
  dvec3 sun() const { return normalize(dvec3(constants_value.sun_direction)); }

  FrameConstants constants_value;
  std::vector<Particle> particles_value;
  std::vector<std::uint32_t> visible_value;
  Buffer constants, particles, visible, counters;
};

inline std::vector<std::uint32_t> every(std::size_t n) {
  std::vector<std::uint32_t> all(n);
  for (std::size_t i = 0; i < n; ++i) all[i] = static_cast<std::uint32_t>(i);
  return all;
}

}  // namespace nephele::test
