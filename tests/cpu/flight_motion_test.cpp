// The viewer's camera: orientation at every attitude, motion that no frame rate changes, ground, poles.
#include "tools/fly/flight.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "engine/camera.h"

using namespace nephele;
using namespace nephele::fly;

namespace {

constexpr double kPi = std::numbers::pi;

double ground_at_0(const glm::dvec2&) { return 0.0; }

void check_same_axes(const CameraState& a, const CameraState& b) {
  const CameraAxes x = camera_axes(a), y = camera_axes(b);
  // A few roundings of unit vectors; a roll near the poles of view is a difference of nearly equal angles.
  CHECK(glm::distance(x.right, y.right) < 1e-8);
  CHECK(glm::distance(x.up, y.up) < 1e-8);
  CHECK(glm::distance(x.forward, y.forward) < 1e-8);
}

}  // namespace

TEST_CASE("flight: angles and orientation are two ways to say the same, straight up and down too") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> turn(-kPi, kPi), tilt(-kPi / 2, kPi / 2);
  for (int i = 0; i < 2000; ++i) {
    CameraState camera{.yaw_rad = turn(random), .pitch_rad = tilt(random), .roll_rad = turn(random)};
    if (i % 4 == 0) camera.pitch_rad = i % 8 ? kPi / 2 : -kPi / 2;
    CameraState back = camera;
    set_orientation(back, orientation_of(camera));
    check_same_axes(camera, back);
    CHECK(std::abs(back.pitch_rad) <= kPi / 2);
  }
}

TEST_CASE("flight: speeding up follows a critically damped spring, whatever the frame rate") {
  for (const int frames : {7, 60, 480}) {
    Flight flight(CameraState{.position_m = {0, 0, 1000}, .pitch_rad = 0});
    FlyInput input;
    input.move = {0, 1, 0};
    const double time_s = 1.5, speed = flight.speed_m_per_s(), w = 8.0;
    for (int i = 0; i < frames; ++i) flight.step(input, time_s / frames, ground_at_0);
    const double e = std::exp(-w * time_s);
    const double way_m = speed * (time_s - 2.0 / w * (1.0 - e) + time_s * e);
    CHECK(std::abs(flight.camera().position_m.y - way_m) < 1e-8);
    CHECK(std::abs(flight.velocity_m_per_s().y - speed * (1.0 - (1.0 + w * time_s) * e)) < 1e-9);
  }
}

TEST_CASE("flight: a turning flight ends in nearly the same place at any frame rate") {
  const auto end_of = [](int frames_per_s) {
    Flight flight(CameraState{.position_m = {0, 0, 1000}});
    FlyInput input;
    input.move = {0.3, 1, 0.1};
    input.look_rate = {0.5, 0.1};
    input.roll = 0.2;
    for (int i = 0; i < 3 * frames_per_s; ++i) flight.step(input, 1.0 / frames_per_s, ground_at_0);
    return flight.camera().position_m;
  };
  // Directions are held for a frame: first order in its time, 1 m of 150 at 30 frames a second.
  CHECK(glm::distance(end_of(30), end_of(960)) < 3.0);
  CHECK(glm::distance(end_of(120), end_of(960)) < 0.75);
}

TEST_CASE("flight: what the mouse asks for is turned in full, later, whatever the frame rate") {
  for (const int frames : {1, 5, 100}) {
    Flight flight(CameraState{.pitch_rad = 0});
    FlyInput input;
    input.look_px = {200, 0};
    flight.step(input, 1e-3, ground_at_0);
    const double at_once = flight.camera().yaw_rad;
    for (int i = 0; i < frames; ++i) flight.step({}, 1.0 / frames, ground_at_0);
    CHECK(at_once > 0.0);
    CHECK(at_once < 0.1 * flight.camera().yaw_rad);
    CHECK(std::abs(flight.camera().yaw_rad - 0.5) < 1e-9);  // 200 px of 0.0025 rad, to the right
    CHECK(std::abs(flight.camera().roll_rad) < 1e-12);
  }
}

TEST_CASE("flight: the camera never comes below its height above the ground, and leaves it again") {
  const auto hill = [](const glm::dvec2& p) { return 100.0 * std::exp(-glm::dot(p, p) / 1e6); };
  Flight flight(CameraState{.position_m = {-3000, 0, 50}, .yaw_rad = kPi / 2, .pitch_rad = 0});
  FlyInput down;
  down.move = {0, 1, -1};
  down.faster = true;
  for (int i = 0; i < 900; ++i) {
    flight.step(down, 1.0 / 30, hill);
    const glm::dvec3 p = flight.camera().position_m;
    REQUIRE(p.z >= hill(glm::dvec2(p)) + kEyeHeightM - 1e-9);
  }
  CHECK(flight.camera().position_m.x > 1000.0);  // over the hill, not stuck at it
  FlyInput up;
  up.move = {0, 0, 1};
  const double from_m = flight.camera().position_m.z;
  for (int i = 0; i < 30; ++i) flight.step(up, 1.0 / 30, hill);
  CHECK(flight.camera().position_m.z > from_m + 20.0);
}

TEST_CASE("flight: looking straight up, a move to the right turns the view to the right") {
  Flight flight(CameraState{.pitch_rad = kPi / 2});
  const CameraAxes before = camera_axes(flight.camera());
  FlyInput input;
  input.look_px = {80, 0};  // 0.2 rad
  flight.step(input, 10.0, ground_at_0);
  const CameraAxes after = camera_axes(flight.camera());
  const glm::dvec3 moved = after.forward - before.forward;
  CHECK(std::abs(glm::dot(moved, before.right) - std::sin(0.2)) < 1e-6);
  CHECK(std::abs(glm::dot(moved, before.up)) < 1e-6);
}

TEST_CASE("flight: over the zenith and on, the picture turns evenly and without a jump") {
  Flight flight(CameraState{.yaw_rad = 0.4, .pitch_rad = 1.2});
  FlyInput input;
  input.look_rate = {0.05, -1};
  CameraAxes last = camera_axes(flight.camera());
  for (int i = 0; i < 200; ++i) {
    flight.step(input, 0.01, ground_at_0);
    const CameraAxes axes = camera_axes(flight.camera());
    const double angle = std::acos(std::min(1.0, glm::dot(last.forward, axes.forward)));
    CHECK(std::abs(angle - 0.016) < 0.001);  // 1.6 rad/s for a hundredth of a second
    CHECK(glm::distance(last.right, axes.right) < 0.01);
    last = axes;
  }
}

TEST_CASE("flight: levelling out takes the roll away and leaves the direction of view") {
  Flight flight(CameraState{.yaw_rad = 0.4, .pitch_rad = 0.3, .roll_rad = 2.5});
  const glm::dvec3 forward = camera_axes(flight.camera()).forward;
  flight.level_out();
  for (int i = 0; i < 120; ++i) flight.step({}, 1.0 / 30, ground_at_0);
  CHECK(std::abs(flight.camera().roll_rad) < 1e-5);
  CHECK(glm::distance(camera_axes(flight.camera()).forward, forward) < 1e-9);
}

TEST_CASE("flight: the wheel's speeds go from walking to orbital and no further") {
  Flight flight(CameraState{});
  FlyInput up, down;
  up.wheel = 200;
  down.wheel = -400;
  flight.step(up, 0.0, ground_at_0);
  CHECK(flight.speed_m_per_s() == kOrbitalSpeed);
  flight.step(down, 0.0, ground_at_0);
  CHECK(flight.speed_m_per_s() == kWalkingSpeed);
}
