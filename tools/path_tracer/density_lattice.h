// The noisy reference particle on a lattice fine enough to stand for the function itself (density_lattice_test says how
// well), with bounds for tracking. Space: the particle's own, the unit sphere.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace nephele::truth {

class DensityLattice {
 public:
  // The seed of reference_particle.h.
  explicit DensityLattice(std::uint32_t seed);

  // Relative extinction in [0, 1], between vertices trilinear; |p| < 1.
  float operator()(const glm::vec3& p) const {
    const glm::vec3 at = (p + 1.0f) * (0.5f * kCells);
    const auto cell = [](float x) { return std::min(static_cast<int>(x), kCells - 1); };
    const int x = cell(at.x), y = cell(at.y), z = cell(at.z);
    const float fx = at.x - static_cast<float>(x), fy = at.y - static_cast<float>(y), fz = at.z - static_cast<float>(z);
    const std::uint16_t* d = &values_[(static_cast<std::size_t>(z) * kVertices + y) * kVertices + x];
    const auto row = [fx](const std::uint16_t* r) {
      const float low = r[0], high = r[1];
      return low + fx * (high - low);
    };
    const auto plane = [&](const std::uint16_t* s) {
      const float low = row(s), high = row(s + kVertices);
      return low + fy * (high - low);
    };
    const float low = plane(d), high = plane(d + kVertices * kVertices);
    return (low + fz * (high - low)) * (1.0f / 65535.0f);
  }

  // No less than the density anywhere in the box; 0 where the box misses the unit sphere.
  float bound(const glm::vec3& center, const glm::vec3& half_extent) const;

 private:
  static constexpr int kCells = 96, kVertices = kCells + 1;
  static constexpr int kBlockCells = 4, kBlocks = kCells / kBlockCells;
  std::vector<std::uint16_t> values_;
  std::vector<std::uint16_t> block_bounds_;
};

}  // namespace nephele::truth
