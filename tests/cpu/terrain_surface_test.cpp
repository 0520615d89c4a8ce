// Terrain on the CPU: the surface that a map stands for, and the path tracer's rays to it on shapes in closed form.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "engine/terrain_grid.h"
#include "lut/oracles.h"
#include "tests/support/truth_scene.h"
#include "tools/path_tracer/terrain_surface.h"

using namespace nephele;
using namespace nephele::test;
using glm::dvec2;
using glm::dvec3;
using glm::vec3;

namespace {

constexpr double kPlanetM = 6360000.0;

// 40 x 40 texels of 500 m about the origin; heights rise to the east from column to column.
Terrain wedge(float highest_m, bool level) {
  Terrain terrain{.width = 40,
                  .height = 40,
                  .origin_m = dvec2(-10000.0),
                  .extent_m = dvec2(20000.0),
                  .lowest_m = level ? highest_m : 0.0f,
                  .highest_m = highest_m};
  for (int row = 0; row < 40; ++row)
    for (int column = 0; column < 40; ++column)
      terrain.texels.push_back(static_cast<std::uint16_t>(std::lround(column * 65535.0 / 39.0)));
  return terrain;
}

}  // namespace

TEST_CASE("terrain: heights stand at the middles of texels, rows from the north, and fade to nothing around the map") {
  Terrain terrain{.width = 3,
                  .height = 2,
                  .texels = {0, 65535, 32768, 65535, 13107, 0},
                  .origin_m = {1000.0, -2000.0},
                  .extent_m = {48000.0, 32000.0},
                  .lowest_m = 100.0f,
                  .highest_m = 1100.0f};
  CHECK(terrain_fade_m(terrain) == 2000.0);
  const TerrainGrid grid = terrain_grid(terrain);
  CHECK(grid.spacing_m == dvec2(16000.0));
  const glm::ivec2 first(glm::round((terrain.origin_m + 8000.0 - grid.corner_m) / grid.spacing_m));
  const auto at = [&](int i, int j) { return double{grid.at(first + glm::ivec2(i, j))}; };
  const double half_step = 1000.0 / 65535.0;      // of 16 bits, and a float's rounding far below it
  CHECK(std::abs(at(0, 1) - 100.0) < half_step);  // north-west: the first texel
  CHECK(std::abs(at(1, 1) - 1100.0) < half_step);
  CHECK(std::abs(at(2, 1) - 600.0) < half_step);
  CHECK(std::abs(at(0, 0) - 1100.0) < half_step);  // south-west
  CHECK(std::abs(at(1, 0) - 300.0) < half_step);
  // All around: 0, as one texel out is 8 km from the map, past the fade.
  for (int x = 0; x < grid.vertices.x; ++x) {
    CHECK(grid.at({x, 0}) == 0.0f);
    CHECK(grid.at({x, grid.vertices.y - 1}) == 0.0f);
  }
  // Texels of 200 m: 1 km outside, halfway through the fade, half the height is left.
  const TerrainGrid fine = terrain_grid([&] {
    Terrain t{.width = 100, .height = 100, .extent_m = dvec2(20000.0), .lowest_m = 800.0f, .highest_m = 800.0f};
    t.texels.assign(10000, 0);
    return t;
  }());
  const glm::ivec2 middle(glm::round((dvec2(-1000.0, 10100.0) - fine.corner_m) / fine.spacing_m - dvec2(0.5, 0.0)));
  const double x_m = fine.corner_m.x + middle.x * fine.spacing_m.x, away = -x_m / 2000.0;
  CHECK(std::abs(fine.at(middle) - 800.0 * (1 - away * away * (3 - 2 * away))) < 1e-3);
  CHECK(terrain_fade_m(Terrain{.extent_m = {800.0, 4000.0}}) == 100.0);
}

TEST_CASE("path tracer: rays meet a plateau as they meet a larger planet") {
  const Terrain terrain = wedge(500.0f, true);
  for (const dvec2 far_m : {dvec2(0.0), dvec2(1e7, -1e7 + 1.0 / 3.0)}) {
    Terrain there = terrain;
    there.origin_m += far_m;
    const truth::TerrainSurface surface(there, dvec3(far_m, 1500.0));
    UniformNumbers uniform(31);
    for (int i = 0; i < 200; ++i) {
      const double down = 0.12 + 0.8 * uniform(), angle = 6.283185307 * uniform(), across = std::sqrt(1 - down * down);
      const dvec3 direction(across * std::cos(angle), across * std::sin(angle), -down);
      const double r = kPlanetM + 1500.0, top = kPlanetM + 500.0;
      const double expected_m = r * down - std::sqrt(r * r * down * down - (r * r - top * top));
      CHECK(std::abs(surface.hit_m(dvec3(0.0), direction) - expected_m) < 0.01);  // heights are floats
      const auto land = surface.land(expected_m * direction);
      const dvec3 up = glm::normalize(expected_m * direction + dvec3(0, 0, r));
      CHECK(glm::length(land.normal - up) < 1e-9);
      CHECK(std::abs(land.altitude_m - 500.0) < 1e-3);
      CHECK(land.slope < 1e-6);
    }
    CHECK(std::isinf(surface.hit_m(dvec3(0.0), dvec3(0.0, 1.0, 0.0))));
    CHECK(std::isinf(surface.hit_m(dvec3(0.0), dvec3(0.0, 0.0, 1.0))));
  }
}

