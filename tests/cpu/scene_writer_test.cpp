// Scenes written and read again.
#include "engine/scene_writer.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "engine/accepted.h"
#include "engine/scene_document.h"
#include "shared/ellipsoid.h"
#include "tests/support/scene_documents.h"

using namespace nephele;
using nephele::test::TempDirectory;
using nlohmann::json;

namespace {

Scene parse(const std::string& text, const std::string& directory = ".") {
  const Result<Scene> scene = parse_scene(text, "scene.json", directory);
  if (!scene) FAIL(scene.error().message);
  return *scene;
}

std::string written(const Scene& scene, const std::string& directory = "") {
  const Result<std::string> text = scene_text(scene, directory);
  if (!text) FAIL(text.error().message);
  return *text;
}

std::string complaint(const Scene& scene) {
  const Result<std::string> text = scene_text(scene);
  return text ? "written" : text.error().message;
}

}  // namespace

TEST_CASE("scene writer: the default scene, every digit as a person would type it") {
  const std::string expected = R"({
  "world_origin_m": [0, 0],
  "camera": {"position_m": [0, 0, 1500], "yaw_deg": 0, "pitch_deg": 5, "roll_deg": 0, "vertical_fov_deg": 55},
  "sun": {"azimuth_deg": 220, "elevation_deg": 35, "irradiance": [1, 1, 1]},
  "atmosphere": {"enabled": true},
  "ground": {"enabled": true, "albedo": [0.12, 0.14, 0.1]},
  "exposure_ev": 0,
  "clouds": {
    "seed": 1,
    "coverage": 0.45,
    "base_m": 1200,
    "thickness_m": 900,
    "extinction_per_m": 0.05,
    "growth_period_s": 0,
    "wind_m_per_s": [6, 2],
    "view_distance_m": 80000
  },
  "phase": {"function": "hg", "g": 0.85},
  "views": [],
  "particles": [],
  "sources": []
}
)";
  CHECK(written(Scene{}) == expected);
  CHECK(parse(expected) == Scene{});
}

// Fails for a key that the reader has learned and the writer has not: its value is then missing from the text.
TEST_CASE("scene writer: each key of the reader, alone at another value, is written where it belongs") {
  const TempDirectory directory;
  test::write_scene_files(directory);
  const std::vector<JsonKey> keys = scene_keys();
  std::size_t seen = 0;
  for (const JsonKey& key : keys) {
    // The camera keeps yaw and pitch, not the place that gave them; a test of its own looks at that.
    if (test::is_object_key(key) || key.path.ends_with("look_at_m")) continue;
    // A particle keeps the ellipsoid that radii and yaw gave it.
    if (key.path.ends_with("].yaw_deg")) continue;
    CAPTURE(key.path);
    json document = json::object();
    const json value = test::value_within(key, 0.4);
    test::place_at(document, key.path) = value;
    test::add_required(document, key.path, keys);
    const Scene scene = parse(document.dump(), directory.path().string());
    const std::string text = written(scene, directory.path().string());
    const json found = test::found_at(json::parse(text), key.path);
    CHECK_FALSE(found.is_null());
    if (found.is_null()) continue;
    if (found.is_number())  // a float has 24 bits
      CHECK(std::abs(found.get<double>() - value.get<double>()) <= 0x1p-24 * std::abs(value.get<double>()));
    else if (found.is_array())
      for (std::size_t i = 0; i < value.size(); ++i)
        CHECK(std::abs(found[i].get<double>() - value[i].get<double>()) <= 0x1p-22 * std::abs(value[i].get<double>()));
    else
      CHECK(found == value);
    CHECK(parse(text, directory.path().string()) == scene);
    // Equality does see the key: without it the scene is another one.
    if (!key.required) {
      json without = document;
      const std::size_t dot = key.path.rfind('.');
      json& parent = dot == std::string::npos ? without : test::place_at(without, key.path.substr(0, dot));
      parent.erase(key.path.substr(dot + 1));
      CHECK_FALSE(parse(without.dump(), directory.path().string()) == scene);
    }
    ++seen;
  }
  CHECK(seen > 70);
}

