#include "engine/scene.h"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <sstream>

#include "engine/image_io.h"
#include "engine/json_reader.h"
#include "engine/particle_set.h"
#include "shared/ellipsoid.h"
#include "tests/support/shapes.h"
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
     "extinction_per_m": 0.05, "shape": "homogeneous", "radiance": [1, 0, 2], "base_m": 1450, "top_m": 2000,
     "orientation": [0, 0.6, 0, 0.8]},
    {}
  ],
  "sources": [
    {"kind": "field", "seed": 9, "base_m": 3000},
    {"kind": "particles", "particles": [{"radius_m": [10, 20, 30]}, {}], "at_m": [5, 6, 7],
     "heading_deg": 90, "scale": 2, "drifts": true, "wind_m_per_s": [3, -4]}
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
  // Semi-axes of 100, 90 and 60 m; the first points 30 degrees off east, to the south.
  const glm::dmat3 shape = test::matrix_of(particle.ellipsoid);
  const double c = std::cos(30 * kDegree), s = std::sin(30 * kDegree);
  CHECK(glm::length(shape * glm::dvec3(c, -s, 0) - 100.0 * glm::dvec3(c, -s, 0)) < 1e-4);
  CHECK(glm::length(shape * glm::dvec3(s, c, 0) - 90.0 * glm::dvec3(s, c, 0)) < 1e-4);
  CHECK(glm::length(shape * glm::dvec3(0, 0, 1) - 60.0 * glm::dvec3(0, 0, 1)) < 1e-4);
  CHECK(particle.density == 0.7f);
  CHECK(particle.extinction_per_m == 0.05f);
  CHECK(particle.shape == ParticleShape::homogeneous);
  REQUIRE(particle.radiance.has_value());
  CHECK(*particle.radiance == glm::vec3(1, 0, 2));
  CHECK(particle.base_m == 1450.0f);
  CHECK(particle.top_m == 2000.0f);
  REQUIRE(particle.orientation.has_value());
  // What is inside turns with the yaw, after its own orientation.
  const auto turned = [](const glm::vec3& v) { return glm::vec3(shared::render_from_local(v, float(30 * kDegree))); };
  for (const glm::vec3 v : {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)})
    CHECK(glm::length(shared::quaternion_rotate(*particle.orientation, v) -
                      turned(shared::quaternion_rotate(glm::vec4(0, 0.6f, 0, 0.8f), v))) < 1e-6f);
  CHECK(scene.particles[1].shape == ParticleShape::reference);
  CHECK_FALSE(scene.particles[1].radiance.has_value());
  CHECK_FALSE(scene.particles[1].base_m.has_value());
  CHECK_FALSE(scene.particles[1].top_m.has_value());
  CHECK_FALSE(scene.particles[1].orientation.has_value());
  REQUIRE(scene.sources.size() == 2);
  const auto& field = std::get<CloudSettings>(scene.sources[0]);
  CHECK(field.seed == 9);
  CHECK(field.base_m == 3000.0f);
  CHECK(field.coverage == CloudSettings{}.coverage);
  const auto& group = std::get<ParticleGroup>(scene.sources[1]);
  REQUIRE(group.particles.size() == 2);
  CHECK(group.particles[0].ellipsoid == shared::EllipsoidShape{glm::vec3(10, 20, 30), glm::vec3(0)});
  CHECK(group.placement.at_m == glm::dvec3(5, 6, 7));
  CHECK(group.placement.heading_rad == doctest::Approx(90 * kDegree));
  CHECK(group.placement.scale == 2.0);
  CHECK(group.placement.drifts);
  REQUIRE(group.placement.wind_m_per_s.has_value());
  CHECK(*group.placement.wind_m_per_s == glm::dvec2(3, -4));
  REQUIRE(cloud_fields(scene).size() == 2);
  CHECK(cloud_fields(scene)[1]->seed == 9);
}

