// A cloud as ellipsoids in its own frame: what generators and importers make and scenes place.
//
// On disk it is NAME.npy, float32, one row a particle, and NAME.json beside it, which says what the columns are. The
// first ten are the centre (x, y, z), the shape (xx, yy, zz, xy, xz, yz of the symmetric matrix whose eigenvalues are
// the radii and whose eigenvectors are their directions) and the extinction. Further ones may be "base" and "top", the
// altitudes of the particle's own cloud where a set holds several, and "seed", which fixes the orientation of the noise
// inside the particle; others are somebody else's. x is east, y north and z up as long as nothing turns the set.
//
// A set may have coarser levels: the same cloud by fewer and larger particles, for far away. They are sets of their own
// beside it, whose names its JSON file lists.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "engine/result.h"
#include "engine/scene.h"
#include "shared/ellipsoid.h"

namespace nephele {

struct SetParticle {
  glm::vec3 center_m{0.0f};
  glm::vec3 diagonal_m{100.0f};    // of the shape: xx, yy, zz
  glm::vec3 off_diagonal_m{0.0f};  // xy, xz, yz
  float extinction_per_m = 0.05f;  // peak
  float base_m = 0.0f;             // height of the flat base that cuts the particle, in the set's frame
  float top_m = 0.0f;              // height of its cloud's top
  float seed = 0.0f;               // a whole number, 0 .. kMaxParticleSeed

  shared::EllipsoidShape ellipsoid() const { return {diagonal_m, off_diagonal_m}; }
  bool operator==(const SetParticle&) const = default;
};
inline constexpr float kMaxParticleSeed = 16777215.0f;

struct ParticleSet {
  std::vector<SetParticle> particles;              // 1 .. kMaxSetParticles
  float base_m = 0.0f;                             // lowest of the particles' bases
  float top_m = 0.0f;                              // highest of their tops
  ParticleShape shape = ParticleShape::reference;  // of all particles
  float detail = 1.0f;               // 0 .. 1: how strongly the air's structure works on them; without one: 0
  std::string source = "unknown";    // what made it
  std::string parameters = "{}";     // of the source, a JSON object
  std::vector<ParticleSet> coarser;  // finest first, at most kMaxCoarserLevels; they have none themselves

  bool operator==(const ParticleSet&) const = default;
};
inline constexpr std::size_t kMaxSetParticles = std::size_t{1} << 22;
inline constexpr std::size_t kMaxCoarserLevels = 6;

// Whether the shape is an ellipsoid's: all semi-axes above 0, by Sylvester's criterion in doubles.
bool is_positive_definite(const shared::EllipsoidShape& shape);

// Gives every particle the set's base and top, and a seed that is a hash of its place in the list.
void give_particles_base_and_top(ParticleSet& set);

// One line if a set breaks a rule: values that are not finite, shapes that are not positive definite, a negative
// extinction, a top below its base, a particle's base or top beyond the set's. Saving and loading hold to it.
Result<void> check_particle_set(const ParticleSet& set);

// json_path ends in .json; the array goes beside it, first, and before both the coarser levels as NAME_1.json,
// NAME_2.json, ... All are written under temporary names and renamed.
Result<void> save_particle_set(const std::filesystem::path& json_path, const ParticleSet& set);

// A pair of files that is not whole and consistent is an error that names file and fault.
Result<ParticleSet> load_particle_set(const std::filesystem::path& json_path);

}  // namespace nephele