TEST_CASE("scene writer: radii and yaw come back as the ellipsoid they make, a sphere as its radius") {
  const Scene scene = parse(R"({"particles": [{"radius_m": 80}, {"radius_m": [100, 90, 60], "yaw_deg": 30},
    {"ellipsoid_m": [50, 60, 70, 5, -4, 3], "shape": "soft"}]})");
  CHECK(scene.particles[0].ellipsoid == shared::EllipsoidShape{glm::vec3(80), glm::vec3(0)});
  const json particles = json::parse(written(scene))["particles"];
  CHECK(particles[0]["radius_m"] == json({80, 80, 80}));
  CHECK(particles[1]["ellipsoid_m"].size() == 6);
  CHECK(particles[1].contains("orientation"));  // what is inside turns with the yaw
  CHECK(particles[2]["ellipsoid_m"] == json({50, 60, 70, 5, -4, 3}));
  CHECK(particles[2]["shape"] == "soft");
  CHECK(parse(written(scene)) == scene);
}

TEST_CASE("scene writer: scenes of random values in every key read back equal, bit for bit") {
  const TempDirectory directory;
  test::write_scene_files(directory);
  std::mt19937 random(7);
  for (int i = 0; i < 400; ++i) {
    const json document = test::random_document(random);
    const Scene scene = parse(document.dump(), directory.path().string());
    const std::string text = written(scene, directory.path().string());
    const Scene again = parse(text, directory.path().string());
    REQUIRE_MESSAGE(again == scene, text);
    CHECK(written(again, directory.path().string()) == text);
  }
}

TEST_CASE("scene writer: degrees give the angle that a file's degrees gave, in no more digits") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> degrees(-3600, 3600);
  std::uniform_int_distribution<int> places(0, 6);
  for (int i = 0; i < 300000; ++i) {
    double file = degrees(random);
    if (i % 2 == 0) {  // as people type them
      const double scale = std::pow(10.0, places(random));
      file = std::round(file * scale) / scale;
    }
    const double angle_rad = file * kRadiansPerDegree, given = degrees_of(angle_rad);
    if (given * kRadiansPerDegree != angle_rad) FAIL(number_text(file) << " became " << number_text(given));
    if (number_text(given).size() > number_text(file).size())
      FAIL(number_text(file) << " became " << number_text(given));
  }
}

// From 32 to 57.3 degrees, and octaves above and below that, doubles of degrees lie 1.117 times as far apart as those
// of radians: there 1 - 1 / 1.117 = 10.5 % of all angles have no degrees, elsewhere each has. Over half a turn 85 % of
// the angles lie there, so 8.9 % of all have none; 17 800 of the sample, give or take 130 by chance.
TEST_CASE("scene writer: of angles that come of no degrees most are kept, others move to the double beside them") {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> angle(-3.14159, 3.14159);
  int moved = 0;
  constexpr int kCount = 200000;
  for (int i = 0; i < kCount; ++i) {
    const double angle_rad = angle(random), back_rad = degrees_of(angle_rad) * kRadiansPerDegree;
    if (back_rad == angle_rad) continue;
    ++moved;
    const bool neighbour =
        back_rad == std::nextafter(angle_rad, -INFINITY) || back_rad == std::nextafter(angle_rad, INFINITY);
    if (!neighbour) FAIL(number_text(angle_rad) << " became " << number_text(back_rad));
    if (degrees_of(back_rad) * kRadiansPerDegree != back_rad) FAIL("moves again: " << number_text(back_rad));
  }
  CHECK(std::abs(moved - 17800) < 800);  // six times chance
  for (const double quarter_turns : {-2.0, -1.0, 0.0, 1.0, 2.0, 4.0}) {
    const double exact_rad = quarter_turns * std::numbers::pi / 2;
    CHECK(degrees_of(exact_rad) == 90.0 * quarter_turns);
    CHECK(degrees_of(exact_rad) * kRadiansPerDegree == exact_rad);
  }
}

TEST_CASE("scene writer: a float's digits give it back and are few") {
  std::mt19937 random(3);
  for (int i = 0; i < 300000; ++i) {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (!std::isfinite(value)) continue;
    const double written_as = few_digits(value);
    if (static_cast<float>(written_as) != value) FAIL(value << " became " << written_as);
    char digits[32];  // nine tell any float from its neighbours
    std::snprintf(digits, sizeof digits, "%.9g", written_as);
    if (std::strtod(digits, nullptr) != written_as) FAIL(number_text(written_as));
  }
  CHECK(number_text(few_digits(0.1f)) == "0.1");
  CHECK(number_text(few_digits(16777216.0f)) == "16777216");
}

