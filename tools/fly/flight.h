// A camera with six degrees of freedom that moves smoothly, as fast as the speed that the wheel has set, whatever the
// frame rate: every motion is the exact solution of its spring over the time that has passed.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "engine/scene.h"
#include "tools/fly/fly_input.h"

namespace nephele::fly {

inline constexpr double kWalkingSpeed = 1.4, kOrbitalSpeed = 7800.0;  // m/s
inline constexpr double kEyeHeightM = 2.0;                            // the least height above the ground
inline constexpr double kHighestM = 1e6, kFarthestM = 1e9;            // of a camera, as a scene file has it

// The camera's axes as a rotation of the world's (x right, y forward, z up), and back. The angles of a camera that
// looks straight up or down have roll 0.
glm::dquat orientation_of(const CameraState& camera);
void set_orientation(CameraState& camera, const glm::dquat& orientation);

class Flight {
 public:
  // Altitude of the ground at a place (east, north).
  using Ground = std::function<double(const glm::dvec2&)>;

  explicit Flight(const CameraState& camera);

  // dt_s >= 0. The camera stays kEyeHeightM above the ground.
  void step(const FlyInput& input, double dt_s, const Ground& ground);
  // At rest there, with the field of view that it has.
  void jump_to(const CameraState& camera);
  // Turns the right side level within half a second or so.
  void level_out() { levelling_ = true; }

  CameraState camera() const;
  double speed_m_per_s() const { return speed_m_per_s_; }  // that full deflection leads to
  glm::dvec3 velocity_m_per_s() const { return velocity_m_per_s_; }

 private:
  void look(const FlyInput& input, double dt_s);
  void turn(double right_rad, double up_rad, double roll_rad);
  void move(const FlyInput& input, double dt_s);
  void stay_above(const Ground& ground);

  CameraState camera_;  // all but the orientation
  glm::dquat orientation_;
  glm::dvec3 velocity_m_per_s_{0.0}, acceleration_m_per_s2_{0.0};
  double speed_m_per_s_ = 50.0;
  glm::dvec2 look_left_rad_{0.0};  // right and up: what the mouse has asked for and is still to be turned
  double roll_rate_rad_per_s_ = 0.0;
  bool levelling_ = false;
};

}  // namespace nephele::fly
