#include "tools/path_tracer/structure_noise.h"

#include <cmath>
#include <cstddef>

#include "engine/parallel.h"
#include "shared/structure.h"

namespace nephele::truth {

namespace {

constexpr int kTexels = static_cast<int>(shared::kStructureTexels);
static_assert((kTexels & (kTexels - 1)) == 0);  // wraps by masks

}  // namespace

StructureNoise::StructureNoise(const glm::vec3& camera_grid_m)
    : camera_grid_m_(camera_grid_m), tile_(std::size_t{kTexels} * kTexels * kTexels) {
  parallel_for(kTexels, [&](int z) {
    for (int y = 0; y < kTexels; ++y)
      for (int x = 0; x < kTexels; ++x) {
        const glm::vec3 p = (glm::vec3(x, y, z) + 0.5f) * (static_cast<float>(shared::kStructureCells) / kTexels);
        tile_[(static_cast<std::size_t>(z) * kTexels + y) * kTexels + x] =
            static_cast<std::uint8_t>(std::lround(255.0f * shared::structure_tile(p)));
      }
  });
}

float StructureNoise::tile(const glm::vec3& place) const {
  const glm::vec3 at = place * static_cast<float>(kTexels) - 0.5f, low = glm::floor(at), f = at - low;
  const auto wrapped = [](float v, int more) { return (static_cast<int>(v) + more) & (kTexels - 1); };
  const int x0 = wrapped(low.x, 0), x1 = wrapped(low.x, 1);
  const auto row = [&](int y, int z) {
    const std::uint8_t* r = &tile_[(static_cast<std::size_t>(z) * kTexels + y) * kTexels];
    return static_cast<float>(r[x0]) + f.x * static_cast<float>(r[x1] - r[x0]);
  };
  const int y0 = wrapped(low.y, 0), y1 = wrapped(low.y, 1), z0 = wrapped(low.z, 0), z1 = wrapped(low.z, 1);
  const float near = glm::mix(row(y0, z0), row(y1, z0), f.y), far = glm::mix(row(y0, z1), row(y1, z1), f.y);
  return glm::mix(near, far, f.z) * (1.0f / 255.0f);
}

float StructureNoise::operator()(const glm::vec3& p_m) const {
  const glm::vec3 air_m = shared::structure_air_m(p_m, camera_grid_m_);
  float sum = 0.0f;
  for (std::uint32_t octave = 0; octave < shared::kStructureOctaves; ++octave)
    sum += shared::structure_weight(octave) * (tile(shared::structure_place(octave, air_m)) - 0.5f);
  return shared::structure_noise(sum);
}

float StructureNoise::broad(const glm::vec3& p_m) const {
  return tile(shared::structure_place(shared::kStructureBroad, shared::structure_air_m(p_m, camera_grid_m_))) - 0.5f;
}

}  // namespace nephele::truth
