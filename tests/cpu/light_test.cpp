// Light space, its tiles and order, and the optical depth of one particle, against double-precision geometry.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lut/tables.h"
#include "shared/flat_base.h"
#include "shared/light.h"
#include "shared/reference_particle.h"
#include "shared/structure.h"
#include "tests/support/light_scene.h"

using namespace nephele::shared;
using nephele::test::depth_through;
using nephele::test::random_particle;

namespace {

constexpr float kView = 80000.0f;

dvec3 sun_at(double azimuth_deg, double elevation_deg) {
  const double a = glm::radians(azimuth_deg), e = glm::radians(elevation_deg);
  return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

}  // namespace

TEST_CASE("warped coordinates are inverse pairs, odd and monotone") {
  // Float logarithms leave 3e-7 of the warped value, at most 6: 2e-6 of the distance from -kLightInnerM.
  float previous = -1e9f;
  for (float x : {-1e6f, -80000.0f, -2000.0f, -1.0f, -1e-3f, 0.0f, 1e-3f, 1.0f, 150.0f, 2000.0f, 30000.0f, 1e6f}) {
    CAPTURE(x);
    CHECK(light_warp(-x) == -light_warp(x));
    CHECK(light_warp(x) > previous);
    CHECK(std::abs(light_unwarp(light_warp(x)) - x) < 4e-6f * (kLightInnerM + std::abs(x)));
    const vec2 uv = light_uv(vec2(x, -0.5f * x), kView);
    const vec2 back = light_across(uv, kView);
    CHECK(std::abs(back.x - x) < 1e-5f * (kLightInnerM + std::abs(x)));
    CHECK(std::abs(back.y + 0.5f * x) < 1e-5f * (kLightInnerM + std::abs(x)));
    previous = light_warp(x);
  }
  CHECK(light_warp(kLightInnerM) == doctest::Approx(1.0));
  const float reach = light_reach_m(kView);
  CHECK(light_uv(vec2(reach, -reach), kView).x == doctest::Approx(1.0));
  CHECK(light_uv(vec2(reach, -reach), kView).y == doctest::Approx(0.0).epsilon(1e-6));
}

TEST_CASE("tiles: the camera in the middle, everything beyond in the border") {
  CHECK(light_tile(vec2(1.0f, 1.0f), kView) == uvec2(kLightTiles / 2));
  CHECK(light_tile(vec2(-1.0f, -1.0f), kView) == uvec2(kLightTiles / 2 - 1));
  CHECK(light_tile(vec2(1e9f, -1e9f), kView) == uvec2(kLightTiles - 1, 0));
  uint last = 0;
  for (float u = -130000.0f; u < 130000.0f; u += 37.0f) {
    const uint x = light_tile(vec2(u, 0.0f), kView).x;
    CHECK_MESSAGE((x == last || x == last + 1), u);  // no tile is skipped at this step near the camera or far away
    last = x;
  }
  CHECK(last == kLightTiles - 1);
}

TEST_CASE("a tile near the camera is as wide as a small particle") {
  const vec2 side = light_across(vec2(0.5f + 1.0f / float(kLightTiles)), kView) - light_across(vec2(0.5f), kView);
  CHECK(side.x > 60.0f);
  CHECK(side.x < 130.0f);
}

TEST_CASE("rectangles pack and bound what they cover") {
  const LightBounds all{vec3(0.0f), vec3(1e7f)};
  CHECK(rectangle_area(light_rectangle(all, kView)) == kLightTiles * kLightTiles);
  CHECK(rectangle_area(kNoTiles) == 0u);
  const LightBounds one{vec3(5.0f, 7.0f, 0.0f), vec3(1.0f)};
  CHECK(rectangle_area(light_rectangle(one, kView)) == 1u);
  CHECK(rectangle_low(light_rectangle(one, kView)) == light_tile(vec2(5.0f, 7.0f), kView));
}

TEST_CASE("the stop height never lets a traversal end before the last particle above the point") {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> exponent(-1.0f, 5.7f), unit(-1.0f, 1.0f);
  const auto height = [&] { return std::copysign(std::pow(10.0f, exponent(random)), unit(random)); };
  int stopped = 0;
  for (int i = 0; i < 300000; ++i) {
    const float point = height(), first = height();
    // A second particle at nearly the same height, where keys are equal or swapped by rounding.
    const float second = first + (i % 2 ? 0.003f * unit(random) * std::abs(first) : 40.0f * unit(random));
    if (sun_key(first, kView) > sun_key(second, kView)) continue;
    if (first >= sun_stop_m(point, kView)) continue;
    ++stopped;
    CHECK(second < point);
  }
  CHECK(stopped > 50000);
  // And it stops not much later than it could: within 4 m near the camera, 100 m at 60 km.
  CHECK(sun_stop_m(0.0f, kView) > -4.0f);
  CHECK(sun_stop_m(-60000.0f, kView) > -60100.0f);
}

TEST_CASE("light space is an orthonormal right-handed basis for every sun") {
  for (const dvec3 sun : {sun_at(0, 90), sun_at(0, -90), sun_at(220, 35), sun_at(90, 0), sun_at(10, -3),
                          sun_at(300, 89.99999), sun_at(45, 60) * 3.0}) {
    CAPTURE(sun.x);
    CAPTURE(sun.z);
    const dmat3 rows = transpose(dmat3(make_light_from_render(sun)));
    const dvec3 w = normalize(sun);
    for (int axis = 0; axis < 3; ++axis) CHECK(length(rows[axis]) == doctest::Approx(1.0).epsilon(1e-6));
    CHECK(length(rows[2] - w) < 1e-7);
    CHECK(length(cross(rows[0], rows[1]) - w) < 2e-7);
    CHECK(rows[0].z == doctest::Approx(0.0).epsilon(1e-7));
  }
}

TEST_CASE("a particle's bounds contain it and touch it") {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 50; ++i) {
    const Particle particle = random_particle(random, 3000.0f);
    const mat3 light = make_light_from_render(sun_at(i * 77.0, -20.0 + i * 2.2));
    LightBounds bounds;
    const Occluder occluder = make_occluder(particle, light, 1500.0f, bounds);
    vec3 furthest(0.0f);
    for (int k = 0; k < 4000; ++k) {
      const vec3 on_sphere = vec3(normalize(dvec3(normal(random), normal(random), normal(random))));
      const vec3 offset = abs(light * particle_point(particle, on_sphere) - bounds.center_m);
      furthest = max(furthest, offset / bounds.extent_m);
      CHECK(light_tile(vec2(light * particle_point(particle, on_sphere)), kView).x <=
            rectangle_high(light_rectangle(bounds, kView)).x - 1u);
    }
    CHECK(occluder.top_m == bounds.center_m.z + bounds.extent_m.z);
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(furthest[axis] <= 1.0f);
      CHECK(furthest[axis] > 0.98f);  // 4 000 points leave the extreme one within a few degrees
    }
  }
}