TEST_CASE("scene writer: zeros keep their sign, large and small numbers every digit") {
  Scene scene;
  scene.camera.position_m = {-0.0, 123456789.123456789, 5e-324};
  scene.camera.yaw_rad = -0.0;
  scene.clouds->wind_m_per_s = {-0.0, 1e-300};
  scene.exposure_ev = -0.0f;
  const Scene again = parse(written(scene));
  CHECK(again == scene);
  CHECK(std::signbit(again.camera.position_m.x));
  CHECK(std::signbit(again.camera.yaw_rad));
  CHECK(std::signbit(again.clouds->wind_m_per_s.x));
  CHECK(std::signbit(again.exposure_ev));
}

TEST_CASE("scene writer: a camera that a place turned keeps its angles") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place_m(-5000, 5000);
  for (int i = 0; i < 2000; ++i) {
    const json camera{{"look_at_m", {place_m(random), place_m(random), place_m(random)}}};
    const Scene scene = parse(json{{"camera", camera}}.dump());
    if (!(parse(written(scene)) == scene)) FAIL(camera.dump());
  }
  const Scene down = parse(R"({"camera": {"look_at_m": [0, 0, 0]}})");
  CHECK(down.camera.pitch_rad == -std::numbers::pi / 2);
  CHECK(parse(written(down)) == down);
}

TEST_CASE("scene writer: which of clouds and lists are there") {
  for (const char* text : {"{}", R"({"particles": []})", R"({"sources": [], "clouds": {}})", R"({"particles": [{}]})",
                           R"({"sources": [{"kind": "particles", "particles": []}, {"kind": "field"}]})"}) {
    CAPTURE(text);
    const Scene scene = parse(text);
    const Scene again = parse(written(scene));
    CHECK(again == scene);
    CHECK(again.clouds.has_value() == scene.clouds.has_value());
  }
}

TEST_CASE("scene writer: every scene of the source tree, saved in another folder, is the same scene") {
  const TempDirectory directory;
  std::size_t seen = 0;
  for (const char* folder : {"scenes", "truth"})
    for (const auto& entry : std::filesystem::directory_iterator(std::string(NEPHELE_SOURCE_DIR "/tools/") + folder)) {
      if (entry.path().extension() != ".json" || entry.path().filename() == "spheres_path.json") continue;
      CAPTURE(entry.path());
      const Result<Scene> scene = load_scene(entry.path().string());
      REQUIRE(scene);
      const std::string path = directory / entry.path().filename().string();
      const Result<void> saved = save_scene(*scene, path);
      REQUIRE(saved);
      const Result<Scene> again = load_scene(path);
      REQUIRE(again);
      CHECK(*again == *scene);
      ++seen;
    }
  CHECK(seen >= 19);
}

TEST_CASE("scene writer: files are named from the folder that the scene is saved in, or from the root") {
  const TempDirectory directory;
  test::write_scene_files(directory);
  std::filesystem::create_directories(directory / "in/there");
  std::filesystem::create_directory_symlink(directory.path() / "in/there", directory / "link");
  test::write_file(directory / "scene.json", R"({
    "clouds": {"weather_map": {"file": "map.png", "origin_m": [0, 0], "extent_m": [1, 1]}},
    "sources": [{"kind": "set", "file": "in/../cloud.json"},
                {"kind": "field", "weather_map": {"file": "./map.png", "origin_m": [0, 0], "extent_m": [1, 1]}}]})");
  const Result<Scene> scene = load_scene(directory / "scene.json");
  REQUIRE(scene);
  const std::string root = std::filesystem::canonical(directory.path()).string();
  CHECK(scene->clouds->weather_map->file == root + "/map.png");
  CHECK(std::get<PlacedSet>(scene->sources[0]).set.file == root + "/cloud.json");

  const auto names = [&](const std::string& folder) {
    const json document = json::parse(written(*scene, folder));
    CHECK(document["clouds"]["weather_map"]["file"] == document["sources"][1]["weather_map"]["file"]);
    return std::vector<std::string>{document["clouds"]["weather_map"]["file"], document["sources"][0]["file"]};
  };
  using Names = std::vector<std::string>;
  CHECK(names("") == Names{root + "/map.png", root + "/cloud.json"});
  CHECK(names(directory.path().string()) == Names{"map.png", "cloud.json"});
  CHECK(names(directory / "in/there/") == Names{"../../map.png", "../../cloud.json"});
  CHECK(names(directory / "link") == Names{"../../map.png", "../../cloud.json"});  // where the link leads
  CHECK(names(directory / "in/there/..") == Names{"../map.png", "../cloud.json"});
  CHECK(names("/") == Names{root.substr(1) + "/map.png", root.substr(1) + "/cloud.json"});

  for (const char* place : {"copy.json", "in/copy.json", "in/there/copy.json", "link/copy.json"}) {
    CAPTURE(place);
    REQUIRE(save_scene(*scene, directory / place));
    const Result<Scene> again = load_scene(directory / place);
    REQUIRE(again);
    CHECK(*again == *scene);
  }
  // Saved over the scene itself, and where a name stands alone.
  REQUIRE(save_scene(*scene, directory / "scene.json"));
  CHECK(load_scene(directory / "scene.json"));
  CHECK(parse(written(*scene), "/nowhere") == *scene);
}