TEST_CASE("scene: a set and a field's map are found beside the scene file") {
  const test::TempDirectory dir;
  ParticleSet set;
  set.base_m = 10.0f;
  set.top_m = 90.0f;
  set.particles.push_back({.center_m = {1, 2, 3}, .diagonal_m = {30, 20, 10}});
  give_particles_base_and_top(set);
  REQUIRE(save_particle_set(dir / "cloud.json", set));
  REQUIRE(write_png(dir / "map.png", 1, 1, std::vector<std::uint8_t>{128, 255, 0, 255}));
  const auto load = [&](const std::string& text) {
    test::write_file(dir / "scene.json", text);
    return load_scene(dir / "scene.json");
  };
  const Result<Scene> scene = load(R"({"sources": [
    {"kind": "set", "file": "cloud.json", "at_m": [100, 0, 1000]},
    {"kind": "field", "weather_map": {"file": "map.png", "origin_m": [0, 0], "extent_m": [1000, 1000]}}]})");
  if (!scene) FAIL(scene.error().message);
  CHECK_FALSE(scene->clouds.has_value());
  const auto& placed = std::get<PlacedSet>(scene->sources[0]);
  CHECK(placed.placement.drifts);
  CHECK(placed.instances.empty());
  REQUIRE(placed.set.set);
  CHECK(*placed.set.set == set);
  CHECK(std::get<CloudSettings>(scene->sources[1]).weather_map->texels[0] == glm::u8vec2(128, 255));

  const std::string path = dir / "scene.json";
  const auto fault = [&](const std::string& text) {
    const Result<Scene> refused = load(text);
    return refused ? "accepted" : refused.error().message;
  };
  CHECK(fault(R"({"sources": [{"kind": "set", "file": "absent.json"}]})").find(path + ": sources[0].file: ") == 0);
}

TEST_CASE("scene: each fault of a source is one line") {
  CHECK(complaint(R"({"particles": [{"ellipsoid_m": [1, 1, 1, 2, 0, 0]}]})") ==
        "scene.json: particles[0].ellipsoid_m is [1,1,1,2,0,0]; accepted: xx, yy, zz, xy, xz, yz of a positive "
        "definite matrix");
  CHECK(complaint(R"({"particles": [{"ellipsoid_m": [1, 1, 1, 0, 0, 0], "yaw_deg": 1}]})") ==
        "scene.json: particles[0].ellipsoid_m stands beside radius_m or yaw_deg; accepted: one or the other");
  CHECK(complaint(R"({"sources": [{"kind": "scatter"}]})") == "scene.json: sources[0].sets is missing");
  CHECK(complaint(R"({"sources": [{"kind": "scatter", "sets": [{"file": "x.json", "share": 0}]}]})") ==
        "scene.json: sources[0].sets has no set whose share is above 0; accepted: at least one");
  CHECK(complaint(R"({"sources": [{"kind": "scatter", "sets": [{"file": "x.json"}], "scale": [2, 1]}]})") ==
        "scene.json: sources[0].scale is [2,1]; accepted: the least and then the greatest");
  CHECK(complaint(R"({"sources": [{"kind": "scatter", "sets": [{"file": "x.json"}], "clouds_per_km2": 100}]})") ==
        "scene.json: sources[0].clouds_per_km2 makes 2560000 places within view_distance_m; accepted: at most 1048576");
  CHECK(complaint(R"({"sources": [{}]})") == "scene.json: sources[0].kind is missing");
  CHECK(complaint(R"({"sources": [{"kind": "fog"}]})") ==
        "scene.json: sources[0].kind is \"fog\"; accepted: \"set\", \"scatter\", \"field\", \"particles\"");
  CHECK(complaint(R"({"sources": [{"kind": "set"}]})") == "scene.json: sources[0].file is missing");
  CHECK(complaint(R"({"sources": [{"kind": "particles"}]})") == "scene.json: sources[0].particles is missing");
  CHECK(complaint(R"({"sources": [{"kind": "set", "file": "x.json", "scale": 0}]})") ==
        "scene.json: sources[0].scale is 0; accepted: a number from 0.001 to 1000");
  CHECK(complaint(R"({"sources": [{"kind": "field", "at_m": [0, 0, 0]}]})")
            .find("scene.json: unknown key sources[0].at_m; accepted: kind, seed") == 0);
  CHECK(complaint(R"({"sources": [{"kind": "particles", "particles": [], "coverage": 1}]})")
            .find("scene.json: unknown key sources[0].coverage; accepted: kind, particles, at_m, heading_deg, scale, "
                  "drifts, "
                  "wind_m_per_s") == 0);
  CHECK(complaint(R"({"particles": [{"base_m": 100, "top_m": 99}]})") ==
        "scene.json: particles[0].top_m is 99; accepted: base_m or more");
  CHECK(complaint(R"({"particles": [{"orientation": [1, 1, 0, 0]}]})") ==
        "scene.json: particles[0].orientation is [1,1,0,0]; accepted: a unit quaternion x, y, z, w");
  CHECK(complaint(R"({"particles": [{"orientation": [0, 0, 0, 0]}]})").find("a unit quaternion") != std::string::npos);
  std::string many = R"({"sources": [)";
  for (int i = 0; i < 65; ++i) many += std::string(i > 0 ? "," : "") + R"({"kind": "field"})";
  CHECK(complaint(many + "]}").find("accepted: an array of at most 64 objects") != std::string::npos);
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
        "scene.json: camera.look_at_m[2] is 2000000.0; accepted: a number from -1000000 to 1000000");
}

