// Grid space and render space against double-precision trigonometry, and lattices seen from different origins.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "shared/noise.h"
#include "shared/world.h"

using namespace nephele::shared;

namespace {

constexpr double kR = static_cast<double>(kPlanetRadiusM);

dvec3 render_oracle(dvec3 p, dvec3 camera) {
  const dvec2 offset(p.x - camera.x, p.y - camera.y);
  const double s = std::hypot(offset.x, offset.y), phi = s / kR;
  const dvec2 along = s > 0 ? offset / s : dvec2(0);
  return {along.x * (kR + p.z) * std::sin(phi), along.y * (kR + p.z) * std::sin(phi),
          (kR + p.z) * std::cos(phi) - kR - camera.z};
}

double altitude_oracle(dvec3 p_render, double camera_altitude) {
  const double z = kR + camera_altitude + p_render.z;
  return std::sqrt(p_render.x * p_render.x + p_render.y * p_render.y + z * z) - kR;
}

}  // namespace

TEST_CASE("grid to render space follows the sphere, and back") {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  double worst = 0, worst_altitude = 0, worst_back = 0;
  for (int i = 0; i < 20000; ++i) {
    const float range = std::pow(10.0f, 2.5f + 1.5f * unit(random) + 1.4f);  // 250 m to 250 km
    const vec3 camera(47000.0f * unit(random), 47000.0f * unit(random), 10000.0f + 9999.0f * unit(random));
    const vec3 p(camera.x + range * unit(random), camera.y + range * unit(random), 10000.0f + 10000.0f * unit(random));
    const vec3 render = render_from_grid(p, camera);
    const dvec3 exact = render_oracle(dvec3(p), dvec3(camera));
    worst = std::fmax(worst, length(dvec3(render) - exact) / (1.0 + 1e-6 * length(exact)));
    worst_altitude = std::fmax(worst_altitude, std::fabs(altitude_oracle(dvec3(render), static_cast<double>(camera.z)) -
                                                         static_cast<double>(p.z)));
    worst_altitude = std::fmax(worst_altitude,
                               std::fabs(static_cast<double>(altitude_m(render, camera.z)) - static_cast<double>(p.z)));
    worst_back = std::fmax(worst_back, static_cast<double>(length(grid_from_render(render, camera) - p)));
  }
  // Coordinates of 300 km are spaced by 1/32 m; altitudes of 20 km by 1/512 m, and they see a slope of up to 1/25.
  CHECK(worst < 0.03);
  CHECK(worst_altitude < 0.01);
  CHECK(worst_back < 0.1);
}

TEST_CASE("the camera and what stands above it are not bent") {
  const vec3 camera(123.0f, -456.0f, 789.0f);
  CHECK(render_from_grid(camera, camera) == vec3(0.0f));
  CHECK(render_from_grid(vec3(123.0f, -456.0f, 5789.0f), camera) == vec3(0.0f, 0.0f, 5000.0f));
  CHECK(altitude_m(vec3(0.0f), 789.0f) == doctest::Approx(789.0).epsilon(1e-6));
}

TEST_CASE("a place is split into origin and rest without loss") {
  for (const double x : {0.0, 1.0, -1.0, 47103.9, 47104.1, -47104.1, 1e7, -1e7, 1e7 + 0.25, 94208.0 * 3e9}) {
    CAPTURE(x);
    const GridPlace place = grid_place({x, -x, 1500.0});
    CHECK(std::fabs(place.grid_m.x) <= 0.5f * kOriginUnitM);
    CHECK(std::fabs(place.grid_m.y) <= 0.5f * kOriginUnitM);
    CHECK(place.grid_m.z == 1500.0f);
    const double units = (x - static_cast<double>(place.grid_m.x)) / static_cast<double>(kOriginUnitM);
    CHECK(std::fabs(units - std::round(units)) < 1e-6);
    CHECK(place.origin_index.x ==
          static_cast<int>(static_cast<std::uint32_t>(static_cast<std::int64_t>(std::llround(units)))));
  }
}

TEST_CASE("a world place has the same lattice cell and noise from every origin") {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  for (const uint n : {7u, 39u, 105u, 208u, 512u}) {
    for (int i = 0; i < 500; ++i) {
      // Multiples of 1/16 m within 100 km are exact in both frames.
      const vec2 p(std::round(40000.0f * unit(random) * 16.0f) / 16.0f,
                   std::round(40000.0f * unit(random) * 16.0f) / 16.0f);
      const ivec2 origin(-7, 105), shift(1, -1);
      const vec2 p_shifted = p - vec2(shift) * kOriginUnitM;
      const vec2 a = lattice_position(p, n), b = lattice_position(p_shifted, n);
      const float noise_a = fbm2(a, lattice_base(origin, n), 1u, 3),
                  noise_b = fbm2(b, lattice_base(origin + shift, n), 1u, 3);
      // 140 km in cells of 184 m is 760: spaced by 6e-5 of a cell, four times that in the third octave, slope up to 3.
      CHECK(std::fabs(noise_a - noise_b) < 1e-3f);
      const vec2 place_in_cell = a - floor(a);
      if (min(min(place_in_cell.x, place_in_cell.y), 1.0f - max(place_in_cell.x, place_in_cell.y)) < 1e-3f) continue;
      const uvec2 cell_a = lattice_base(origin, n) + uvec2(ivec2(floor(a)));
      const uvec2 cell_b = lattice_base(origin + shift, n) + uvec2(ivec2(floor(b)));
      CHECK(cell_a == cell_b);
      CHECK(hash_uvec2(cell_a, 9u) == hash_uvec2(cell_b, 9u));
    }
  }
}

TEST_CASE("the finest cell always divides the origin's unit, doubled seven times and paired") {
  for (const double wanted : {1.0, 50.0, 120.0, 184.0, 250.0, 1e6}) {
    const double cells = static_cast<double>(kOriginUnitM) / static_cast<double>(usable_inner_cell_m(wanted));
    CHECK(std::fabs(cells / 256.0 - std::round(cells / 256.0)) < 1e-6);
    CHECK(cells >= 256.0);
  }
  CHECK(usable_inner_cell_m(184.0) == 184.0f);
}
