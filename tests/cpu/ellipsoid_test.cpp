// Rays against ellipsoids, compared with the quadratic formula in doubles; rotations and the octahedral map.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "shared/ellipsoid.h"
#include "tests/support/shapes.h"

using namespace nephele::shared;
using glm::dvec3;

namespace {

struct TrueHit {
  bool meets = false;
  double near = 0, far = 0;
};

TrueHit quadratic(dvec3 origin, dvec3 direction, dvec3 center, const EllipsoidShape& shape) {
  const glm::dmat3 inverse = nephele::test::unit_matrix_of(shape);
  const auto unit = [&](dvec3 v) { return inverse * v; };
  const dvec3 o = unit(origin - center), d = unit(direction);
  const double a = dot(d, d), b = dot(o, d), c = dot(o, o) - 1, root = b * b - a * c;
  if (root < 0) return {};
  return {true, (-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a};
}

vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return normalize(vec3(normal(random), normal(random), normal(random)));
}

}  // namespace

TEST_CASE("ellipsoid chords agree with the quadratic formula in doubles at any distance") {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (const float distance_m : {0.0f, 300.0f, 1e4f, 1e6f}) {
    CAPTURE(distance_m);
    // The centre itself is only known to a float's rounding, times the rotation and scaling: a few ulps.
    const double tolerance_m = 1e-3 + 6e-7 * distance_m;
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
      const vec3 radius(20 + 200 * unit(random), 20 + 200 * unit(random), 10 + 100 * unit(random));
      const vec3 center = distance_m * random_direction(random);
      const vec3 aim =
          center + 0.95f * min(radius.x, min(radius.y, radius.z)) * unit(random) * random_direction(random);
      const vec3 direction = distance_m > 0 ? normalize(aim) : random_direction(random);
      const EllipsoidShape shape = nephele::test::shape_along(nephele::test::random_axes(random), dvec3(radius));
      EllipsoidHit hit;
      const bool meets = intersect_ellipsoid(vec3(0.0f), direction, center, shape, hit);
      const TrueHit truth = quadratic(dvec3(0), dvec3(direction), dvec3(center), shape);
      // A direction is rounded too: at 1e6 m it may leave a thin ellipsoid.
      if (truth.meets != meets) {
        CHECK(distance_m >= 1e6f);
        continue;
      }
      if (!meets) continue;
      ++hits;
      const double half = 0.5 * (truth.far - truth.near);
      CHECK(std::abs(hit.mid_m - 0.5 * (truth.near + truth.far)) < tolerance_m);
      // The half chord loses what its square loses: grazing rays amplify the miss distance's rounding.
      CHECK(std::abs(hit.half_m * double(hit.half_m) - half * half) < 4 * tolerance_m * 320 + 1e-3 * half * half);
      CHECK(length(hit.entry) == doctest::Approx(1.0).epsilon(1e-6));
      CHECK(length(hit.exit) == doctest::Approx(1.0).epsilon(1e-6));
    }
    CHECK(hits > 1900);
  }
}

TEST_CASE("entry and exit are the ends of the chord in unit space") {
  EllipsoidHit hit;
  // Radii 10, 20, 30; yaw 90 degrees turns the long horizontal axis from north to east.
  REQUIRE(
      intersect_ellipsoid(vec3(-100, 0, 0), vec3(1, 0, 0), vec3(0.0f), upright_shape(vec3(10, 20, 30), kPi / 2), hit));
  CHECK(hit.mid_m == doctest::Approx(100));
  CHECK(hit.half_m == doctest::Approx(20));
  // Unit space is not turned: the ray still runs along x.
  CHECK(hit.entry.x == doctest::Approx(-1));
  CHECK(hit.exit.x == doctest::Approx(1));
  CHECK_FALSE(
      intersect_ellipsoid(vec3(-100, 0, 31), vec3(1, 0, 0), vec3(0.0f), upright_shape(vec3(10, 20, 30), 0.0f), hit));
  // From inside: the middle may lie behind.
  REQUIRE(intersect_ellipsoid(vec3(0, 5, 0), vec3(0, 1, 0), vec3(0.0f), upright_shape(vec3(10, 20, 30), 0.0f), hit));
  CHECK(hit.mid_m == doctest::Approx(-5));
}

TEST_CASE("local and render axes are inverse turns, clockwise from north") {
  const vec3 north_of_local = render_from_local(vec3(0, 1, 0), 0.5f);
  CHECK(north_of_local.x == doctest::Approx(std::sin(0.5)));
  CHECK(north_of_local.y == doctest::Approx(std::cos(0.5)));
  const vec3 v(1, 2, 3);
  CHECK(length(local_from_render(render_from_local(v, 1.3f), 1.3f) - v) < 1e-6f);
}

