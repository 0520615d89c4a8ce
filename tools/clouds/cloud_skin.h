// Bodies of a grown cloud, and the skin that makes cauliflower of them: each body gets children where its surface is
// the cloud's own, these get children again, and so on. What other bodies hide gets none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <unordered_map>
#include <vector>

#include "engine/json_reader.h"
#include "engine/particle_set.h"
#include "engine/result.h"
#include "tools/clouds/repeatable.h"

namespace nephele::clouds {

// An upright ellipsoid.
struct CloudBody {
  glm::dvec3 center_m{0.0};
  glm::dvec3 radius_m{100.0};
  double extinction_per_m = 0.05;
};

inline constexpr std::size_t kMaxGrownBodies = 50000;

struct SkinParameters {
  std::uint32_t generations = 3;
  std::uint32_t children = 30;   // places tried on a body of the first generation; fewer on the later ones
  double smallest_share = 0.25;  // a child's radius as a share of its parent's
  double largest_share = 0.6;
  double place = 0.85;       // of a small child's centre: 1 is on its parent's surface; large ones sit deeper
  double lowest_up = -0.3;   // the upward component of the parent's normal there: -1 is below, 1 on top
  double smallest_m = 28.0;  // no child's radius is below it
  double extinction_per_m = 0.06;
};
void read_skin(JsonObject& json, SkinParameters& skin);

// Finds the bodies around a place without looking at all of them.
class BodyIndex {
 public:
  explicit BodyIndex(double cell_m) : cell_m_(cell_m) {}

  // The index keeps a copy. number: how the caller knows the body.
  void add(const CloudBody& body, std::size_t number);
  // The least distance to a body's centre with its radii as the unit, without that of the number left out; at most 2,
  // which stands for more as well.
  double nearest(const glm::dvec3& place_m, std::size_t left_out = kNone) const;
  static constexpr std::size_t kNone = ~std::size_t{0};

 private:
  struct Entry {
    CloudBody body;
    std::size_t number;
  };
  static std::uint64_t key(const glm::ivec3& cell);
  glm::ivec3 cell_of(const glm::dvec3& place_m) const;

  double cell_m_;
  std::vector<Entry> entries_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;  // entries that reach into the cell
};

// Adds the children to the bodies, behind them. Not below z = floor_m: no centre is lower. Ends early at
// kMaxGrownBodies.
void grow_skin(std::vector<CloudBody>& bodies, const SkinParameters& skin, double floor_m, RandomSequence& random);

// Leaves the largest group of bodies that overlap, and drops scraps that float beside it.
void keep_connected(std::vector<CloudBody>& bodies);

// A set of the bodies with a seed for each. flat_base: cut at z = 0, and bodies that have nothing above it are left
// out; otherwise it is moved so that it rests there.
Result<ParticleSet> set_of_bodies(std::vector<CloudBody> bodies, bool flat_base);

// What a reading function has read, as a JSON object with every key.
template <class Read>
std::string parameters_text(Read&& read) {
  nlohmann::ordered_json text = nlohmann::ordered_json::object();
  for (const JsonKey& key : JsonReader::keys_of(read)) {
    if (key.path.find('[') != std::string::npos || key.default_json.is_null()) continue;
    nlohmann::ordered_json* place = &text;
    std::size_t start = 0;
    for (std::size_t dot; (dot = key.path.find('.', start)) != std::string::npos; start = dot + 1)
      place = &(*place)[key.path.substr(start, dot - start)];
    (*place)[key.path.substr(start)] = key.default_json;
  }
  return text.dump();
}

}  // namespace nephele::clouds
