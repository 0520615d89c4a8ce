#include "engine/camera.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace nephele;

namespace {

constexpr double kPi = std::numbers::pi;

double distance(glm::dvec3 a, glm::dvec3 b) { return glm::length(a - b); }

// Where a direction lands on the image, in normalised device coordinates.
glm::dvec2 project(const CameraMatrices& matrices, glm::dvec3 direction) {
  const glm::dvec4 clip = glm::dmat4(matrices.clip_from_render) * glm::dvec4(direction * 1000.0, 1.0);
  return glm::dvec2(clip) / clip.w;
}

}  // namespace

TEST_CASE("camera: the compass, turning clockwise seen from above") {
  CHECK(distance(direction_from_angles(0, 0), {0, 1, 0}) < 1e-15);             // north
  CHECK(distance(direction_from_angles(kPi / 2, 0), {1, 0, 0}) < 1e-15);       // east
  CHECK(distance(direction_from_angles(kPi, 0), {0, -1, 0}) < 1e-15);          // south
  CHECK(distance(direction_from_angles(3 * kPi / 2, 0), {-1, 0, 0}) < 1e-15);  // west
  CHECK(distance(direction_from_angles(1.0, kPi / 2), {0, 0, 1}) < 1e-15);     // zenith, whatever the azimuth
}

TEST_CASE("camera: level axes are the world's") {
  const CameraAxes axes = camera_axes({.yaw_rad = 0, .pitch_rad = 0});
  CHECK(distance(axes.right, {1, 0, 0}) < 1e-15);
  CHECK(distance(axes.up, {0, 0, 1}) < 1e-15);
  CHECK(distance(axes.forward, {0, 1, 0}) < 1e-15);
}

TEST_CASE("camera: pitch raises the view, roll lowers the right side") {
  const CameraAxes pitched = camera_axes({.yaw_rad = 0, .pitch_rad = 0.3});
  CHECK(pitched.forward.z == doctest::Approx(std::sin(0.3)));
  CHECK(pitched.right.z == doctest::Approx(0));
  const CameraAxes rolled = camera_axes({.yaw_rad = 0, .pitch_rad = 0, .roll_rad = 0.3});
  CHECK(rolled.right.z == doctest::Approx(-std::sin(0.3)));
  CHECK(rolled.up.x == doctest::Approx(std::sin(0.3)));
}

TEST_CASE("camera: axes are a right-handed orthonormal frame, poles included") {
  for (const double pitch : {-kPi / 2, -1.0, 0.0, 0.4, kPi / 2})
    for (const double yaw : {-7.0, 0.0, 2.0, 60.0})
      for (const double roll : {-3.0, 0.0, 0.5}) {
        CAPTURE(pitch);
        CAPTURE(yaw);
        CAPTURE(roll);
        const CameraAxes a = camera_axes({.yaw_rad = yaw, .pitch_rad = pitch, .roll_rad = roll});
        CHECK(distance(glm::cross(a.right, a.forward), a.up) < 1e-14);
        CHECK(glm::length(a.right) == doctest::Approx(1).epsilon(1e-14));
        CHECK(glm::length(a.up) == doctest::Approx(1).epsilon(1e-14));
        CHECK(std::abs(glm::dot(a.right, a.up)) < 1e-14);
      }
}

TEST_CASE("camera: the image's edges lie at half the field of view, y down") {
  const double fov = 1.0, aspect = 1.6;
  const CameraState camera{.yaw_rad = 0.7, .pitch_rad = -0.2, .roll_rad = 0.4, .vertical_fov_rad = fov};
  const CameraMatrices matrices = camera_matrices(camera, aspect);
  const CameraAxes a = camera_axes(camera);
  const double half = std::tan(fov / 2);
  // 1e-6: the matrices are floats of order 1.
  CHECK(glm::length(project(matrices, a.forward)) < 1e-6);
  CHECK(glm::length(project(matrices, a.forward + half * a.up) - glm::dvec2(0, -1)) < 1e-6);
  CHECK(glm::length(project(matrices, a.forward + aspect * half * a.right) - glm::dvec2(1, 0)) < 1e-6);
}

TEST_CASE("camera: depth is 0 at the near plane and tends to 1") {
  const CameraState camera;
  const CameraMatrices matrices = camera_matrices(camera, 1.0);
  const glm::dvec3 forward = camera_axes(camera).forward;
  const auto depth = [&](double distance_m) {
    const glm::dvec4 clip = glm::dmat4(matrices.clip_from_render) * glm::dvec4(forward * distance_m, 1.0);
    return clip.z / clip.w;
  };
  CHECK(std::abs(depth(kNearPlaneM)) < 1e-5);
  CHECK(depth(1e6) == doctest::Approx(1.0));
}

TEST_CASE("camera: a pixel's direction at depth 1 is a direction, and projects back onto the pixel") {
  for (const double fov : {0.01, 1.0, 2.9}) {
    const CameraMatrices matrices =
        camera_matrices({.yaw_rad = 2, .pitch_rad = 0.5, .roll_rad = 1, .vertical_fov_rad = fov}, 16.0 / 9);
    for (const double x : {-1.0, -0.3, 1.0})
      for (const double y : {-1.0, 0.0, 0.8}) {
        const glm::dvec4 direction = glm::dmat4(matrices.render_from_clip) * glm::dvec4(x, y, 1, 1);
        CHECK(std::abs(direction.w) < 1e-4);  // 1 / near = 100, cancelled in floats
        const glm::dvec2 back = project(matrices, glm::normalize(glm::dvec3(direction)));
        // Floats resolve directions to 6e-8; the narrow field of view magnifies that by 1 / tan(fov / 2).
        CHECK(glm::length(back - glm::dvec2(x, y)) < 1e-6 + 4e-7 / std::tan(fov / 2));
      }
  }
}
