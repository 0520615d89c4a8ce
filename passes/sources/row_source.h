// A row of equal spheres towards the east: the worked example of a source in docs/extending.md.
#pragma once

#include "engine/scene.h"

namespace nephele {

// As a list of particles, which the listed source places.
inline ParticleGroup row_of_spheres(const RowSettings& row) {
  ParticleGroup group{.name = "row", .particles = {}, .placement = row.placement};
  for (std::uint32_t i = 0; i < row.count; ++i) {
    ListedParticle& sphere = group.particles.emplace_back();
    sphere.center_m = {i * row.spacing_m, 0.0, 0.0};
    sphere.radius_m = glm::vec3(0.4 * row.spacing_m);
  }
  return group;
}

}  // namespace nephele
