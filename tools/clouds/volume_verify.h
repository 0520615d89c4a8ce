// How far a particle set is from the volume that it was made of: along random rays, and in the outline from the side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/particle_set.h"
#include "tools/clouds/volume_reader.h"

namespace nephele::clouds {

// Optical depth of the volume along the whole line through a point, exactly: voxel by voxel.
double volume_depth(const MemoryVolume& volume, const glm::dvec3& point_m, const glm::dvec3& direction);

struct SetErrors {
  std::size_t rays = 0;
  double rms_transmittance = 0.0;  // over all rays
  double rms_log_depth = 0.0;      // over rays with a true depth of 1 to 50
  double outline_m = 0.0;   // mean distance between the outlines where half the light passes, seen from the south
  double mass_ratio = 0.0;  // of all particles over the volume's
};

// The rays and their true depths, to be used for several sets.
class VolumeTruth {
 public:
  static constexpr std::size_t kRays = 1500;
  static constexpr double kThinnest = 0.02, kThickest = 50.0;  // of the rays that count

  explicit VolumeTruth(const MemoryVolume& volume, std::uint32_t seed = 1);

  // cut: particles end at their base, as they are drawn.
  SetErrors errors_of(const ParticleSet& set, bool cut = true) const;

 private:
  struct Ray {
    glm::dvec3 point_m, direction;
    double depth;
  };
  std::vector<Ray> rays_;
  std::vector<Ray> outline_;  // a grid of rays along y, row by row
  std::size_t columns_ = 0, rows_ = 0;
  double pixel_x_m_ = 0.0, pixel_z_m_ = 0.0, mass_m2_ = 0.0;
};

}  // namespace nephele::clouds
