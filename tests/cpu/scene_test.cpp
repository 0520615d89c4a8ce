#include "engine/scene.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "engine/image_io.h"
#include "tests/support/support.h"

using namespace nephele;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Scene parse(const std::string& text) {
  const Result<Scene> scene = parse_scene(text, "scene.json");
  if (!scene) FAIL(scene.error().message);
  return *scene;
}

std::string complaint(const std::string& text) {
  const Result<Scene> scene = parse_scene(text, "scene.json");
  return scene ? "accepted" : scene.error().message;
}

// The example of the interface: every key, each away from its default.
const char* const kFullScene = R"({
  "camera": {"position_m": [1, 2, 3], "yaw_deg": 10, "pitch_deg": -5, "roll_deg": 3, "vertical_fov_deg": 60},
  "sun": {"azimuth_deg": 90, "elevation_deg": -2, "irradiance": [1, 2, 3]},
  "atmosphere": {"enabled": false},
  "ground": {"enabled": false, "albedo": [0.1, 0.2, 0.3]},
  "exposure_ev": -1.5,
  "clouds": {"seed": 4294967295, "coverage": 0.3, "base_m": 900, "thickness_m": 800, "extinction_per_m": 0.04,
             "wind_m_per_s": [-6, 2], "growth_period_s": 1800, "view_distance_m": 50000},
  "phase": {"function": "cs", "g": 0.7},
  "particles": [
    {"center_m": [0, 500, 1500], "radius_m": [100, 90, 60], "yaw_deg": 30, "density": 0.7,
     "extinction_per_m": 0.05, "shape": "homogeneous", "radiance": [1, 0, 2]},
    {}
  ]
})";

}  // namespace

TEST_CASE("scene: every key arrives, in SI units and radians") {
  const Scene scene = parse(kFullScene);
  CHECK(scene.camera.position_m == glm::dvec3(1, 2, 3));
  CHECK(scene.camera.yaw_rad == doctest::Approx(10 * kDegree));
  CHECK(scene.camera.pitch_rad == doctest::Approx(-5 * kDegree));
  CHECK(scene.camera.roll_rad == doctest::Approx(3 * kDegree));
  CHECK(scene.camera.vertical_fov_rad == doctest::Approx(60 * kDegree));
  CHECK(scene.sun.azimuth_rad == doctest::Approx(90 * kDegree));
  CHECK(scene.sun.elevation_rad == doctest::Approx(-2 * kDegree));
  CHECK(scene.sun.irradiance == glm::vec3(1, 2, 3));
  CHECK_FALSE(scene.atmosphere.enabled);
  CHECK_FALSE(scene.ground.enabled);
  CHECK(scene.ground.albedo == glm::vec3(0.1f, 0.2f, 0.3f));
  CHECK(scene.exposure_ev == -1.5f);
  REQUIRE(scene.clouds.has_value());
  CHECK(scene.clouds->seed == 4294967295u);
  CHECK(scene.clouds->coverage == 0.3f);
  CHECK(scene.clouds->base_m == 900.0f);
  CHECK(scene.clouds->thickness_m == 800.0f);
  CHECK(scene.clouds->extinction_per_m == 0.04f);
  CHECK(scene.clouds->wind_m_per_s == glm::dvec2(-6, 2));
  CHECK(scene.clouds->growth_period_s == 1800.0);
  CHECK(scene.clouds->view_distance_m == 50000.0f);
  CHECK(scene.phase.function == PhaseFunction::cornette_shanks);
  CHECK(scene.phase.g == 0.7);
  REQUIRE(scene.particles.size() == 2);
  const ListedParticle& particle = scene.particles[0];
  CHECK(particle.center_m == glm::dvec3(0, 500, 1500));
  CHECK(particle.radius_m == glm::vec3(100, 90, 60));
  CHECK(particle.yaw_rad == doctest::Approx(30 * kDegree));
  CHECK(particle.density == 0.7f);
  CHECK(particle.extinction_per_m == 0.05f);
  CHECK(particle.shape == ParticleShape::homogeneous);
  REQUIRE(particle.radiance.has_value());
  CHECK(*particle.radiance == glm::vec3(1, 0, 2));
  CHECK(scene.particles[1].shape == ParticleShape::reference);
  CHECK_FALSE(scene.particles[1].radiance.has_value());
}

TEST_CASE("scene: absent keys keep their defaults") {
  const Scene scene = parse(R"({"camera": {"yaw_deg": 90}, "clouds": {"coverage": 1}})");
  CHECK(scene.camera.position_m == glm::dvec3(0, 0, 1500));
  CHECK(scene.camera.vertical_fov_rad == doctest::Approx(55 * kDegree));
  CHECK(scene.clouds->coverage == 1.0f);
  CHECK(scene.clouds->base_m == 1200.0f);
  CHECK(scene.sun.elevation_rad == doctest::Approx(35 * kDegree));
}

