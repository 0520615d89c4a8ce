// A cloud as ellipsoids in its own frame: what generators and importers make and scenes place.
//
// On disk it is NAME.npy, float32, one row a particle, and NAME.json beside it, which says what the columns are. The
// first ten are the centre (x, y, z), the shape (xx, yy, zz, xy, xz, yz of the symmetric matrix whose eigenvalues are
// the radii and whose eigenvectors are their directions) and the extinction; further ones are somebody else's. x is
// east, y north and z up as long as nothing turns the set.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "engine/result.h"
#include "engine/scene.h"

namespace nephele {

struct SetParticle {
  glm::vec3 center_m{0.0f};
  glm::vec3 diagonal_m{100.0f};    // of the shape: xx, yy, zz
  glm::vec3 off_diagonal_m{0.0f};  // xy, xz, yz
  float extinction_per_m = 0.05f;  // peak
};

struct ParticleSet {
  std::vector<SetParticle> particles;  // 1 .. kMaxSetParticles
  float base_m = 0.0f;                 // height of the flat base that cuts the particles, in the set's frame
  float top_m = 0.0f;                  // height of the cloud's top
  std::string source = "unknown";      // what made it
  std::string parameters = "{}";       // of the source, a JSON object
};
inline constexpr std::size_t kMaxSetParticles = std::size_t{1} << 22;

// One line if a set breaks a rule: values that are not finite, shapes that are not positive definite, a negative
// extinction, a top below the base. Saving and loading hold to it.
Result<void> check_particle_set(const ParticleSet& set);

// json_path ends in .json; the array goes beside it, first. Both are written under temporary names and renamed.
Result<void> save_particle_set(const std::filesystem::path& json_path, const ParticleSet& set);

// A pair of files that is not whole and consistent is an error that names file and fault.
Result<ParticleSet> load_particle_set(const std::filesystem::path& json_path);

// The particles for a scene to place, each cut at the set's base and under its top. Axes must be upright: a particle
// whose xz or yz is not 0 is refused.
Result<std::vector<ListedParticle>> listed_particles(const ParticleSet& set);

}  // namespace nephele
