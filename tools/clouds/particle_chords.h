// Optical depths through a set of soft particles, along straight lines, in closed form.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "engine/particle_set.h"

namespace nephele::clouds {

class ParticleChords {
 public:
  // cut: each particle ends at its own base, as it is drawn.
  ParticleChords(const ParticleSet& set, bool cut);

  // Along the whole line through a point; direction of length 1.
  double depth(const glm::dvec3& point_m, const glm::dvec3& direction) const;

 private:
  struct Ball {  // a particle as a unit ball in a frame of its own
    glm::dmat3 unit_from_world;
    glm::dvec3 center_m;
    double reach2_m2;  // square of its longest radius
    float extinction_per_m, base_m;
  };
  std::vector<Ball> balls_;
  bool cut_, homogeneous_;
};

}  // namespace nephele::clouds