TEST_CASE("scene: the camera looks at a place instead of along two angles") {
  const auto looks_at = [](const std::string& place, double yaw_deg, double pitch_deg) {
    const Scene scene =
        parse(R"({"camera": {"position_m": [100, 200, 300], "roll_deg": 7, "look_at_m": )" + place + "}}");
    CHECK(scene.camera.yaw_rad == doctest::Approx(yaw_deg * kDegree));
    CHECK(scene.camera.pitch_rad == doctest::Approx(pitch_deg * kDegree));
    CHECK(scene.camera.roll_rad == doctest::Approx(7 * kDegree));
  };
  looks_at("[100, 500, 300]", 0, 0);                                   // north
  looks_at("[400, 200, 300]", 90, 0);                                  // east
  looks_at("[400, 200, 600]", 90, 45);                                 // east and up
  looks_at("[97, 196, 295]", -180 + std::atan2(3, 4) / kDegree, -45);  // a triangle of 3, 4 and 5, west of south, down
  looks_at("[100, 200, 1]", 0, -90);                                   // straight down, north stays up
  CHECK(complaint(R"({"camera": {"look_at_m": [1, 2, 3], "yaw_deg": 1}})") ==
        "scene.json: camera.look_at_m stands beside yaw_deg or pitch_deg; accepted: one or the other");
  CHECK(complaint(R"({"camera": {"look_at_m": [0, 0, 1500]}})") ==
        "scene.json: camera.look_at_m is the camera's own place");
  CHECK(complaint(R"({"camera": {"look_at_m": [0, 0, 2e6]}})") ==
        "scene.json: camera.look_at_m[2] is 2000000; accepted: a number from -1000000 to 1000000");
}

TEST_CASE("scene: which of clouds and listed particles are drawn") {
  CHECK(parse("{}").clouds.has_value());
  CHECK_FALSE(parse(R"({"particles": []})").clouds.has_value());
  CHECK_FALSE(parse(R"({"particles": [{}]})").clouds.has_value());
  CHECK(parse(R"({"particles": [{}], "clouds": {}})").clouds.has_value());
}

TEST_CASE("scene: 65 536 particles and 10 000 km are within limits") {
  std::ostringstream text;
  text << R"({"particles": [)";
  for (int i = 0; i < 65536; ++i) text << (i ? "," : "") << R"({"center_m": [)" << i << R"(, 1e7, 1500]})";
  text << "]}";
  const Scene scene = parse(text.str());
  REQUIRE(scene.particles.size() == 65536);
  CHECK(scene.particles.back().center_m == glm::dvec3(65535, 1e7, 1500));
}

TEST_CASE("scene: errors name file, key path, value and what is accepted") {
  CHECK(complaint(R"({"clouds": {"coverage": 1.5}})") ==
        "scene.json: clouds.coverage is 1.5; accepted: a number from 0 to 1");
  CHECK(complaint(R"({"clouds": {"coverge": 1}})") ==
        "scene.json: unknown key clouds.coverge; accepted: seed, coverage, base_m, thickness_m, extinction_per_m, "
        "growth_period_s, wind_m_per_s, view_distance_m, weather_map");
  CHECK(complaint(R"({"cloud": {}})") ==
        "scene.json: unknown key cloud; accepted: world_origin_m, camera, sun, atmosphere, ground, exposure_ev, "
        "clouds, phase, "
        "particles");
  CHECK(complaint(R"({"camera": {"position_m": [0, 0]}})") ==
        "scene.json: camera.position_m is [0,0]; accepted: an array of 3 numbers");
  CHECK(complaint(R"({"camera": {"position_m": [0, 0, -1]}})") ==
        "scene.json: camera.position_m[2] is -1; accepted: a number from 0 to 1000000");
  CHECK(complaint(R"({"particles": [{}, {"radius_m": [1, 0, 1]}]})") ==
        "scene.json: particles[1].radius_m[1] is 0; accepted: a number from 0.01 to 100000");
  CHECK(complaint(R"({"particles": [{"shape": "cube"}]})") ==
        "scene.json: particles[0].shape is \"cube\"; accepted: \"reference\", \"homogeneous\"");
  CHECK(complaint(R"({"clouds": {"seed": 1.0}})") ==
        "scene.json: clouds.seed is 1.0; accepted: a whole number from 0 to 4294967295");
  CHECK(complaint(R"({"ground": {"enabled": 1}})") == "scene.json: ground.enabled is 1; accepted: true or false");
  CHECK(complaint(R"({"sun": [1]})") == "scene.json: sun is [1]; accepted: an object");
  CHECK(complaint(R"([])") == "scene.json: the document is []; accepted: an object");
}

