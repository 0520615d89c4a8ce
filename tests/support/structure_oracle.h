// The air's structure (shared/structure.h) in doubles: the tile's texels as bytes, between them trilinear, octave by
// octave.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "shared/structure.h"

namespace nephele::test {

class StructureOracle {
 public:
  StructureOracle() : texels_(std::size_t{kTexels} * kTexels * kTexels) {
    for (int z = 0; z < kTexels; ++z)
      for (int y = 0; y < kTexels; ++y)
        for (int x = 0; x < kTexels; ++x)
          texels_[index(x, y, z)] = std::round(255.0 * double(shared::structure_tile(cell_at({x, y, z})))) / 255.0;
  }

  // At a place of the air, all octaves.
  double operator()(const glm::dvec3& air_m) const {
    const double large_m = 94208.0 / 200.0, small_m = 94208.0 / 3201.0;
    const double sum =
        1.4 * (tile(air_m / large_m) - 0.5) + 0.15 * (tile(glm::dvec3(air_m.y, air_m.z, air_m.x) / small_m) - 0.5);
    return std::min(std::max(0.6 + sum, 0.0), 1.0);
  }

  // The broad form, less its mean.
  double broad(const glm::dvec3& air_m) const {
    return tile(glm::dvec3(air_m.z, air_m.x, air_m.y) / (94208.0 / 25.0)) - 0.5;
  }

 private:
  static constexpr int kTexels = 128;
  static glm::vec3 cell_at(const glm::ivec3& texel) { return (glm::vec3(texel) + 0.5f) * (4.0f / kTexels); }
  static std::size_t index(int x, int y, int z) {
    const auto wrap = [](int i) { return static_cast<std::size_t>(((i % kTexels) + kTexels) % kTexels); };
    return (wrap(z) * kTexels + wrap(y)) * kTexels + wrap(x);
  }
  double tile(const glm::dvec3& place) const {
    const glm::dvec3 at = place * double(kTexels) - 0.5;
    const glm::ivec3 low(glm::floor(at));
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::ivec3 c = low + glm::ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
      const glm::dvec3 w = 1.0 - glm::abs(at - glm::dvec3(c));
      sum += w.x * w.y * w.z * texels_[index(c.x, c.y, c.z)];
    }
    return sum;
  }

  std::vector<double> texels_;
};

inline const StructureOracle& structure_oracle() {
  static const StructureOracle oracle;
  return oracle;
}

}  // namespace nephele::test
