#include "tools/fly/flight.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "engine/camera.h"

namespace nephele::fly {
namespace {

constexpr double kSpringPerS = 8.0;  // of the velocity: 90 % after half a second
constexpr double kLookPerS = 30.0;   // of the mouse: 90 % after 77 ms
constexpr double kRollPerS = 6.0;    // of the rate of roll
constexpr double kRollRate = 1.2;    // rad/s
constexpr double kStickRate = 1.6;   // rad/s
constexpr double kLevelPerS = 5.0;   // of the roll that is left
constexpr double kRadiansPerPixel = 0.0025;
constexpr double kNotch = 1.25;  // of the wheel: factor on the speed
constexpr double kFaster = 5.0, kSlower = 0.2;

// A value that follows another as a critically damped spring does, and its integral, over a time in which the goal
// stays. Exact, so that two steps of half the time lead to the same place.
struct Spring {
  glm::dvec3 value, rate, integral;
};
Spring follow(const glm::dvec3& value, const glm::dvec3& rate, const glm::dvec3& goal, double w, double t) {
  const double e = std::exp(-w * t);
  const glm::dvec3 a = value - goal, b = rate + w * a;
  return {goal + (a + b * t) * e, (rate - b * (w * t)) * e,
          goal * t + a * ((1.0 - e) / w) + b * ((1.0 - e * (1.0 + w * t)) / (w * w))};
}

}  // namespace

glm::dquat orientation_of(const CameraState& camera) {
  const CameraAxes axes = camera_axes(camera);
  return glm::normalize(glm::quat_cast(glm::dmat3(axes.right, axes.forward, axes.up)));
}

void set_orientation(CameraState& camera, const glm::dquat& orientation) {
  const glm::dmat3 axes = glm::mat3_cast(orientation);
  const glm::dvec3 &right = axes[0], &forward = axes[1], &up = axes[2];
  const double horizontal = std::hypot(forward.x, forward.y);
  camera.pitch_rad = std::atan2(forward.z, horizontal);
  if (horizontal < 1e-9) {  // straight up or down: all of the turn about the view is yaw
    camera.yaw_rad = std::atan2(-right.y, right.x);
    camera.roll_rad = 0.0;
    return;
  }
  camera.yaw_rad = std::atan2(forward.x, forward.y);
  const glm::dvec3 level_right(std::cos(camera.yaw_rad), -std::sin(camera.yaw_rad), 0.0);
  camera.roll_rad = std::atan2(glm::dot(up, level_right), glm::dot(right, level_right));
}

Flight::Flight(const CameraState& camera) : camera_(camera), orientation_(orientation_of(camera)) {}

CameraState Flight::camera() const {
  CameraState camera = camera_;
  set_orientation(camera, orientation_);
  return camera;
}

void Flight::jump_to(const CameraState& camera) {
  camera_ = camera;
  orientation_ = orientation_of(camera);
  velocity_m_per_s_ = acceleration_m_per_s2_ = glm::dvec3(0.0);
  look_left_rad_ = glm::dvec2(0.0);
  roll_rate_rad_per_s_ = 0.0;
  levelling_ = false;
}

void Flight::step(const FlyInput& input, double dt_s, const Ground& ground) {
  if (input.wheel != 0.0)
    speed_m_per_s_ = std::clamp(speed_m_per_s_ * std::pow(kNotch, input.wheel), kWalkingSpeed, kOrbitalSpeed);
  look(input, dt_s);
  move(input, dt_s);
  stay_above(ground);
}

// Sideways turns go about the world's vertical, which keeps the horizon as it lies, and about the camera's own where
// the view is near that vertical: there the other would only spin the picture. The sign is the camera's: what is
// right on the picture stays right upside down.
void Flight::turn(double right_rad, double up_rad, double roll_rad) {
  const glm::dmat3 axes = glm::mat3_cast(orientation_);
  const double upright = axes[2].z;
  const double own = 1.0 - glm::smoothstep(0.1, 0.35, std::abs(upright));
  const glm::dvec3 vertical(0.0, 0.0, upright < 0.0 ? -1.0 : 1.0);
  const glm::dvec3 axis = glm::normalize(glm::mix(vertical, axes[2], own));
  orientation_ = glm::angleAxis(-right_rad, axis) * orientation_ * glm::angleAxis(up_rad, glm::dvec3(1, 0, 0)) *
                 glm::angleAxis(roll_rad, glm::dvec3(0, 1, 0));
  orientation_ = glm::normalize(orientation_);
}

void Flight::look(const FlyInput& input, double dt_s) {
  look_left_rad_ += glm::dvec2(input.look_px.x, -input.look_px.y) * kRadiansPerPixel;
  const glm::dvec2 now = look_left_rad_ * (1.0 - std::exp(-kLookPerS * dt_s));
  look_left_rad_ -= now;
  const double rate = input.roll * kRollRate;
  const double ease = std::exp(-kRollPerS * dt_s);
  const double roll = rate * dt_s + (roll_rate_rad_per_s_ - rate) * (1.0 - ease) / kRollPerS;
  roll_rate_rad_per_s_ = rate + (roll_rate_rad_per_s_ - rate) * ease;
  const glm::dvec2 stick = glm::dvec2(input.look_rate.x, -input.look_rate.y) * (kStickRate * dt_s);
  turn(now.x + stick.x, now.y + stick.y, roll);
  if (input.roll != 0.0) levelling_ = false;
  if (!levelling_) return;
  const double left = camera().roll_rad;
  turn(0.0, 0.0, -left * (1.0 - std::exp(-kLevelPerS * dt_s)));
  levelling_ = std::abs(left) > 1e-6;
}

void Flight::move(const FlyInput& input, double dt_s) {
  const glm::dmat3 axes = glm::mat3_cast(orientation_);
  glm::dvec3 wanted = axes[0] * input.move.x + axes[1] * input.move.y + glm::dvec3(0.0, 0.0, input.move.z);
  if (const double length = glm::length(wanted); length > 1.0) wanted /= length;
  const double factor = (input.faster ? kFaster : 1.0) * (input.slower ? kSlower : 1.0);
  const Spring moved = follow(velocity_m_per_s_, acceleration_m_per_s2_,
                              wanted * std::clamp(speed_m_per_s_ * factor, 0.0, kOrbitalSpeed), kSpringPerS, dt_s);
  camera_.position_m += moved.integral;
  velocity_m_per_s_ = moved.value;
  acceleration_m_per_s2_ = moved.rate;
}

void Flight::stay_above(const Ground& ground) {
  glm::dvec3& p = camera_.position_m;
  for (int i = 0; i < 2; ++i) p[i] = std::clamp(p[i], -kFarthestM, kFarthestM);
  const double lowest = std::clamp(ground(glm::dvec2(p)) + kEyeHeightM, 0.0, kHighestM);
  if (p.z > lowest && p.z < kHighestM) return;
  const bool below = p.z <= lowest;
  p.z = below ? lowest : kHighestM;
  for (glm::dvec3* v : {&velocity_m_per_s_, &acceleration_m_per_s2_})
    v->z = below ? std::max(0.0, v->z) : std::min(0.0, v->z);
}

}  // namespace nephele::fly