TEST_CASE("quaternions rotate, invert and survive packing") {
  // A quarter turn about z takes x to y.
  const vec4 q(0, 0, std::sqrt(0.5f), std::sqrt(0.5f));
  CHECK(length(quaternion_rotate(q, vec3(1, 0, 0)) - vec3(0, 1, 0)) < 1e-6f);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 1000; ++i) {
    const vec4 r = random_rotation(unit(random), unit(random), unit(random));
    const vec3 v = random_direction(random);
    CHECK(length(quaternion_rotate_inverse(r, quaternion_rotate(r, v)) - v) < 2e-6f);
    const vec4 packed = unpack_orientation(pack_orientation(r));
    CHECK(dot(packed, packed) == doctest::Approx(1.0));
    // Half a step of 1/127 in four components.
    CHECK(length(packed - r) < 2 * 0.5f / 127.0f);
  }
  CHECK(unpack_orientation(0u).w == 1.0f);
}

TEST_CASE("the octahedral map is a round trip, folds along its border and keeps its corners") {
  std::mt19937 random(7);
  for (int i = 0; i < 20000; ++i) {
    const vec3 v = random_direction(random);
    const vec2 uv = octahedral_encode(v);
    CHECK(min(uv.x, uv.y) >= 0.0f);
    CHECK(max(uv.x, uv.y) <= 1.0f);
    CHECK(length(octahedral_decode(uv) - v) < 1e-6f);
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {-1.0f, 1.0f}) {
      vec3 v(0.0f);
      v[axis] = sign;
      CHECK(length(octahedral_decode(octahedral_encode(v)) - v) < 1e-6f);
    }
  }
  // Both halves of a side are the same points.
  for (const float t : {0.0f, 0.1f, 0.3f, 0.5f}) {
    CHECK(length(octahedral_decode(vec2(t, 0)) - octahedral_decode(vec2(1 - t, 0))) < 1e-6f);
    CHECK(length(octahedral_decode(vec2(1, t)) - octahedral_decode(vec2(1, 1 - t))) < 1e-6f);
  }
}

TEST_CASE("an ellipsoid's shape: determinant, inverse, extents and bounds, tilted, flat and long") {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 500; ++i) {
    const dvec3 radius(std::exp2(10 * unit(random) - 3), std::exp2(7 * unit(random)), std::exp2(7 * unit(random)));
    const EllipsoidShape shape = nephele::test::shape_along(nephele::test::random_axes(random), radius);
    const double longest = std::max({radius.x, radius.y, radius.z}),
                 shortest = std::min({radius.x, radius.y, radius.z});
    // The shape is rounded to floats: what cancels loses the ratio of the axes.
    const double loss = 1e-6 * longest / shortest;
    CHECK(mean_radius_m(shape) == doctest::Approx(std::cbrt(radius.x * radius.y * radius.z)).epsilon(4 * loss));
    const glm::dmat3 back = glm::dmat3(unit_from_render(shape)) * nephele::test::matrix_of(shape);
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j) CHECK(std::abs(back[k][j] - (j == k ? 1.0 : 0.0)) < 20 * loss);
    CHECK(longest_axis_m(shape) == doctest::Approx(longest).epsilon(1e-5));
    CHECK(longest_axis_at_most_m(shape) >= longest * (1 - 1e-6));
    CHECK(longest_axis_at_most_m(shape) <= longest * 1.7321);
    const dvec3 direction(random_direction(random));
    CHECK(ellipsoid_extent(shape, vec3(direction)) ==
          doctest::Approx(glm::length(nephele::test::matrix_of(shape) * direction)).epsilon(1e-5));
  }
}

TEST_CASE("a yaw as quaternion, as matrix and as turned axes is the same turn") {
  for (const float yaw : {0.0f, 0.4f, 1.5f, 3.0f, -2.0f}) {
    const vec3 v(0.3f, -0.7f, 0.2f);
    CHECK(length(quaternion_rotate(yaw_rotation(yaw), v) - render_from_local(v, yaw)) < 1e-6f);
    const vec4 own = random_rotation(0.3f, 0.6f, 0.9f);
    CHECK(length(quaternion_rotate(quaternion_product(yaw_rotation(yaw), own), v) -
                 render_from_local(quaternion_rotate(own, v), yaw)) < 1e-6f);
    // The shape's first axis is where yaw turns east.
    const EllipsoidShape shape = upright_shape(vec3(50, 20, 30), yaw);
    const vec3 axis = render_from_local(vec3(1, 0, 0), yaw);
    CHECK(length(shape_matrix(shape) * axis - 50.0f * axis) < 1e-4f);
  }
}
