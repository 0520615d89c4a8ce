// Angles that a file of decimal degrees gives back bit for bit. A viewer that shows only such angles can write down
// what it shows: a billionth of a degree is 0.1 mm at 6 000 km.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/scene.h"

namespace nephele::fly {

inline constexpr double kAngleUnit = std::numbers::pi / 180.0;  // as the readers of scenes and paths multiply by it
inline constexpr double kStepsPerDegree = 1e9;

inline double decimal_degrees(double angle_rad) {
  return std::round(angle_rad / kAngleUnit * kStepsPerDegree) / kStepsPerDegree;
}
inline double decimal_angle(double angle_rad) { return decimal_degrees(angle_rad) * kAngleUnit; }

inline CameraState with_decimal_angles(CameraState camera) {
  camera.yaw_rad = decimal_angle(camera.yaw_rad);
  camera.pitch_rad = std::clamp(decimal_degrees(camera.pitch_rad), -90.0, 90.0) * kAngleUnit;
  camera.roll_rad = decimal_angle(camera.roll_rad);
  return camera;
}

}  // namespace nephele::fly