TEST_CASE("optical depth of one particle: partial, clipped and grazing chords against quadrature") {
  std::mt19937 random(23);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int some = 0;
  for (int i = 0; i < 20000; ++i) {
    Particle particle = random_particle(random, 2000.0f);
    const double elevation = i % 5 == 0 ? 0.0 : (i % 5 == 1 ? 90.0 : 90.0 * unit(random));
    const dvec3 sun = sun_at(360.0 * unit(random), elevation);
    const mat3 light = make_light_from_render(sun);
    const vec3 point = particle_point(particle, 1.6f * vec3(unit(random), unit(random), unit(random)));
    LightBounds bounds;
    const Occluder occluder = make_occluder(particle, light, 1500.0f, bounds);
    const double expected = depth_through(particle, dvec3(point), sun, 1500.0);
    const double depth = occluder_depth(occluder, light * point, vec3(light[2]));
    // Positions of 2 km in float are good to 2.4e-4 m; a chord that ends at a grazing angle turns a shift e into
    // sqrt(2 r e), and the base plane of a sun on the horizon turns it into the whole chord (not met at random).
    const double radius = longest_axis_at_most_m(particle.shape);
    CHECK(std::abs(depth - expected) <= particle.extinction_per_m * (0.02 + 2.0 * std::sqrt(2.0 * radius * 3e-4)));
    some += expected > 0.0;
  }
  CHECK(some > 3000);
}

TEST_CASE("a point without any chord sees no depth, however far or flat the particle") {
  Particle particle{};
  particle.extinction_per_m = 0.05f;
  particle.base_m = kNoBaseM;
  const mat3 light = make_light_from_render(sun_at(200, 30));
  LightBounds bounds;
  for (vec3 radius : {vec3(0.001f), vec3(1000.0f, 1000.0f, 0.01f), vec3(300.0f, 20.0f, 100.0f)})
    for (float along : {-1e5f, -1e-3f, 0.0f, 1e-3f, 1e5f}) {
      particle.shape = {radius, vec3(0.0f)};
      particle.center_m = vec3(10.0f, 20.0f, 30.0f);
      const Occluder occluder = make_occluder(particle, light, 1500.0f, bounds);
      const vec3 up = light[2];
      const vec3 beside = bounds.center_m + vec3(2.0f * bounds.extent_m.x + 1.0f, 0.0f, along);
      CHECK(occluder_depth(occluder, beside, up) == 0.0f);
      const float depth = occluder_depth(occluder, bounds.center_m + vec3(0.0f, 0.0f, along), up);
      CHECK(depth >= 0.0f);
      CHECK(depth < 0.05f * 2000.0f);
      if (along == 1e5f) CHECK(depth == 0.0f);
    }
}

