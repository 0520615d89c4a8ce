// The weather map in the cloud field: where its texels lie, and what the clouds make of them.
#include "shared/weather.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "shared/cloud_field.h"
#include "tests/support/cloud_frame.h"

using namespace nephele::shared;
using nephele::test::cloud_field;

namespace {

constexpr uint texel(uint coverage, uint type) { return coverage | type << 8u; }

struct Map {
  ivec2 size;
  std::vector<uint> texels;  // rows from the north
  dvec2 corner_m, extent_m;

  Weather seen_from(dvec2 grid_origin_m, float coverage_beyond = 0.25f) const {
    return {weather_placement(size, corner_m, extent_m, grid_origin_m), coverage_beyond, texels.data()};
  }
};

// The same weather everywhere that clouds are looked at.
Map uniform_map(uint coverage, uint type) {
  return {{4, 4}, std::vector<uint>(16, texel(coverage, type)), dvec2(-2e6), dvec2(4e6)};
}

CloudParams params_under(const Map& map, uint seed, float coverage_beyond = 0.25f) {
  CloudField field = cloud_field();
  field.seed = seed;
  field.coverage = coverage_beyond;
  CloudParams params = cloud_params(field);
  params.weather = map.seen_from(dvec2(0), coverage_beyond);
  return params;
}

struct Sky {
  double covered = 0, height_m = 0;  // share of the area; mean where there is cloud
};

Sky measure(const Map& map) {
  Sky sky;
  int points = 0;
  for (uint seed = 101; seed <= 104; ++seed) {
    const CloudParams params = params_under(map, seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> place(-60000.0f, 60000.0f);
    for (int i = 0; i < 3000; ++i, ++points) {
      const vec2 p(place(random), place(random));
      const CloudSample sample = cloud_sample(params, p);
      sky.covered += sample.d > 0.0f;
      sky.height_m += static_cast<double>(cloud_height_m(params, p, sample));
    }
  }
  sky.height_m /= std::max(sky.covered, 1.0);
  sky.covered /= points;
  return sky;
}

}  // namespace

TEST_CASE("weather map: texels lie where they belong, the first row in the north") {
  // 3 x 2 texels of 1000 x 500 m from (2000, -1000) on.
  const Map map{{3, 2},
                {texel(10, 0), texel(20, 0), texel(30, 0), texel(40, 255), texel(50, 255), texel(60, 255)},
                {2000, -1000},
                {3000, 1000}};
  const Weather weather = map.seen_from(dvec2(0));
  const auto at = [&](float x, float y) { return weather_at(weather, vec2(x, y)) * 255.0f; };
  CHECK(at(2500, -250).x == doctest::Approx(10));
  CHECK(at(4500, -250).x == doctest::Approx(30));
  CHECK(at(2500, -750).x == doctest::Approx(40));
  CHECK(at(4500, -750).x == doctest::Approx(60));
  CHECK(at(2500, -250).y == doctest::Approx(0));
  CHECK(at(2500, -750).y == doctest::Approx(255));
  CHECK(at(3000, -250).x == doctest::Approx(15));  // between two middles
  CHECK(at(3500, -500).x == doctest::Approx(35));
  CHECK(at(3500, -500).y == doctest::Approx(127.5));
  CHECK(at(2000, -100).x == doctest::Approx(10));  // the outermost texels hold to the border
  CHECK(at(5000, -1000).x == doctest::Approx(60));
  // From there on they fade into the scene's constants over 2 km.
  CHECK(at(5000 + 500, -1000).x == doctest::Approx(0.75 * 60 + 0.25 * 0.25 * 255));
  CHECK(at(2500, 1500).y == doctest::Approx(0.75 * 255));
  CHECK(at(2500, 2001).y == doctest::Approx(255));
  for (const vec2 p : {vec2(-1e5f, 0.0f), vec2(1e5f, 0.0f), vec2(3500.0f, 9e4f), vec2(3500.0f, -9e4f)})
    CHECK(at(p.x, p.y).x == doctest::Approx(0.25 * 255));
}

TEST_CASE("weather map: a place has the same weather from every grid origin, 10 000 km out too") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-90000.0, 90000.0);
  Map map{{64, 48}, {}, {-50000, -40000}, {100000, 80000}};
  for (int i = 0; i < 64 * 48; ++i) map.texels.push_back(random() & 0xffffu);
  for (const dvec2 shift_m : {dvec2(1e7, -1e7), dvec2(1e9, 1.0 / 3.0)}) {
    Map away = map;
    away.corner_m += shift_m;
    const double unit_m = static_cast<double>(kOriginUnitM);
    const dvec2 origin_m = round(shift_m / unit_m) * unit_m;
    const Weather here = map.seen_from(dvec2(0)), there = away.seen_from(origin_m),
                  next = map.seen_from(dvec2(unit_m, -unit_m));
    double largest = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const dvec2 p(place(random), place(random));
      const vec2 a = weather_at(here, vec2(p)), b = weather_at(there, vec2(p + shift_m - origin_m)),
                 c = weather_at(next, vec2(p - dvec2(unit_m, -unit_m)));
      largest = std::max({largest, static_cast<double>(length(a - b)), static_cast<double>(length(a - c))});
    }
    CHECK(
        largest <
        1e-4);  // places are floats of 8 mm: 5e-6 of a texel, whose neighbours may differ by 1.4; the fade is 2 km wide
  }
  // Too far away for its index: nothing of it is seen.
  map.corner_m = dvec2(1e9);
  map.extent_m = dvec2(1.0);
  CHECK(weather_at(map.seen_from(dvec2(-1e9)), vec2(0.0f)).x == 0.25f);
}

