// Documents of scenes made from the reader's own list of keys, so that a test reaches every key, also those to come.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine/image_io.h"
#include "engine/json_reader.h"
#include "engine/particle_set.h"
#include "engine/scene.h"
#include "tests/support/support.h"

namespace nephele::test {

// The files that the documents name.
inline void write_scene_files(const TempDirectory& directory) {
  ParticleSet set;
  set.base_m = 10.0f;
  set.top_m = 90.0f;
  set.particles.push_back({.center_m = {1, 2, 3}, .diagonal_m = {30, 20, 10}});
  set.particles.push_back({.center_m = {4, 5, 6}, .diagonal_m = {3, 2, 1}, .off_diagonal_m = {0.5f, 0, 0}});
  give_particles_base_and_top(set);
  REQUIRE(save_particle_set(directory / "cloud.json", set));
  REQUIRE(write_png(directory / "map.png", 2, 1, std::vector<std::uint8_t>{128, 255, 0, 255, 7, 9, 0, 255}));
  write_file(directory / "heights.png", grey_png(2, 2, 16, {0, 1000, 2000, 65535}));
}

// A value that the key accepts and that is not its default: `share` of the way through its range.
inline nlohmann::json value_within(const JsonKey& key, double share) {
  const auto between = [&](const Range& range) { return range.minimum + share * (range.maximum - range.minimum); };
  if (key.path.ends_with("orientation")) {  // a turn about the vertical
    const double half_turn = share * 3.0;
    return {0.0, 0.0, std::sin(half_turn), std::cos(half_turn)};
  }
  if (key.path.ends_with("ellipsoid_m")) return {50.0 + 50.0 * share, 60.0, 70.0, 5.0, -4.0, 3.0};
  if (key.path == "terrain.lowest_m") share *= 0.5;  // below the highest
  if (key.path == "terrain.highest_m") share = 0.5 + 0.5 * share;
  switch (key.kind) {
    case JsonKind::number:
      return between(key.ranges[0]);
    case JsonKind::whole_number:
      return static_cast<std::uint32_t>(between(key.ranges[0]));
    case JsonKind::vector: {
      nlohmann::json numbers = nlohmann::json::array();
      for (const Range& range : key.ranges) numbers.push_back(between(range));
      return numbers;
    }
    case JsonKind::boolean:
      return !key.default_json.get<bool>();
    case JsonKind::choice:
      return key.default_json == key.choices.front() ? key.choices.back() : key.choices.front();
    case JsonKind::text:
      return "text of " + std::to_string(share);
    case JsonKind::file:
      return key.path.ends_with("weather_map.file") ? "map.png"
             : key.path == "terrain.file"           ? "heights.png"
                                                    : "cloud.json";
    case JsonKind::object:
      return nlohmann::json::object();
    case JsonKind::objects:
      if (key.path == "sources[scatter].sets") return {{{"file", "cloud.json"}}};  // none are refused
      return nlohmann::json::array();
  }
  return nullptr;
}

// "sources[set].at_m" as {"sources", "[set]"} and "at_m".
struct KeyStep {
  std::string name;
  bool in_array = false;
  std::string kind;  // of the array's object, where it has one
};

inline std::vector<KeyStep> steps_of(const std::string& path) {
  std::vector<KeyStep> steps;
  for (std::size_t at = 0; at <= path.size();) {
    const std::size_t end = std::min(path.find('.', at), path.size());
    KeyStep step{.name = path.substr(at, end - at)};
    if (const std::size_t bracket = step.name.find('['); bracket != std::string::npos) {
      step.in_array = true;
      step.kind = step.name.substr(bracket + 1, step.name.size() - bracket - 2);
      step.name.resize(bracket);
    }
    steps.push_back(std::move(step));
    at = end + 1;
  }
  return steps;
}

// The value at the key's path, made with all that leads there; an array gets one object of each kind.
inline nlohmann::json& place_at(nlohmann::json& document, const std::string& path) {
  nlohmann::json* at = &document;
  const std::vector<KeyStep> steps = steps_of(path);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    at = &(*at)[steps[i].name];
    if (!steps[i].in_array) continue;
    if (at->is_null()) *at = nlohmann::json::array();
    const auto has_kind = [&](const nlohmann::json& object) {
      return steps[i].kind.empty() || object.at("kind") == steps[i].kind;
    };
    const auto found = std::find_if(at->begin(), at->end(), has_kind);
    if (found != at->end()) {
      at = &*found;
      continue;
    }
    at->push_back(nlohmann::json::object());
    at = &at->back();
    if (!steps[i].kind.empty()) (*at)["kind"] = steps[i].kind;
  }
  return *at;
}

// The value at the key's path, null where nothing is: in whichever of an array's objects has it.
inline nlohmann::json found_at(const nlohmann::json& document, const std::string& path) {
  const nlohmann::json* at = &document;
  for (const KeyStep& step : steps_of(path)) {
    if (!at->is_object() || !at->contains(step.name)) return nullptr;
    at = &at->at(step.name);
    if (!step.in_array) continue;
    const auto fits = [&](const nlohmann::json& object) { return step.kind.empty() || object["kind"] == step.kind; };
    const auto found = std::find_if(at->begin(), at->end(), fits);
    if (found == at->end()) return nullptr;
    at = &*found;
  }
  return *at;
}

inline bool is_object_key(const JsonKey& key) {
  return key.kind == JsonKind::object || key.kind == JsonKind::objects || key.path.ends_with("].kind");
}

// What must stand beside the key for a file to be accepted.
inline void add_required(nlohmann::json& document, const std::string& path, const std::vector<JsonKey>& keys) {
  for (std::size_t end = path.rfind('.'); end != std::string::npos && end > 0; end = path.rfind('.', end - 1)) {
    const std::string parent = path.substr(0, end + 1);
    for (const JsonKey& other : keys) {
      const bool sibling = other.path.starts_with(parent) && other.path.find('.', parent.size()) == std::string::npos;
      if (!sibling || !other.required || other.path.ends_with("].kind")) continue;
      nlohmann::json& place = place_at(document, other.path);
      if (place.is_null()) place = value_within(other, 0.25);
    }
  }
}

// A scene with every key, each at a random value.
inline nlohmann::json random_document(std::mt19937& random) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  nlohmann::json document = nlohmann::json::object();
  const std::vector<JsonKey> keys = scene_keys();
  for (const JsonKey& key : keys) {
    if (is_object_key(key) || key.path.ends_with("look_at_m") || key.path.ends_with("ellipsoid_m")) continue;
    place_at(document, key.path) = value_within(key, share(random));
  }
  // Bases are under tops.
  const std::function<void(nlohmann::json&)> order = [&](nlohmann::json& list) {
    for (nlohmann::json& particle : list)
      if (particle["top_m"] < particle["base_m"]) std::swap(particle["top_m"], particle["base_m"]);
  };
  order(document["particles"]);
  for (nlohmann::json& source : document["sources"])
    if (source["kind"] == "particles") order(source["particles"]);
  for (nlohmann::json& source : document["sources"]) {
    if (source["kind"] != "scatter") continue;
    if (source["scale"][1] < source["scale"][0]) std::swap(source["scale"][0], source["scale"][1]);
    source["clouds_per_km2"] = 0.01;  // so that the view's places are not too many
  }
  return document;
}

}  // namespace nephele::test
