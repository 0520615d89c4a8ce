// The truth that blending is measured against: the emission-absorption integral of overlapping constant segments along
// a ray, in doubles. Between consecutive events the extinction is the sum, the source the extinction-weighted mean.
#pragma once

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "shared/types.h"
#include "tests/support/shapes.h"

namespace nephele::test {

struct OracleSegment {
  double near_m, far_m, extinction_per_m;
  glm::dvec3 radiance;
};

struct OracleRay {
  glm::dvec4 color{0, 0, 0, 1};  // premultiplied radiance, transmittance
  double first_m = std::numeric_limits<double>::infinity();
};

inline OracleRay integrate(std::span<const OracleSegment> segments) {
  struct Event {
    double at_m;
    std::size_t segment;
    bool begins;
  };
  std::vector<Event> events;
  OracleRay ray;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const OracleSegment& s = segments[i];
    if (!(s.far_m > s.near_m) || !(s.extinction_per_m > 0)) continue;
    events.push_back({s.near_m, i, true});
    events.push_back({s.far_m, i, false});
    ray.first_m = std::min(ray.first_m, s.near_m);
  }
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.at_m < b.at_m; });
  std::vector<std::size_t> open;  // summed anew for every interval: sums kept up to date would cancel
  for (std::size_t e = 0; e + 1 < events.size(); ++e) {
    if (events[e].begins)
      open.push_back(events[e].segment);
    else
      std::erase(open, events[e].segment);
    const double length_m = events[e + 1].at_m - events[e].at_m;
    if (length_m <= 0) continue;
    double extinction = 0;
    glm::dvec3 emission(0);
    for (std::size_t i : open) {
      extinction += segments[i].extinction_per_m;
      emission += segments[i].radiance * segments[i].extinction_per_m;
    }
    if (extinction <= 0) continue;
    const double alpha = -std::expm1(-extinction * length_m);
    ray.color += glm::dvec4(ray.color.w * alpha / extinction * emission, 0);
    ray.color.w *= 1 - alpha;
  }
  return ray;
}

// The chords of homogeneous ellipsoids along a ray from the camera, the part in front of it.
inline std::vector<OracleSegment> chords(std::span<const shared::Particle> particles, glm::dvec3 direction) {
  std::vector<OracleSegment> found;
  for (const shared::Particle& p : particles) {
    const glm::dmat3 unit = unit_matrix_of(p.shape);
    const glm::dvec3 o = unit * -glm::dvec3(p.center_m), d = unit * direction;
    const double a = glm::dot(d, d), b = glm::dot(o, d), q = b * b - a * (glm::dot(o, o) - 1);
    if (q <= 0) continue;
    const double near_m = std::max(0.0, (-b - std::sqrt(q)) / a), far_m = (-b + std::sqrt(q)) / a;
    if (far_m > near_m) found.push_back({near_m, far_m, p.extinction_per_m, glm::dvec3(p.radiance_per_sr)});
  }
  return found;
}

}  // namespace nephele::test