TEST_CASE("scene: values out of range, one beyond each limit, are refused") {
  for (const char* text : {R"({"camera": {"position_m": [1e10, 0, 0]}})",
                           R"({"camera": {"yaw_deg": 3601}})",
                           R"({"camera": {"pitch_deg": 90.1}})",
                           R"({"camera": {"vertical_fov_deg": 0}})",
                           R"({"camera": {"vertical_fov_deg": 171}})",
                           R"({"sun": {"elevation_deg": -91}})",
                           R"({"sun": {"irradiance": [1, -1, 1]}})",
                           R"({"ground": {"albedo": [0, 0, 1.01]}})",
                           R"({"exposure_ev": 33})",
                           R"({"clouds": {"seed": -1}})",
                           R"({"clouds": {"seed": 4294967296}})",
                           R"({"clouds": {"base_m": -1}})",
                           R"({"clouds": {"thickness_m": 0.9}})",
                           R"({"clouds": {"extinction_per_m": -0.1}})",
                           R"({"clouds": {"wind_m_per_s": [501, 0]}})",
                           R"({"clouds": {"view_distance_m": 0}})",
                           R"({"phase": {"g": 1}})",
                           R"({"particles": [{"center_m": [0, 0, 2e6]}]})",
                           R"({"particles": [{"density": -1}]})",
                           R"({"particles": [{"extinction_per_m": 1e7}]})",
                           R"({"particles": [{"radiance": [0, 0, 1e7]}]})",
                           R"({"particles": [{"radiance": null}]})"}) {
    CAPTURE(text);
    CHECK(complaint(text).find("; accepted: ") != std::string::npos);
  }
}

TEST_CASE("scene: a key given twice is an error, wherever it is") {
  CHECK(complaint(R"({"exposure_ev": 1, "exposure_ev": 2})") == "scene.json: key exposure_ev is given twice");
  CHECK(complaint(R"({"clouds": {"seed": 1, "base_m": 2, "seed": 3}})") ==
        "scene.json: key clouds.seed is given twice");
  CHECK(complaint(R"({"particles": [{"density": 1}, {"density": 1, "density": 1}]})") ==
        "scene.json: key particles[1].density is given twice");
  // The same name in different objects is no repetition.
  CHECK(complaint(R"({"clouds": {"extinction_per_m": 0.1}, "particles": [{"extinction_per_m": 0.1}, {}]})") ==
        "accepted");
}

TEST_CASE("scene: broken JSON, NaN and infinities give one clear line") {
  for (const char* text :
       {"", "{", "{\"sun\": {\"azimuth_deg\": NaN}}", "{\"exposure_ev\": Infinity}", "{\"exposure_ev\": 1e999}",
        "{\"exposure_ev\": 1,}", "{} {}", "\xff\xfe", "{\"a\n\tb\": 1}"}) {
    CAPTURE(text);
    const std::string message = complaint(text);
    CHECK(message.starts_with("scene.json: not valid JSON: "));
    CHECK(message.find('\n') == std::string::npos);
  }
}

TEST_CASE("scene: every truncation of a scene file is an error, never a crash or a silent default") {
  const std::string whole = kFullScene;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const std::string message = complaint(whole.substr(0, length));
    CHECK_MESSAGE(message.starts_with("scene.json: not valid JSON: "), length, " characters: ", message);
  }
}

TEST_CASE("scene: a missing file and a directory are named") {
  const test::TempDirectory directory;
  const Result<Scene> missing = load_scene(directory / "none.json");
  REQUIRE_FALSE(missing);
  CHECK(missing.error().message == directory / "none.json" + ": can't be opened: No such file or directory");
  const Result<Scene> folder = load_scene(directory.path().string());
  REQUIRE_FALSE(folder);
  CHECK(folder.error().message == directory.path().string() + ": is a directory, not a file");

  test::write_file(directory / "some.json", R"({"exposure_ev": 2})");
  const Result<Scene> some = load_scene(directory / "some.json");
  REQUIRE(some);
  CHECK(some->exposure_ev == 2.0f);
}

