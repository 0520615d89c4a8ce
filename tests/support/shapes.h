// Ellipsoids for tests, in doubles and without the shared code that is tested.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <random>

#include "shared/ellipsoid.h"

namespace nephele::test {

inline glm::dmat3 matrix_of(const shared::EllipsoidShape& shape) {
  const glm::dvec3 d(shape.diagonal_m), o(shape.off_diagonal_m);
  return {d.x, o.x, o.y, o.x, d.y, o.z, o.y, o.z, d.z};
}

// From render space to unit space, by GLM's inverse.
inline glm::dmat3 unit_matrix_of(const shared::EllipsoidShape& shape) { return glm::inverse(matrix_of(shape)); }

inline shared::EllipsoidShape shape_of_matrix(const glm::dmat3& m) {
  return {glm::vec3(glm::dvec3(m[0][0], m[1][1], m[2][2])), glm::vec3(glm::dvec3(m[0][1], m[0][2], m[1][2]))};
}

// These semi-axes along the columns of a rotation.
inline shared::EllipsoidShape shape_along(const glm::dmat3& axes, const glm::dvec3& radius_m) {
  glm::dmat3 sum(0.0);
  for (int k = 0; k < 3; ++k) sum += radius_m[k] * glm::outerProduct(axes[k], axes[k]);
  return shape_of_matrix(sum);
}

// A rotation, by Gram and Schmidt from three random directions.
inline glm::dmat3 random_axes(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto direction = [&] { return glm::dvec3(normal(random), normal(random), normal(random)); };
  const glm::dvec3 x = glm::normalize(direction());
  const glm::dvec3 y = glm::normalize(glm::cross(x, direction()));
  return {x, y, glm::cross(x, y)};
}

inline shared::EllipsoidShape ball(float radius_m) { return {glm::vec3(radius_m), glm::vec3(0.0f)}; }

inline shared::EllipsoidShape scaled(const shared::EllipsoidShape& shape, float factor) {
  return {shape.diagonal_m * factor, shape.off_diagonal_m * factor};
}

// No semi-axis is shorter: 1 over the Frobenius norm of the inverse.
inline double shortest_axis_at_least_m(const shared::EllipsoidShape& shape) {
  const glm::dmat3 inverse = unit_matrix_of(shape);
  return 1.0 / std::sqrt(glm::dot(inverse[0], inverse[0]) + glm::dot(inverse[1], inverse[1]) +
                         glm::dot(inverse[2], inverse[2]));
}

}  // namespace nephele::test