TEST_CASE("scene: views are cameras with names, in the file's order, and leave the camera alone") {
  const Scene scene = parse(R"({"camera": {"yaw_deg": 20}, "views": [
    {"name": "near", "camera": {"position_m": [1, 2, 3], "yaw_deg": 10, "pitch_deg": -5, "roll_deg": 3,
                                "vertical_fov_deg": 60}},
    {"name": "2", "camera": {"look_at_m": [1000, 0, 1500]}},
    {"name": "as by default"}]})");
  CHECK(scene.camera.yaw_rad == 20 * kRadiansPerDegree);
  CHECK(scene.clouds.has_value());  // views are no clouds
  REQUIRE(scene.views.size() == 3);
  CHECK(scene.views[0].name == "near");
  CHECK(scene.views[0].camera.position_m == glm::dvec3(1, 2, 3));
  CHECK(scene.views[0].camera.yaw_rad == 10 * kRadiansPerDegree);
  CHECK(scene.views[0].camera.pitch_rad == -5 * kRadiansPerDegree);
  CHECK(scene.views[0].camera.roll_rad == 3 * kRadiansPerDegree);
  CHECK(scene.views[0].camera.vertical_fov_rad == 60 * kRadiansPerDegree);
  CHECK(std::abs(scene.views[1].camera.yaw_rad - 90 * kRadiansPerDegree) < 1e-15);
  CHECK(scene.views[2].camera == CameraState{});  // not the scene's own
  CHECK(parse("{}").views.empty());
}

