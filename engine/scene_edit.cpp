#include "engine/scene_edit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>

#include "engine/check.h"
#include "engine/scene_document.h"

namespace nephele {
namespace {

using nlohmann::json;

constexpr const char* kEditable[] = {"world_origin_m", "camera",      "sun",    "atmosphere",
                                     "ground",         "exposure_ev", "clouds", "phase"};
constexpr const char* kMapPrefix = "clouds.weather_map.";

// "clouds.weather_map.origin_m" as its three names.
std::vector<std::string> names_of(std::string_view key_path) {
  std::vector<std::string> names;
  for (;;) {
    const std::size_t dot = std::min(key_path.find('.'), key_path.size());
    names.emplace_back(key_path.substr(0, dot));
    if (dot == key_path.size()) return names;
    key_path.remove_prefix(dot + 1);
  }
}

Result<void> check_editable(const Scene& scene, const std::string& key_path, const std::string& name) {
  const std::vector<std::string> names = names_of(key_path);
  if (std::find(std::begin(kEditable), std::end(kEditable), names[0]) == std::end(kEditable)) {
    std::string accepted;
    for (const char* editable : kEditable) accepted += (accepted.empty() ? "" : ", ") + std::string(editable);
    return Error{concat(name, ": ", key_path, " can't be edited; accepted: keys of ", accepted)};
  }
  if (names[0] != "clouds") return {};
  if (!scene.clouds) return Error{concat(name, ": ", key_path, " can't be edited: the scene has no clouds")};
  if (key_path.starts_with(kMapPrefix) && !scene.clouds->weather_map)
    return Error{concat(name, ": ", key_path, " can't be edited: the clouds have no weather map")};
  return {};
}

json json_of(double number) {
  // As a person writes them: 7, which seeds need, and not 7.0. A zero keeps its sign.
  constexpr double kWhole = 9007199254740992.0;  // 2^53
  if (std::floor(number) != number || std::abs(number) > kWhole || (number == 0.0 && std::signbit(number)))
    return number;
  return number < 0.0 ? json(static_cast<std::int64_t>(number)) : json(static_cast<std::uint64_t>(number));
}
json json_of(bool value) { return value; }
json json_of(const std::string& text) { return text; }
json json_of(const std::vector<double>& numbers) {
  json array = json::array();
  for (const double number : numbers) array.push_back(json_of(number));
  return array;
}

// What an edit leaves alone, out of the scene while this lives.
class Untouched {
 public:
  explicit Untouched(Scene& scene) : scene_(scene) { exchange(); }
  ~Untouched() { exchange(); }
  Untouched(const Untouched&) = delete;
  Untouched& operator=(const Untouched&) = delete;

  const std::optional<WeatherMap>& map() const { return map_; }
  // Where the kept map lies from now on.
  void place_map(const WeatherMap& place) {
    map_->origin_m = place.origin_m;
    map_->extent_m = place.extent_m;
  }

 private:
  void exchange() {
    scene_.views.swap(views_);
    scene_.particles.swap(particles_);
    scene_.sources.swap(sources_);
    scene_.terrain.swap(terrain_);
    if (scene_.clouds) scene_.clouds->weather_map.swap(map_);
  }

  Scene& scene_;
  std::vector<SceneView> views_;
  std::vector<ListedParticle> particles_;
  std::vector<SceneSource> sources_;
  std::optional<Terrain> terrain_;
  std::optional<WeatherMap> map_;
};

}  // namespace

bool is_editable(std::string_view key_path) {
  if (key_path == std::string(kMapPrefix) + "file") return false;
  const std::vector<JsonKey> keys = scene_keys();
  const std::string top = names_of(key_path)[0];
  const bool part = std::find(std::begin(kEditable), std::end(kEditable), top) != std::end(kEditable);
  return part && std::any_of(keys.begin(), keys.end(),
                             [&](const JsonKey& key) { return key.path == key_path && key.kind != JsonKind::object; });
}

Result<void> set_value(Scene& scene, const std::string& key_path, const SceneValue& value, const std::string& name) {
  if (auto ok = check_editable(scene, key_path, name); !ok) return ok;
  if (key_path == std::string(kMapPrefix) + "file")
    return Error{concat(name, ": ", key_path, " can't be edited: the map is read with the scene")};
  Untouched untouched(scene);
  json document = json::object();
  if (key_path.starts_with(kMapPrefix)) {  // the reader takes a map as a whole
    const WeatherMap& map = *untouched.map();
    json& place = document["clouds"]["weather_map"];
    place["file"] = "kept";
    for (glm::length_t i = 0; i < 2; ++i) place["origin_m"].push_back(map.origin_m[i]);
    for (glm::length_t i = 0; i < 2; ++i) place["extent_m"].push_back(map.extent_m[i]);
  }
  json* at = &document;
  for (const std::string& key : names_of(key_path)) at = &(*at)[key];
  *at = std::visit([](const auto& held) { return json_of(held); }, value);

  Scene edited = scene;
  JsonReader reader(name);
  JsonObject root = reader.root(document);
  SceneFiles files;  // none is read
  read_scene(root, edited, files);
  root.finish();
  if (reader.error()) return *reader.error();
  if (edited.clouds && edited.clouds->weather_map) {
    untouched.place_map(*edited.clouds->weather_map);
    edited.clouds->weather_map.reset();
  }
  scene = std::move(edited);
  return {};
}

Result<Scene> with_value(const Scene& scene, const std::string& key_path, const SceneValue& value,
                         const std::string& name) {
  Scene edited = scene;
  if (auto ok = set_value(edited, key_path, value, name); !ok) return ok.error();
  return edited;
}

Result<SceneValue> value_of(const Scene& scene, const std::string& key_path, const std::string& name) {
  if (auto ok = check_editable(scene, key_path, name); !ok) return ok.error();
  const bool mapped = scene.clouds && scene.clouds->weather_map;
  const nlohmann::ordered_json document = settings_document(scene, mapped ? scene.clouds->weather_map->file : "");
  const nlohmann::ordered_json* at = &document;
  for (const std::string& key : names_of(key_path)) {
    if (!at->is_object() || !at->contains(key)) return Error{concat(name, ": ", key_path, " has no value in a scene")};
    at = &at->at(key);
  }
  if (at->is_boolean()) return SceneValue(at->get<bool>());
  if (at->is_number()) return SceneValue(at->get<double>());
  if (at->is_string()) return SceneValue(at->get<std::string>());
  if (at->is_array()) return SceneValue(at->get<std::vector<double>>());
  return Error{concat(name, ": ", key_path, " is an object, whose members have values of their own")};
}

}  // namespace nephele
