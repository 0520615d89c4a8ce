// The air's structure (shared/structure.h) on the CPU: the tile as the renderer keeps it, in bytes, between them
// trilinear.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace nephele::truth {

class StructureNoise {
 public:
  // camera_grid_m: where the camera is in the air (FrameConstants).
  explicit StructureNoise(const glm::vec3& camera_grid_m);

  // At a place of render space, all octaves, in [0, 1].
  float operator()(const glm::vec3& p_m) const;
  // The broad form there, less its mean.
  float broad(const glm::vec3& p_m) const;

 private:
  float tile(const glm::vec3& place) const;

  glm::vec3 camera_grid_m_;
  std::vector<std::uint8_t> tile_;
};

}  // namespace nephele::truth
