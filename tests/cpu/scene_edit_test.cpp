// One value of a scene changed: as a file with that value would have it, and nothing else.
#include "engine/scene_edit.h"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/support/scene_documents.h"

using namespace nephele;
using nephele::test::TempDirectory;
using nlohmann::json;

namespace {

// A scene with everything that an edit leaves alone.
json base_document() {
  return json::parse(R"({
    "camera": {"position_m": [1, 2, 3], "look_at_m": [10, 20, 7]},
    "clouds": {"seed": 4, "coverage": 0.3,
               "weather_map": {"file": "map.png", "origin_m": [-5, 6.5], "extent_m": [1000, 3000]}},
    "views": [{"name": "one", "camera": {"yaw_deg": 12}}],
    "particles": [{"center_m": [1, 2, 3]}, {"density": 0.25}],
    "sources": [{"kind": "set", "file": "cloud.json"}, {"kind": "field", "seed": 9}]
  })");
}

Scene parse(const json& document, const std::string& directory) {
  const Result<Scene> scene = parse_scene(document.dump(), "scene", directory);
  if (!scene) FAIL(scene.error().message);
  return *scene;
}

SceneValue value_from(const json& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number()) return value.get<double>();
  if (value.is_string()) return value.get<std::string>();
  return value.get<std::vector<double>>();
}

std::string complaint(const Scene& scene, const std::string& key, const SceneValue& value) {
  const Result<Scene> edited = with_value(scene, key, value, "panel");
  return edited ? "accepted" : edited.error().message;
}

}  // namespace

TEST_CASE("scene edit: each key that may be edited, set as a file with that value has it, and set back") {
  const TempDirectory directory;
  test::write_scene_files(directory);
  const Scene scene = parse(base_document(), directory.path().string());
  std::size_t edited_keys = 0;
  for (const JsonKey& key : scene_keys()) {
    CAPTURE(key.path);
    if (!is_editable(key.path)) continue;
    json document = base_document();
    const json value = test::value_within(key, 0.4);
    test::place_at(document, key.path) = value;
    if (key.path.ends_with("look_at_m")) continue;  // below
    if (key.path.starts_with("camera.yaw") || key.path.starts_with("camera.pitch"))
      document["camera"].erase("look_at_m");
    if (key.path == "camera.position_m") document["camera"].erase("look_at_m");
    ++edited_keys;
    const Result<Scene> edited = with_value(scene, key.path, value_from(value));
    REQUIRE_MESSAGE(edited, edited.error().message);
    Scene expected = parse(document, directory.path().string());
    // Where the file's camera does not look at the place any more, the edit keeps the other angles.
    if (key.path == "camera.position_m" || key.path == "camera.yaw_deg")
      expected.camera.pitch_rad = scene.camera.pitch_rad;
    if (key.path == "camera.position_m" || key.path == "camera.pitch_deg")
      expected.camera.yaw_rad = scene.camera.yaw_rad;
    CHECK(*edited == expected);
    CHECK_FALSE(*edited == scene);
    // The value reads back, and the one from before restores the scene.
    const Result<SceneValue> now = value_of(*edited, key.path), before = value_of(scene, key.path);
    REQUIRE(now);
    REQUIRE(before);
    CHECK(*with_value(scene, key.path, *now) == *edited);
    CHECK(*with_value(*edited, key.path, *before) == scene);
  }
  CHECK(edited_keys > 20);
}

TEST_CASE("scene edit: the camera turns towards a place from where it is") {
  const Scene scene = parse(json::parse(R"({"camera": {"position_m": [100, 200, 300]}})"), ".");
  const Result<Scene> turned = with_value(scene, "camera.look_at_m", std::vector<double>{400, 200, 600});
  REQUIRE(turned);
  CHECK(std::abs(turned->camera.yaw_rad - 90 * kRadiansPerDegree) < 1e-15);
  CHECK(std::abs(turned->camera.pitch_rad - 45 * kRadiansPerDegree) < 1e-15);
  const Result<SceneValue> place = value_of(*turned, "camera.look_at_m");
  REQUIRE_FALSE(place);
  CHECK(place.error().message == "scene: camera.look_at_m has no value in a scene");
}

