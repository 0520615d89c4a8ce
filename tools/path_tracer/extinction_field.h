// The clouds as a participating medium: the sum of all particles' extinction at a point, and free paths through it.
//
// A particle is constant inside its ellipsoid, or the reference particle's density in its own frame and orientation;
// what lies below its base is cut away and the 50 m above thinned, as the renderer draws it. Tracking runs on a uniform
// grid: every cell lists the particles that have matter in it and bounds the extinction there (Woodcock 1965;
// Amanatides and Woo 1987), so a tentative collision is nearly always a real one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "shared/types.h"
#include "tools/path_tracer/density_lattice.h"
#include "tools/path_tracer/medium.h"
#include "tools/path_tracer/random.h"
#include "tools/path_tracer/structure_noise.h"

namespace nephele::truth {

class ExtinctionField final : public Medium {
 public:
  // Particles in render space. camera_grid_m: where the camera is in the air (FrameConstants), z its altitude.
  // sun_direction: where sun_guess looks.
  ExtinctionField(std::span<const shared::Particle> particles, const glm::vec3& camera_grid_m,
                  const glm::vec3& sun_direction, const DensityLattice& lattice);

  float extinction_per_m(const glm::vec3& p_m) const override;
  Emission emission(const glm::vec3& p_m) const override;
  bool emits() const override { return emits_; }
  float collide(const glm::vec3& origin_m, const glm::vec3& direction, float end_m, Random& random) const override;
  float transmittance(const glm::vec3& origin_m, const glm::vec3& direction, float end_m,
                      Random& random) const override;
  // Matter is where some particle has the density that counts; to a 16th of a cell, which is about a hundredth of a
  // particle's radius.
  float first_matter_m(const glm::vec3& origin_m, const glm::vec3& direction, float end_m) const override;
  float sun_guess(const glm::vec3& p_m) const override;

 private:
  struct Packed {
    glm::mat3 unit_from_render;
    glm::vec3 center_m;
    float extinction_per_m;
    float base_m;
    std::uint32_t flags;
    std::uint32_t source;                // index among the particles given
    float structure_depth, soft_detail;  // as in DrawParticle
  };
  struct Walk;

  void make_grid();
  void fill_cells();
  void guess_sun(const glm::vec3& sun_direction);
  // A place, and what is asked for there by all particles.
  struct Place {
    glm::vec3 p_m;
    float altitude_m;
    float noise;  // below 0: not asked for yet, nor is the broad form
    float broad = 0.0f;
  };
  float particle_extinction(const Packed& particle, Place& place) const;
  float extinction_in_cell(std::size_t cell, const glm::vec3& p_m, float enough = kNever) const;
  glm::ivec3 cell_at(const glm::vec3& p_m) const;
  std::size_t index(const glm::ivec3& cell) const {
    return (static_cast<std::size_t>(cell.z) * size_.y + cell.y) * size_.x + cell.x;
  }
  std::size_t block_index(const glm::ivec3& cell) const;
  // Calls visit(cell, near_m, far_m) for every cell with matter along the ray, in order, until it returns true.
  template <class Visit>
  void walk(const glm::vec3& origin_m, const glm::vec3& direction, float end_m, Visit&& visit) const;

  const DensityLattice& lattice_;
  StructureNoise structure_;
  float camera_altitude_m_;
  bool emits_ = false;
  std::vector<Packed> particles_;
  std::vector<glm::vec3> emitted_;  // by source
  glm::vec3 low_m_{0.0f}, high_m_{0.0f};
  float cell_m_ = 1.0f;
  glm::ivec3 size_{1}, blocks_{1};
  std::vector<std::uint32_t> first_;        // of a cell in list_, one more than cells
  std::vector<std::uint32_t> list_;         // indices of particles_
  std::vector<float> bounds_per_m_;         // no less than the extinction anywhere in the cell
  std::vector<std::uint8_t> cut_;           // does the cell reach down to where some particle's base is cut or thinned
  std::vector<std::uint8_t> block_filled_;  // blocks of 8^3 cells: is there any matter
  std::vector<float> sun_guess_;
};

}  // namespace nephele::truth
