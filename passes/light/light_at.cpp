#include "passes/light/light_at.h"

#include <cstddef>
#include <numbers>

#include "shared/light_lattice.h"

namespace nephele {

static_assert(sizeof(LightAt) == 28 * sizeof(float));  // as in shaders/light/light_query.comp

glm::vec3 irradiance(const LightAt& light, const glm::vec3& normal) {
  constexpr float kPi = std::numbers::pi_v<float>;
  constexpr float kOfDegree[] = {kPi, 2.0f * kPi / 3.0f, kPi / 4.0f};  // a cosine lobe's share of each
  const shared::LightHarmonics h = shared::light_harmonics(normal);
  glm::vec3 sum(0.0f);
  for (std::size_t k = 0; k < light.harmonics.size(); ++k)
    sum += kOfDegree[k == 0 ? 0 : (k < 4 ? 1 : 2)] * h.y[k] * light.harmonics[k];
  return glm::max(sum, glm::vec3(0.0f));
}

}  // namespace nephele