TEST_CASE("scene edit: values that are refused give the reader's own line and change nothing") {
  const TempDirectory directory;
  test::write_scene_files(directory);
  Scene scene = parse(base_document(), directory.path().string());
  const Scene before = scene;
  struct Bad {
    const char* key;
    SceneValue value;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [key, value] :
       {Bad{"camera.pitch_deg", 90.5}, Bad{"camera.pitch_deg", -91.0}, Bad{"camera.pitch_deg", std::string("up")},
        Bad{"camera.position_m", std::vector<double>{0, 0}}, Bad{"camera.position_m", std::vector<double>{0, 0, -1}},
        Bad{"camera.yow_deg", 1.0}, Bad{"sun.irradiance", std::vector<double>{1, -1, 1}},
        Bad{"atmosphere.enabled", 1.0}, Bad{"ground.albedo", 0.5}, Bad{"exposure_ev", 33.0}, Bad{"clouds.seed", 1.5},
        Bad{"clouds.seed", -1.0}, Bad{"clouds.seed", 4294967296.0}, Bad{"clouds.coverage", 7.0},
        Bad{"clouds.coverge", 0.5}, Bad{"phase.function", std::string("mie")}, Bad{"phase.g", 1.0}, Bad{"sun", 3.0}}) {
    CAPTURE(key);
    // The same line as from a file with this key alone.
    json document = json::object();
    json& place = test::place_at(document, key);
    std::visit([&](const auto& held) { place = held; }, value);
    if (const auto* number = std::get_if<double>(&value); number && std::floor(*number) == *number)
      place = static_cast<std::int64_t>(*number);
    const std::string text = document.dump();
    const Result<Scene> read = parse_scene(text, "panel");
    REQUIRE_FALSE(read);
    const Result<void> set = set_value(scene, key, value, "panel");
    REQUIRE_FALSE(set);
    // Numbers in arrays are whole in the line of an edit, as a person types them.
    if (!std::holds_alternative<std::vector<double>>(value)) CHECK(set.error().message == read.error().message);
    CHECK(scene == before);
  }
  CHECK(complaint(scene, "camera.position_m", std::vector<double>{0, 0, -1}) ==
        "panel: camera.position_m[2] is -1; accepted: a number from 0 to 1000000");
  CHECK(complaint(scene, "camera.yaw_deg", nan).starts_with("panel: camera.yaw_deg is "));
  CHECK(complaint(scene, "clouds.weather_map.origin_m", std::vector<double>{0, 1e10}) ==
        "panel: clouds.weather_map.origin_m[1] is 10000000000; accepted: a number from -1e+09 to 1e+09");
  CHECK(complaint(scene, "clouds.weather_map.size", 1.0) ==
        "panel: unknown key clouds.weather_map.size; accepted: file, origin_m, extent_m");
}

TEST_CASE("scene edit: what no edit reaches says so") {
  Scene scene;
  CHECK(complaint(scene, "particles", 1.0) ==
        "panel: particles can't be edited; accepted: keys of world_origin_m, camera, sun, atmosphere, ground, "
        "exposure_ev, clouds, phase");
  for (const char* key : {"sources[0].seed", "views[0].name", "", ".", "camera[].yaw_deg"})
    CHECK(complaint(scene, key, 1.0).find("can't be edited; accepted: ") != std::string::npos);
  CHECK(complaint(scene, "clouds.weather_map.origin_m", std::vector<double>{0, 0}) ==
        "panel: clouds.weather_map.origin_m can't be edited: the clouds have no weather map");
  scene.clouds->weather_map = WeatherMap{.width = 1, .height = 1, .texels = {{1, 2}}, .extent_m = {1, 1}};
  CHECK(complaint(scene, "clouds.weather_map.file", std::string("b.png")) ==
        "panel: clouds.weather_map.file can't be edited: the map is read with the scene");
  // A map that a program made can be moved too.
  const Result<Scene> moved = with_value(scene, "clouds.weather_map.extent_m", std::vector<double>{5, 6});
  REQUIRE(moved);
  CHECK(moved->clouds->weather_map->extent_m == glm::dvec2(5, 6));
  CHECK(moved->clouds->weather_map->texels == scene.clouds->weather_map->texels);
  scene.clouds.reset();
  CHECK(complaint(scene, "clouds.seed", 1.0) == "panel: clouds.seed can't be edited: the scene has no clouds");
  CHECK_FALSE(value_of(scene, "clouds.seed"));
  CHECK_FALSE(value_of(scene, "camera"));
  CHECK_FALSE(value_of(scene, "camera.yow"));
  CHECK_FALSE(value_of(scene, "particles"));
  CHECK_FALSE(is_editable("camera"));
  CHECK_FALSE(is_editable("clouds.weather_map.file"));
  CHECK_FALSE(is_editable("views[].camera.yaw_deg"));
  CHECK_FALSE(is_editable("sources[field].seed"));
  CHECK(is_editable("exposure_ev"));
  CHECK(is_editable("clouds.weather_map.origin_m"));
}

TEST_CASE("scene edit: lists and texels stay where they are, and files are not read again") {
  Scene scene;
  {
    const TempDirectory directory;
    test::write_scene_files(directory);
    scene = parse(base_document(), directory.path().string());
  }  // the files are gone
  const auto* particles = scene.particles.data();
  const auto* sources = scene.sources.data();
  const auto* texels = scene.clouds->weather_map->texels.data();
  REQUIRE(set_value(scene, "camera.yaw_deg", 30.0));
  REQUIRE(set_value(scene, "clouds.coverage", 0.5));
  REQUIRE(set_value(scene, "clouds.weather_map.origin_m", std::vector<double>{1, 2}));
  CHECK_FALSE(set_value(scene, "clouds.coverage", 5.0));
  CHECK(scene.particles.data() == particles);
  CHECK(scene.sources.data() == sources);
  CHECK(scene.clouds->weather_map->texels.data() == texels);
  CHECK(scene.clouds->weather_map->width == 2);
  CHECK(scene.views.size() == 1);
}

TEST_CASE("scene edit: an angle that no degrees give stays when another value is edited") {
  Scene scene;
  const auto kept = [&] {
    return std::get<double>(*value_of(scene, "camera.pitch_deg")) * kRadiansPerDegree == scene.camera.pitch_rad;
  };
  scene.camera.pitch_rad = 0.7;  // one in ten is such an angle here; the writer's tests count them
  for (int i = 0; i < 100 && kept(); ++i) scene.camera.pitch_rad = std::nextafter(scene.camera.pitch_rad, 2.0);
  REQUIRE_FALSE(kept());
  const double pitch_rad = scene.camera.pitch_rad;
  REQUIRE(set_value(scene, "camera.yaw_deg", 30.0));
  CHECK(scene.camera.pitch_rad == pitch_rad);
}