TEST_CASE("weather map: its coverage is the fraction of the area under clouds, whatever the type") {
  for (const uint type : {0u, 128u, 255u}) {
    CAPTURE(type);
    for (const uint coverage : {0u, 26u, 102u, 153u, 204u, 230u, 255u}) {
      CAPTURE(coverage);
      const double covered = measure(uniform_map(coverage, type)).covered;
      // As without a map: four skies of 120 km differ by 0.02 at most, 12 000 points by 0.005.
      CHECK(std::fabs(covered - coverage / 255.0) < 0.03);
      if (coverage == 0u) CHECK(covered == 0.0);
      if (coverage == 255u) CHECK(covered > 0.995);
    }
  }
}

TEST_CASE("weather map: from humilis to congestus clouds grow taller and larger") {
  double last_m = 0.0;
  for (const uint type : {0u, 64u, 128u, 192u, 255u}) {
    const double height_m = measure(uniform_map(102, type)).height_m;
    CAPTURE(type);
    CHECK(height_m > 1.15 * last_m);
    last_m = height_m;
  }
  const double humilis_m = measure(uniform_map(102, 0)).height_m;
  CHECK(humilis_m < 0.4 * last_m);
  CHECK(humilis_m > 60.0);
}

TEST_CASE("weather map: a cloud that drifts out of it shrinks to nothing and never jumps") {
  // From full weather into a clear sky over 20 km.
  const Map map{{2, 2}, {texel(204, 255), texel(0, 0), texel(204, 255), texel(0, 0)}, {-20000, -5e6}, {40000, 1e7}};
  CloudParams params = params_under(map, 9, 0.0f);
  int born = 0;
  for (uint lattice = 0; lattice < kCloudLattices; ++lattice)
    for (int i = 0; i < 60; ++i) {
      float before_m = 0.0f;
      for (int step = 0; step <= 4000; ++step) {  // 10 m each, the wind carrying the cloud against x
        params.weather.placement = weather_placement(map.size, map.corner_m, map.extent_m, dvec2(20000 - 10 * step, 0));
        const float radius_m = cloud_feature(params, lattice, ivec2(0, i - 30)).radius_m;
        const float spacing_m = lattice_cell_m(feature_cells(lattice));
        // The area grows by the fade's slope: a fifteenth of the largest in 10 m at most.
        if (step > 0)
          REQUIRE(std::fabs(radius_m * radius_m - before_m * before_m) < 0.07f * 0.8f * spacing_m * spacing_m);
        born += before_m == 0.0f && radius_m > 0.0f;
        before_m = radius_m;
      }
    }
  CHECK(born > 60);
}