TEST_CASE("scene writer: a set that is reached through a link finds its array beside the link's own name") {
  const TempDirectory directory;
  test::write_scene_files(directory);
  std::filesystem::create_directory(directory / "a");
  std::filesystem::create_symlink("../cloud.json", directory / "a/cloud.json");
  std::filesystem::copy_file(directory / "cloud.npy", directory / "a/cloud.npy");
  const Scene scene = parse(R"({"sources": [{"kind": "set", "file": "a/cloud.json"}]})", directory.path().string());
  CHECK(std::get<PlacedSet>(scene.sources[0]).set.file.ends_with("/a/cloud.json"));
}

TEST_CASE("scene writer: what has no file, and what the reader would refuse, is one line") {
  Scene scene;
  scene.clouds->weather_map = WeatherMap{.width = 1, .height = 1, .texels = {{1, 2}}, .extent_m = {1, 1}};
  CHECK(complaint(scene) ==
        "scene: clouds.weather_map is a weather map that no file made; accepted: one that was read from a file");
  scene.sources.emplace_back(*scene.clouds);
  scene.clouds->weather_map.reset();
  CHECK(complaint(scene).starts_with("scene: sources[0].weather_map is a weather map that no file made"));
  scene.sources = {ParticleGroup{}, PlacedSet{}};
  CHECK(complaint(scene) == "scene: sources[1] is a set that no file made; accepted: one that was read from a file");
  scene.sources = {ScatteredSets{.kinds = {{}}}};
  CHECK(complaint(scene).starts_with("scene: sources[0].sets[0] is a set that no file made"));

  const auto refused = [](auto change) {
    Scene bad;
    change(bad);
    return complaint(bad);
  };
  CHECK(refused([](Scene& s) {
          s.camera.pitch_rad = 2.0;
        }).starts_with("scene: camera.pitch_deg is 114.59155902616465; accepted: a number from -90 to 90"));
  CHECK(refused([](Scene& s) { s.camera.position_m.x = NAN; }).starts_with("scene: not valid JSON: "));
  CHECK(refused([](Scene& s) { s.clouds->coverage = 1.5f; }) ==
        "scene: clouds.coverage is 1.5; accepted: a number from 0 to 1");
  CHECK(refused([](Scene& s) { s.views = {{"a", {}}, {"a", {}}}; }).starts_with("scene: views[1].name is \"a\""));
  CHECK(refused([](Scene& s) {
          s.views = {{"\xff", {}}};
        }) == "scene: a name of a view or of a file is not UTF-8, as JSON is");
  CHECK(refused([](Scene& s) { s.views = {{"tab\t\"quote\" \xc3\xa4 \n", {}}}; }) == "written");
}

TEST_CASE("scene writer: a scene that can't be saved leaves the file as it was") {
  const TempDirectory directory;
  const std::string path = directory / "scene.json";
  test::write_file(path, "before");
  Scene scene;
  scene.exposure_ev = 99.0f;
  const Result<void> saved = save_scene(scene, path);
  REQUIRE_FALSE(saved);
  CHECK(saved.error().message == path + ": exposure_ev is 99; accepted: a number from -32 to 32");
  CHECK(test::read_file(path) == "before");
  const Result<void> nowhere = save_scene(Scene{}, directory / "none/scene.json");
  REQUIRE_FALSE(nowhere);
  CHECK(nowhere.error().message.find("can't be written") != std::string::npos);
  CHECK(directory.entries() == std::vector<std::string>{"scene.json"});
}