TEST_CASE("scene: each fault of a view is one line") {
  CHECK(complaint(R"({"views": [{}]})") == "scene.json: views[0].name is missing");
  CHECK(complaint(R"({"views": [{"name": ""}]})") ==
        "scene.json: views[0].name is \"\"; accepted: a text that is not empty");
  CHECK(complaint(R"({"views": [{"name": 3}]})") ==
        "scene.json: views[0].name is 3; accepted: a text that is not empty");
  CHECK(complaint(R"({"views": [{"name": "a"}, {"name": "b"}, {"name": "a"}]})") ==
        "scene.json: views[2].name is \"a\"; accepted: a name that no other view has");
  CHECK(complaint(R"({"views": [{"name": "a", "camera": {"pitch_deg": 91}}]})") ==
        "scene.json: views[0].camera.pitch_deg is 91; accepted: a number from -90 to 90");
  CHECK(complaint(R"({"views": [{"name": "a", "camera": {"zoom": 2}}]})")
            .starts_with("scene.json: unknown key views[0].camera.zoom; accepted: position_m, yaw_deg"));
  CHECK(complaint(R"({"views": [{"name": "a", "sun": {}}]})") ==
        "scene.json: unknown key views[0].sun; accepted: name, camera");
  CHECK(complaint(R"({"views": {"name": "a"}})") ==
        "scene.json: views is an object; accepted: an array of at most 64 objects");
  std::string many = R"({"views": [)";
  for (int i = 0; i < 65; ++i) many += (i > 0 ? R"(,{"name": ")" : R"({"name": ")") + std::to_string(i) + "\"}";
  CHECK(complaint(many + "]}") == "scene.json: views is an array of 65; accepted: an array of at most 64 objects");
}

TEST_CASE("scene: quaternions that are unit but for roundings stand as they are, others are normalised") {
  const auto orientation = [](const std::string& text) {
    return *parse(R"({"particles": [{"orientation": )" + text + "}]}").particles[0].orientation;
  };
  CHECK(orientation("[0, 0.6, 0, 0.8]") == glm::vec4(0, 0.6f, 0, 0.8f));
  const glm::vec4 long_one = orientation("[0, 0.6003, 0, 0.8004]");
  CHECK(std::abs(long_one.y - 0.6f) < 1e-7f);
  CHECK(std::abs(long_one.w - 0.8f) < 1e-7f);
}

TEST_CASE("scene: which of clouds and listed particles are drawn") {
  CHECK(parse("{}").clouds.has_value());
  CHECK_FALSE(parse(R"({"particles": []})").clouds.has_value());
  CHECK_FALSE(parse(R"({"particles": [{}]})").clouds.has_value());
  CHECK(parse(R"({"particles": [{}], "clouds": {}})").clouds.has_value());
  CHECK_FALSE(parse(R"({"sources": []})").clouds.has_value());
  CHECK(parse(R"({"sources": [], "clouds": {}})").clouds.has_value());
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
  CHECK(
      complaint(R"({"cloud": {}})") ==
      "scene.json: unknown key cloud; accepted: world_origin_m, camera, sun, atmosphere, ground, terrain, exposure_ev, "
      "views, clouds, phase, "
      "particles, sources");
  CHECK(complaint(R"({"camera": {"position_m": [0, 0]}})") ==
        "scene.json: camera.position_m is [0,0]; accepted: an array of 3 numbers");
  CHECK(complaint(R"({"camera": {"position_m": [0, 0, -1]}})") ==
        "scene.json: camera.position_m[2] is -1; accepted: a number from 0 to 1000000");
  CHECK(complaint(R"({"particles": [{}, {"radius_m": [1, 0, 1]}]})") ==
        "scene.json: particles[1].radius_m[1] is 0; accepted: a number from 0.01 to 100000");
  CHECK(complaint(R"({"particles": [{"shape": "cube"}]})") ==
        "scene.json: particles[0].shape is \"cube\"; accepted: \"reference\", \"homogeneous\", \"soft\"");
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

TEST_CASE("scene: terrain is found beside the scene file; 8 bits are spread over 16") {
  const test::TempDirectory directory;
  test::write_file(directory / "heights.png", test::grey_png(3, 2, 8, {0, 1, 255, 128, 7, 9}));
  test::write_file(directory / "scene.json",
                   R"({"terrain": {"file": "heights.png", "origin_m": [-1e7, 2], "extent_m": [3000, 4e7],
                       "lowest_m": 12.5, "highest_m": 9000}})");
  const Result<Scene> scene = load_scene(directory / "scene.json");
  REQUIRE(scene);
  REQUIRE(scene->terrain);
  const Terrain& terrain = *scene->terrain;
  CHECK(terrain.file == (std::filesystem::canonical(directory.path()) / "heights.png").string());
  CHECK(terrain.width == 3);
  CHECK(terrain.height == 2);
  CHECK(terrain.texels == std::vector<std::uint16_t>{0, 257, 65535, 128 * 257, 7 * 257, 9 * 257});
  CHECK(terrain.origin_m == glm::dvec2(-1e7, 2));
  CHECK(terrain.extent_m == glm::dvec2(3000, 4e7));
  CHECK(terrain.lowest_m == 12.5f);
  CHECK(terrain.highest_m == 9000.0f);
  CHECK(check_terrain(terrain));
  CHECK_FALSE(Scene{}.terrain);
}

