#include "engine/camera_path.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace nephele;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

CameraPath parse(const std::string& text) {
  const Result<CameraPath> path = parse_camera_path(text, "path.json");
  if (!path) FAIL(path.error().message);
  return *path;
}

std::string complaint(const std::string& text) {
  const Result<CameraPath> path = parse_camera_path(text, "path.json");
  return path ? "accepted" : path.error().message;
}

}  // namespace

TEST_CASE("camera path: linear positions, angles the short way round, the scene's field of view") {
  const CameraPath path = parse(R"({"fps": 10, "keys": [
      {"time_s": 1, "position_m": [0, 0, 1000], "yaw_deg": 350, "pitch_deg": -10},
      {"time_s": 3, "position_m": [100, -200, 1400], "yaw_deg": 20, "pitch_deg": 10, "roll_deg": 30}]})");
  const CameraState middle = path.at(2.0, {.vertical_fov_rad = 0.8});
  CHECK(glm::length(middle.position_m - glm::dvec3(50, -100, 1200)) < 1e-9);
  CHECK(std::remainder(middle.yaw_rad - 5 * kDegree, 2 * std::numbers::pi) == doctest::Approx(0));
  CHECK(middle.pitch_rad == doctest::Approx(0));
  CHECK(middle.roll_rad == doctest::Approx(15 * kDegree));
  CHECK(middle.vertical_fov_rad == 0.8);

  CHECK(path.at(0.0, {}).position_m == glm::dvec3(0, 0, 1000));  // rests before the first key
  CHECK(path.at(1.0, {}).position_m == glm::dvec3(0, 0, 1000));
  CHECK(path.at(3.0, {}).position_m == glm::dvec3(100, -200, 1400));
  CHECK(path.at(99.0, {}).position_m == glm::dvec3(100, -200, 1400));  // and after the last
  CHECK(path.at(99.0, {}).roll_rad == doctest::Approx(30 * kDegree));
}

TEST_CASE("camera path: positions keep millimetres 10 000 km from the origin") {
  const CameraPath path = parse(R"({"keys": [{"time_s": 0, "position_m": [1e7, 0, 0]},
                                             {"time_s": 1000, "position_m": [10000001, 0, 0]}]})");
  CHECK(path.at(1.0, {}).position_m.x - 1e7 == doctest::Approx(1e-3).epsilon(1e-5));
}

TEST_CASE("camera path: frames run to the last key, also where its time has no exact binary form") {
  const auto frames = [](const char* fps, const char* last) {
    return parse(std::string(R"({"fps": )") + fps + R"(, "keys": [{"time_s": 0, "position_m": [0, 0, 0]},
                 {"time_s": )" +
                 last + R"(, "position_m": [1, 0, 0]}]})")
        .frame_count();
  };
  CHECK(frames("30", "1") == 31);
  CHECK(frames("10", "0.7") == 8);  // 0.7 * 10 is below 7 in doubles
  CHECK(frames("30", "0.99") == 30);
  CHECK(parse(R"({"keys": [{"time_s": 0, "position_m": [0, 0, 0]}]})").frame_count() == 1);
}

TEST_CASE("camera path: errors name the key") {
  CHECK(complaint("{}") == "path.json: keys is missing");
  CHECK(complaint(R"({"keys": []})") == "path.json: keys is []; accepted: an array of at least 1 object");
  CHECK(complaint(R"({"keys": [{"position_m": [0, 0, 0]}]})") == "path.json: keys[0].time_s is missing");
  CHECK(complaint(R"({"keys": [{"time_s": 0}]})") == "path.json: keys[0].position_m is missing");
  CHECK(complaint(R"({"fps": 0, "keys": []})") == "path.json: fps is 0; accepted: a number from 0.001 to 1000");
  CHECK(complaint(R"({"keys": [{"time_s": 1, "position_m": [0, 0, 0]}, {"time_s": 1, "position_m": [0, 0, 0]}]})") ==
        "path.json: keys[1].time_s is 1; accepted: more than the previous key's 1");
  CHECK(complaint(R"({"keys": [{"time_s": 0, "position_m": [0, 0, 0], "fov_deg": 3}]})") ==
        "path.json: unknown key keys[0].fov_deg; accepted: time_s, position_m, yaw_deg, pitch_deg, roll_deg");
}
