// Scattering directions, and free paths' building blocks. Own formulas: the truth shares none with the renderer.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "engine/scene.h"
#include "tools/path_tracer/random.h"

namespace nephele::truth {

// An orthonormal frame about w (Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017): x and y in
// the plane across, z along w.
inline glm::vec3 about(const glm::vec3& w, float x, float y, float z) {
  const float sign = std::copysign(1.0f, w.z), a = -1.0f / (sign + w.z), b = w.x * w.y * a;
  const glm::vec3 u(1.0f + sign * w.x * w.x * a, sign * b, -sign * w.x), v(b, sign + w.y * w.y * a, -w.y);
  return x * u + y * v + z * w;
}

// The phase function of a scene: per steradian, and sampled exactly.
class Phase {
 public:
  explicit Phase(const PhaseSettings& settings)
      : cornette_shanks_(settings.function == PhaseFunction::cornette_shanks), g_(static_cast<float>(settings.g)) {}

  float operator()(float mu) const {
    // 1 + g^2 - 2 g mu, written without cancellation near the peak
    const float a = std::abs(g_), d = (1 - a) * (1 - a) + 2 * a * std::max(0.0f, 1 - (g_ < 0 ? -mu : mu));
    const float peak = (1 - g_ * g_) * kInverseSphere / (d * std::sqrt(d));
    return cornette_shanks_ ? peak * 1.5f * (1 + mu * mu) / (2 + g_ * g_) : peak;
  }

  // Henyey and Greenstein's distribution inverted; Cornette and Shanks' is that times 1 + mu^2, by rejection.
  glm::vec3 scatter(const glm::vec3& direction, Random& random) const {
    float mu;
    do {
      const float u = 2 * random() - 1, q = (1 - g_ * g_) / (1 + g_ * u);
      mu = std::abs(g_) < 1e-3f ? u : std::clamp((1 + g_ * g_ - q * q) / (2 * g_), -1.0f, 1.0f);
    } while (cornette_shanks_ && random() >= 0.5f * (1 + mu * mu));
    const float sine = std::sqrt(std::max(0.0f, 1 - mu * mu)), angle = 2 * std::numbers::pi_v<float> * random();
    return glm::normalize(about(direction, sine * std::cos(angle), sine * std::sin(angle), mu));
  }

 private:
  static constexpr float kInverseSphere = 0.25f * std::numbers::inv_pi_v<float>;
  bool cornette_shanks_;
  float g_;
};

// Cosine-weighted about a normal.
inline glm::vec3 diffuse_direction(const glm::vec3& normal, Random& random) {
  const float r2 = random(), angle = 2 * std::numbers::pi_v<float> * random(), r = std::sqrt(r2);
  return glm::normalize(about(normal, r * std::cos(angle), r * std::sin(angle), std::sqrt(1 - r2)));
}

}  // namespace nephele::truth