TEST_CASE("scene: what is wrong with terrain is named on one line") {
  const test::TempDirectory directory;
  test::write_file(directory / "text.png", "not an image");
  test::write_file(directory / "good.png", test::grey_png(2, 2, 16, {0, 1, 2, 3}));
  test::write_file(directory / "flat.png", test::grey_png(2, 1, 8, {0, 1}));
  REQUIRE(write_png(directory / "color.png", 2, 2, std::vector<std::uint8_t>(16)));
  REQUIRE(write_png(directory / "wide.png", 2049, 1, std::vector<std::uint8_t>(2049 * 4)));
  const auto complaint_about = [&](const std::string& terrain) {
    const Result<Scene> scene = parse_scene(R"({"terrain": )" + terrain + "}", "scene.json", directory.path().string());
    return scene ? "accepted" : scene.error().message;
  };
  const auto of_file = [&](const std::string& name) {
    return complaint_about(R"({"file": ")" + name +
                           R"(", "origin_m": [0, 0], "extent_m": [1000, 1000], "lowest_m": 0, "highest_m": 9})");
  };
  CHECK(of_file("good.png") == "accepted");
  CHECK(of_file("none.png") ==
        "scene.json: terrain.file: " + directory / "none.png" + ": can't be opened: No such file or directory");
  CHECK(of_file("text.png").find("text.png: can't be read as a PNG image: ") != std::string::npos);
  CHECK(of_file("color.png") == "scene.json: terrain.file: " + directory / "color.png" +
                                    ": can't be read as a PNG image: it has colours; accepted: a grey image of 8 or "
                                    "16 bits");
  CHECK(of_file("wide.png").find("it is 2049 x 1; accepted: 1 to 2048 a side") != std::string::npos);
  CHECK(of_file("flat.png") == "scene.json: terrain.file: " + directory / "flat.png" +
                                   ": terrain is 2 x 1 texels; accepted: 2 to 2048 a side");
  for (const char* key : {"file", "origin_m", "extent_m", "lowest_m", "highest_m"}) {
    std::string text = R"({"file": "good.png", "origin_m": [0, 0], "extent_m": [1, 1], "lowest_m": 0, "highest_m": 9})";
    text.replace(text.find(key), std::string(key).size(), "unused");
    CHECK(complaint_about(text).find(concat("terrain.", key, " is missing")) != std::string::npos);
  }
  const auto of_altitudes = [&](const std::string& lowest, const std::string& highest) {
    return complaint_about(R"({"file": "good.png", "origin_m": [0, 0], "extent_m": [9, 9], "lowest_m": )" + lowest +
                           R"(, "highest_m": )" + highest + "}");
  };
  CHECK(of_altitudes("7", "7") == "accepted");
  CHECK(of_altitudes("7", "6.5") == "scene.json: terrain.highest_m is 6.5; accepted: lowest_m or more");
  CHECK(of_altitudes("-1", "6") == "scene.json: terrain.lowest_m is -1; accepted: a number from 0 to 9000");
  CHECK(of_altitudes("0", "9001") == "scene.json: terrain.highest_m is 9001; accepted: a number from 0 to 9000");
  CHECK(complaint_about("7") == "scene.json: terrain is 7; accepted: an object");
}

TEST_CASE("scene: terrain that no file made is checked") {
  const Terrain good{.width = 2, .height = 2, .texels = {0, 1, 2, 3}, .extent_m = {100, 100}, .highest_m = 5.0f};
  CHECK(check_terrain(good));
  const auto refused = [&](auto change) {
    Terrain bad = good;
    change(bad);
    const Result<void> checked = check_terrain(bad);
    return !checked && checked.error().message.starts_with("terrain");
  };
  CHECK(refused([](Terrain& t) { t.texels.pop_back(); }));
  CHECK(refused([](Terrain& t) { t.width = 1; }));
  CHECK(refused([](Terrain& t) { t.height = 2049; }));
  CHECK(refused([](Terrain& t) { t.extent_m.x = 0.0; }));
  CHECK(refused([](Terrain& t) { t.origin_m.y = INFINITY; }));
  CHECK(refused([](Terrain& t) { t.lowest_m = -1.0f; }));
  CHECK(refused([](Terrain& t) { t.lowest_m = 6.0f; }));
  CHECK(refused([](Terrain& t) { t.highest_m = NAN; }));
}
