// Light at a place, as the light field gives it to hosts (Renderer::light_at).
#pragma once

#include <array>
#include <glm/glm.hpp>

namespace nephele {

struct LightAt {
  // Of the clouds alone, 0 to 1, towards the sun; where the sun is below the horizon it says nothing.
  float sun_transmittance = 1.0f;
  // Mean over the sphere of what comes from there, without the sun itself, times the real spherical harmonics up to
  // degree 2 in the order 1; x, y, z; xy, yz, 3z2 - 1, xz, x2 - y2, scaled so that the squares of a degree l sum to
  // 2 l + 1: radiance in the scene's unit of light, R G B. The first is the mean radiance.
  std::array<glm::vec3, 9> harmonics{};
};

// Irradiance on a surface of this unit normal, the sun's beam aside [Ramamoorthi and Hanrahan 2001].
glm::vec3 irradiance(const LightAt& light, const glm::vec3& normal);

}  // namespace nephele