TEST_CASE("scene: a weather map is found beside the scene file, red the coverage, green the type") {
  const test::TempDirectory directory;
  const std::vector<std::uint8_t> rgba{1, 2, 99, 255, 3, 4,  99, 255, 5,  6,  99, 255,
                                       7, 8, 99, 255, 9, 10, 99, 255, 11, 12, 99, 255};
  REQUIRE(write_png(directory / "map.png", 3, 2, rgba));
  test::write_file(
      directory / "scene.json",
      R"({"clouds": {"weather_map": {"file": "map.png", "origin_m": [-1e7, 2], "extent_m": [3000, 4e7]}}})");
  const Result<Scene> scene = load_scene(directory / "scene.json");
  REQUIRE(scene);
  REQUIRE(scene->clouds->weather_map);
  const WeatherMap& map = *scene->clouds->weather_map;
  CHECK(map.width == 3);
  CHECK(map.height == 2);
  CHECK(map.texels == std::vector<glm::u8vec2>{{1, 2}, {3, 4}, {5, 6}, {7, 8}, {9, 10}, {11, 12}});
  CHECK(map.origin_m == glm::dvec2(-1e7, 2));
  CHECK(map.extent_m == glm::dvec2(3000, 4e7));
  CHECK(check_weather_map(map));
}

TEST_CASE("scene: what is wrong with a weather map is named on one line") {
  const test::TempDirectory directory;
  test::write_file(directory / "text.png", "not an image");
  REQUIRE(write_png(directory / "wide.png", 4097, 1, std::vector<std::uint8_t>(4097 * 4)));
  const auto complaint_about = [&](const std::string& map) {
    const Result<Scene> scene =
        parse_scene(R"({"clouds": {"weather_map": )" + map + "}}", "scene.json", directory.path().string());
    return scene ? "accepted" : scene.error().message;
  };
  const std::string place = R"(, "origin_m": [0, 0], "extent_m": [1000, 1000]})";
  CHECK(complaint_about(R"({"file": "none.png")" + place) ==
        "scene.json: clouds.weather_map.file: " + directory / "none.png" +
            ": can't be opened: No such file or directory");
  CHECK(complaint_about(R"({"file": "text.png")" + place).find("text.png: can't be read as a PNG image: ") !=
        std::string::npos);
  CHECK(complaint_about(R"({"file": "wide.png")" + place)
            .find("wide.png: can't be read as a PNG image: it is 4097 x 1; accepted: 1 to 4096 a side") !=
        std::string::npos);
  CHECK(complaint_about(R"({"file": "")" + place).find("clouds.weather_map.file is \"\"") != std::string::npos);
  CHECK(complaint_about(R"({"file": "a.png", "origin_m": [0, 0]})") ==
        "scene.json: clouds.weather_map.extent_m is missing");
  CHECK(complaint_about(R"({"file": "a.png", "extent_m": [1, 1]})") ==
        "scene.json: clouds.weather_map.origin_m is missing");
  CHECK(complaint_about(R"({"origin_m": [0, 0], "extent_m": [1, 1]})") ==
        "scene.json: clouds.weather_map.file is missing");
  for (const char* extent : {"[0, 1000]", "[1000, -1]", "[1000, 1e8]", "[1000]", "[\"a\", 1]", "1000"})
    CHECK(complaint_about(R"({"file": "a.png", "origin_m": [0, 0], "extent_m": )" + std::string(extent) + "}")
              .find("clouds.weather_map.extent_m") != std::string::npos);
  CHECK(complaint_about(R"({"file": "a.png", "origin_m": [0, 1e10], "extent_m": [1, 1]})")
            .find("clouds.weather_map.origin_m[1]") != std::string::npos);
  CHECK(complaint_about(R"({"file": "a.png", "origin_m": [0, 0], "extent_m": [1e999, 1]})").find("not valid JSON") !=
        std::string::npos);
  CHECK(complaint_about("7") == "scene.json: clouds.weather_map is 7; accepted: an object");
}

TEST_CASE("scene: weather maps that no file made are checked") {
  const WeatherMap good{
      .width = 2, .height = 1, .texels = {{0, 0}, {255, 255}}, .origin_m = {0, 0}, .extent_m = {100, 100}};
  CHECK(check_weather_map(good));
  const auto refused = [&](auto change) {
    WeatherMap bad = good;
    change(bad);
    const Result<void> checked = check_weather_map(bad);
    return !checked && checked.error().message.starts_with("weather map");
  };
  CHECK(refused([](WeatherMap& m) { m.texels.pop_back(); }));
  CHECK(refused([](WeatherMap& m) { m.width = 0; }));
  CHECK(refused([](WeatherMap& m) { m.height = 4097; }));
  CHECK(refused([](WeatherMap& m) { m.extent_m.x = 0.0; }));
  CHECK(refused([](WeatherMap& m) { m.extent_m.y = NAN; }));
  CHECK(refused([](WeatherMap& m) { m.origin_m.y = INFINITY; }));
}
