#include "tools/path_tracer/density_lattice.h"

#include <algorithm>
#include <cmath>

#include "engine/parallel.h"
#include "shared/reference_particle.h"

namespace nephele::truth {

DensityLattice::DensityLattice(std::uint32_t seed)
    : values_(std::size_t{kVertices} * kVertices * kVertices), block_bounds_(std::size_t{kBlocks} * kBlocks * kBlocks) {
  const auto place = [](int i) { return 2.0f * static_cast<float>(i) / kCells - 1.0f; };
  parallel_for(kVertices, [&](int z) {
    std::uint16_t* out = &values_[static_cast<std::size_t>(z) * kVertices * kVertices];
    for (int y = 0; y < kVertices; ++y)
      for (int x = 0; x < kVertices; ++x)
        *out++ = static_cast<std::uint16_t>(
            std::lround(65535.0f * shared::reference_particle_density({place(x), place(y), place(z)}, seed)));
  });
  for (int z = 0; z < kCells; ++z)
    for (int y = 0; y < kCells; ++y)
      for (int x = 0; x < kCells; ++x) {
        const std::size_t block =
            (static_cast<std::size_t>(z / kBlockCells) * kBlocks + y / kBlockCells) * kBlocks + x / kBlockCells;
        for (int corner = 0; corner < 8; ++corner) {
          const int i = x + (corner & 1), j = y + ((corner >> 1) & 1), k = z + (corner >> 2);
          block_bounds_[block] =
              std::max(block_bounds_[block], values_[(static_cast<std::size_t>(k) * kVertices + j) * kVertices + i]);
        }
      }
}

float DensityLattice::bound(const glm::vec3& center, const glm::vec3& half_extent) const {
  const glm::vec3 nearest = glm::max(glm::abs(center) - half_extent, 0.0f);
  if (glm::dot(nearest, nearest) >= 1.0f) return 0.0f;
  const auto block = [](float x) {
    return std::clamp(static_cast<int>(std::floor((x + 1.0f) * (0.5f * kBlocks))), 0, kBlocks - 1);
  };
  const glm::vec3 low = center - half_extent, high = center + half_extent;
  std::uint16_t most = 0;
  for (int z = block(low.z); z <= block(high.z); ++z)
    for (int y = block(low.y); y <= block(high.y); ++y)
      for (int x = block(low.x); x <= block(high.x); ++x)
        most = std::max(most, block_bounds_[(static_cast<std::size_t>(z) * kBlocks + y) * kBlocks + x]);
  return static_cast<float>(most) * (1.0f / 65535.0f);
}

}  // namespace nephele::truth
