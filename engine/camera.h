// From camera angles to directions and matrices, in double precision until the last step. *Render space* has the
// world's axes and its origin at the camera, so no matrix here holds a position.
#pragma once

#include <glm/glm.hpp>

#include "engine/scene.h"

namespace nephele {

// The camera's axes in world (and render) space: orthonormal, right x forward = up.
struct CameraAxes {
  glm::dvec3 right, up, forward;
};
CameraAxes camera_axes(const CameraState& camera);

// Vulkan clip space: x right, y down, depth 0 at the near plane and 1 at infinity.
struct CameraMatrices {
  glm::mat4 clip_from_render;
  glm::mat4 render_from_clip;  // M * (ndc.x, ndc.y, 1, 1) = (direction, 0): the direction of a pixel, not normalised
};
inline constexpr double kNearPlaneM = 0.01;
CameraMatrices camera_matrices(const CameraState& camera, double aspect_ratio);

// Unit vector of an azimuth (clockwise from north) and an elevation (from the horizon): towards the sun.
glm::dvec3 direction_from_angles(double azimuth_rad, double elevation_rad);

}  // namespace nephele