TEST_CASE("path tracer: rays meet a wedge where the slope stands") {
  const double highest_m = 3000.0, per_m = highest_m / (39 * 500.0);  // from the first column's middle to the last's
  const truth::TerrainSurface surface(wedge(static_cast<float>(highest_m), false), dvec3(-4000.0, 0.0, 1800.0));
  UniformNumbers uniform(32);
  for (int i = 0; i < 200; ++i) {
    // Up and down, east within 60 degrees: towards the slope, well within the map.
    const double elevation = -0.5 + 0.62 * uniform(), angle = 2.0 * uniform() - 1.0;
    const dvec3 direction(std::cos(elevation) * std::cos(angle), std::cos(elevation) * std::sin(angle),
                          std::sin(elevation));
    const auto over_m = [&](double t) {
      const dvec3 p = t * direction;
      const double across = std::hypot(p.x, p.y), down = p.z + kPlanetM + 1800.0;
      const double east_m = -4000.0 + p.x / across * kPlanetM * std::atan2(across, down);
      return std::hypot(across, down) - kPlanetM - per_m * (east_m + 9750.0);
    };
    double low = 1.0, high = 1.0;
    while (over_m(high) > 0.0 && high < 12000.0) high += 1.0;
    if (high >= 12000.0) continue;  // past the map's end
    for (int k = 0; k < 60; ++k) (over_m(0.5 * (low + high)) > 0.0 ? low : high) = 0.5 * (low + high);
    // 16 bits make steps of 5 cm, met at the angle between ray and slope.
    const double facing = per_m * direction.x - direction.z;
    CHECK(std::abs(surface.hit_m(dvec3(0.0), direction) - high) < 0.1 / std::max(facing, 0.02) + 0.05);
  }
  const auto land = surface.land(dvec3(0.0));
  CHECK(glm::length(land.normal - glm::normalize(dvec3(-per_m, 0.0, 1.0))) < 1e-3);
  CHECK(std::abs(land.slope - per_m) < 1e-3);
}

TEST_CASE("path tracer: a plateau in even light is as bright as its albedo, and a wall stands before the sun") {
  Scene scene = truth_scene();
  scene.sun.irradiance = vec3(0.0f);
  scene.terrain = wedge(500.0f, true);
  scene.camera.position_m = {0.0, 0.0, 900.0};
  {
    const TruthScene t(scene, {}, vec3(1.0f));
    const vec3 direction = glm::normalize(vec3(0.3f, 1.0f, -0.4f));
    MeanAndError light;
    for (int i = 0; i < 400; ++i) {
      truth::Random random(33, 0, i);
      light.add(t.tracer.camera_ray(direction, 0.001f, random).radiance.g);
    }
    const float distance_m = t.surroundings.ground_m(vec3(0.0f), direction);
    CHECK(std::abs(distance_m - 400.0 / 0.4 * std::sqrt(1.25)) < 1.0);  // a plain's, but for a curvature of 8 cm
    CHECK(std::abs(light.mean() - t.surroundings.seen_ground_albedo(direction, distance_m, 0.001f).g) < 1e-5);
  }
  // One column of texels stands 800 m high; the sun is in the east.
  for (std::size_t i = 0; i < scene.terrain->texels.size(); ++i) scene.terrain->texels[i] = i % 40 == 30 ? 65535 : 0;
  scene.terrain->lowest_m = 0.0f;
  scene.terrain->highest_m = 800.0f;
  scene.sun = {.azimuth_rad = 1.5707963, .elevation_rad = 0.3, .irradiance = vec3(1.0f)};
  const TruthScene t(scene, {}, vec3(0.0f));
  // The crest is at 5 250 m east; its shadow on the plain ends 800 / tan 0.3 = 2 586 m before it, the half column of a
  // slope that is steeper than the sun's rays apart.
  const auto in_sight = [&](float east_m) {
    return t.surroundings.sun_in_sight({east_m, 0.0f, -898.0f}, glm::vec2(0.0f));
  };
  CHECK(in_sight(5250.0f - 2700.0f));
  CHECK_FALSE(in_sight(5250.0f - 2480.0f));
  CHECK_FALSE(in_sight(5250.0f - 700.0f));
  CHECK(in_sight(6500.0f));
}
