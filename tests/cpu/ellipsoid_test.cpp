// Rays against ellipsoids, compared with the quadratic formula in doubles; rotations and the octahedral map.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "shared/ellipsoid.h"

using namespace nephele::shared;
using glm::dvec3;

namespace {

struct TrueHit {
  bool meets = false;
  double near = 0, far = 0;
};

// Yaw clockwise from north: local y points at (sin yaw, cos yaw).
TrueHit quadratic(dvec3 origin, dvec3 direction, dvec3 center, dvec3 radius, double yaw) {
  const dvec3 east(std::cos(yaw), -std::sin(yaw), 0), north(std::sin(yaw), std::cos(yaw), 0);
  const auto unit = [&](dvec3 v) { return dvec3(dot(v, east), dot(v, north), v.z) / radius; };
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
      const float yaw = 6.2831853f * unit(random);
      EllipsoidHit hit;
      const bool meets = intersect_ellipsoid(vec3(0.0f), direction, center, radius, yaw, hit);
      const TrueHit truth = quadratic(dvec3(0), dvec3(direction), dvec3(center), dvec3(radius), yaw);
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
  REQUIRE(intersect_ellipsoid(vec3(-100, 0, 0), vec3(1, 0, 0), vec3(0.0f), vec3(10, 20, 30), kPi / 2, hit));
  CHECK(hit.mid_m == doctest::Approx(100));
  CHECK(hit.half_m == doctest::Approx(20));
  CHECK(hit.entry.y == doctest::Approx(-1));
  CHECK(hit.exit.y == doctest::Approx(1));
  CHECK_FALSE(intersect_ellipsoid(vec3(-100, 0, 31), vec3(1, 0, 0), vec3(0.0f), vec3(10, 20, 30), 0.0f, hit));
  // From inside: the middle may lie behind.
  REQUIRE(intersect_ellipsoid(vec3(0, 5, 0), vec3(0, 1, 0), vec3(0.0f), vec3(10, 20, 30), 0.0f, hit));
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
