#include "engine/camera.h"

#include <cmath>

#include "engine/check.h"

namespace nephele {

glm::dvec3 direction_from_angles(double azimuth_rad, double elevation_rad) {
  const double horizontal = std::cos(elevation_rad);
  return {std::sin(azimuth_rad) * horizontal, std::cos(azimuth_rad) * horizontal, std::sin(elevation_rad)};
}

CameraAxes camera_axes(const CameraState& camera) {
  const glm::dvec3 forward = direction_from_angles(camera.yaw_rad, camera.pitch_rad);
  // Level right and the matching up from the angles themselves, so that looking straight up or down is no special case.
  const glm::dvec3 level_right{std::cos(camera.yaw_rad), -std::sin(camera.yaw_rad), 0.0};
  const glm::dvec3 level_up = glm::cross(level_right, forward);
  const double c = std::cos(camera.roll_rad), s = std::sin(camera.roll_rad);
  return {level_right * c - level_up * s, level_up * c + level_right * s, forward};
}

CameraMatrices camera_matrices(const CameraState& camera, double aspect_ratio) {
  NEPHELE_CHECK(aspect_ratio > 0.0 && camera.vertical_fov_rad > 0.0, "aspect ", aspect_ratio, ", field of view ",
                camera.vertical_fov_rad);
  const CameraAxes axes = camera_axes(camera);
  const double y_scale = 1.0 / std::tan(0.5 * camera.vertical_fov_rad);
  const double x_scale = y_scale / aspect_ratio;

  // With (x, y, z) along (right, down, forward): clip = (x_scale x, y_scale y, z - near w, z).
  const glm::dvec3 down = -axes.up;
  const glm::dmat4 view_from_render = glm::transpose(glm::dmat4(glm::dvec4(axes.right, 0.0), glm::dvec4(down, 0.0),
                                                                glm::dvec4(axes.forward, 0.0), glm::dvec4(0, 0, 0, 1)));
  const glm::dmat4 clip_from_view(x_scale, 0, 0, 0,  //
                                  0, y_scale, 0, 0,  //
                                  0, 0, 1, 1,        //
                                  0, 0, -kNearPlaneM, 0);
  const glm::dmat4 view_from_clip(1 / x_scale, 0, 0, 0,       //
                                  0, 1 / y_scale, 0, 0,       //
                                  0, 0, 0, -1 / kNearPlaneM,  //
                                  0, 0, 1, 1 / kNearPlaneM);
  return {glm::mat4(clip_from_view * view_from_render), glm::mat4(glm::transpose(view_from_render) * view_from_clip)};
}

}  // namespace nephele