TEST_CASE("the closed-form chord integral is the integral of the profile") {
  for (uint flags : {0u, kParticleHomogeneous})
    for (double b = 0.0; b < 1.0; b += 0.11) {
      const double h2 = 1.0 - b * b, reach = std::sqrt(h2);
      for (double end = -reach; end <= reach; end += 0.17) {
        double sum = 0.0;
        const int steps = 400;
        for (int k = 0; k < steps; ++k) {
          const double s = -reach + (end + reach) * (k + 0.5) / steps;
          sum += particle_profile(float(h2 - s * s), flags) * (end + reach) / steps;
        }
        CHECK(profile_integral(float(end), float(h2), flags) - profile_integral(float(-reach), float(h2), flags) ==
              doctest::Approx(sum).epsilon(1e-4));  // the midpoint rule's own error
      }
    }
}

TEST_CASE("the profile stands for displaced balls, and nearly for the smooth reference particle") {
  const uint seed = nephele::TableParameters{}.particle_seed;
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<float> cells(0.0f, float(kStructureCells));
  // The noise at places that know nothing of each other, by the tile itself.
  std::vector<float> noise, broad;
  for (int i = 0; i < 1000; ++i) {
    float sum = 0.0f;
    for (uint octave = 0; octave < kStructureOctaves; ++octave)
      sum += structure_weight(octave) * (structure_tile({cells(random), cells(random), cells(random)}) - 0.5f);
    noise.push_back(structure_noise(sum));
    broad.push_back(structure_tile({cells(random), cells(random), cells(random)}) - 0.5f);
  }
  double displaced_fill = 0.0, half_torn_fill = 0.0, torn_fill = 0.0, smooth_fill = 0.0, fill = 0.0;
  for (double r = 0.025; r < 1.0; r += 0.05) {
    double displaced = 0.0, wide = 0.0, half_torn = 0.0, torn = 0.0, smooth = 0.0;
    for (std::size_t i = 0; i < noise.size(); ++i) {
      const auto density = [&](float depth) {
        const float radius = displaced_radius(depth, noise[i], broad[i]);
        return double(structured_density(float(r * r), radius, structure_skin(depth))) / double(noise.size());
      };
      displaced += density(kStructureDeepest);
      wide += density(0.2f * kStructureDeepest);  // of a body of 1250 m: moved by the broad form
      half_torn += density(0.5f * (kStructureDeepest + kTornDepth));
      torn += density(kTornDepth);
    }
    for (int k = 0; k < 400; ++k)
      smooth +=
          reference_particle_density(vec3(r * normalize(dvec3(normal(random), normal(random), normal(random)))), seed) /
          400.0;
    const double mean = particle_profile(float(1.0 - r * r), 0u);
    CAPTURE(r);
    CHECK(std::abs(wide - displaced) < 0.06);
    CHECK(std::abs(mean - displaced) < 0.08);  // at most 0.04, and 1000 places leave 0.015 of noise
    CHECK(std::abs(mean - smooth) < 0.17);     // its surface is softer
    displaced_fill += displaced * r * r;
    half_torn_fill += half_torn * r * r;
    torn_fill += torn * r * r;
    smooth_fill += smooth * r * r;
    fill += mean * r * r;
  }
  CHECK(std::abs(fill / displaced_fill - 1.0) < 0.04);
  const uint torn_flags = kParticleDetail | (kMostTorn << kParticleTornShift);
  const uint half_torn_flags = kParticleDetail | (kMostTorn / 2u << kParticleTornShift);
  CHECK(std::abs(half_torn_fill / displaced_fill - torn_matter(half_torn_flags)) < 0.03);
  CHECK(std::abs(torn_fill / displaced_fill - torn_matter(torn_flags)) < 0.03);
  CHECK(torn_matter(kParticleDetail) == 1.0f);
  CHECK(torn_matter(kMostTorn << kParticleTornShift) == 1.0f);  // without structure there is nothing to tear
  // The bounds cut few places off.
  CHECK(std::count_if(noise.begin(), noise.end(), [](float n) {
          return kStructureMeanRadius + kStructureDeepest * (n - kStructureMean) > 1.0f;
        }) < 0.08 * double(noise.size()));
  CHECK(std::abs(fill / smooth_fill - 1.0) < 0.05);
}

TEST_CASE("tetrahedron corners are balanced and isotropic") {
  dvec3 sum(0.0);
  dmat3 outer(0.0);
  for (uint i = 0; i < 4; ++i) {
    const dvec3 corner = dvec3(tetrahedron_corner(i));
    CHECK(length(corner) == doctest::Approx(1.0));
    sum += corner;
    outer += outerProduct(corner, corner);
  }
  CHECK(length(sum) < 1e-6);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) CHECK(outer[i][j] == doctest::Approx(i == j ? 4.0 / 3.0 : 0.0).epsilon(1e-6));
}
