#include "tools/clouds/particle_chords.h"

#include <algorithm>
#include <cmath>

#include "shared/light.h"

namespace nephele::clouds {

ParticleChords::ParticleChords(const ParticleSet& set, bool cut)
    : cut_(cut), homogeneous_(set.shape == ParticleShape::homogeneous) {
  balls_.reserve(set.particles.size());
  for (const SetParticle& p : set.particles) {
    const glm::dvec3 d(p.diagonal_m), o(p.off_diagonal_m);
    const glm::dmat3 shape(d.x, o.x, o.y, o.x, d.y, o.z, o.y, o.z, d.z);
    // The Frobenius norm is no less than the longest radius.
    const double reach2 = d.x * d.x + d.y * d.y + d.z * d.z + 2.0 * (o.x * o.x + o.y * o.y + o.z * o.z);
    balls_.push_back({glm::inverse(shape), glm::dvec3(p.center_m), reach2, p.extinction_per_m, p.base_m});
  }
}

double ParticleChords::depth(const glm::dvec3& point_m, const glm::dvec3& direction) const {
  double sum = 0.0;
  const std::uint32_t flags = homogeneous_ ? shared::kParticleHomogeneous : 0u;
  for (const Ball& ball : balls_) {
    const glm::dvec3 to = ball.center_m - point_m;
    const double along = glm::dot(to, direction);
    if (glm::dot(to, to) - along * along >= ball.reach2_m2) continue;
    const glm::dvec3 o = ball.unit_from_world * (direction * along - to), d = ball.unit_from_world * direction;
    const double a = glm::dot(d, d), b = glm::dot(o, d), h2 = 1.0 - (glm::dot(o, o) - b * b / a);
    if (h2 <= 0.0) continue;
    const double reach = std::sqrt(h2), per_m = std::sqrt(a);
    double begin = -reach, end = reach;
    if (cut_) {  // z = middle_m + climb_m s, to be above the base
      const double middle_m = point_m.z + direction.z * (along - b / a), climb_m = direction.z / per_m;
      const double height_m = middle_m - static_cast<double>(ball.base_m);
      if (climb_m > 1e-9)
        begin = std::clamp(-height_m / climb_m, -reach, reach);
      else if (climb_m < -1e-9)
        end = std::clamp(-height_m / climb_m, -reach, reach);
      else if (height_m < 0.0)
        continue;
    }
    const auto to_here = [&](double s) {
      return static_cast<double>(shared::profile_integral(static_cast<float>(s), static_cast<float>(h2), flags));
    };
    sum += static_cast<double>(ball.extinction_per_m) / per_m * (to_here(end) - to_here(begin));
  }
  return sum;
}

}  // namespace nephele::clouds
