// The clouds' shadow against brute force, texel by texel and through the look-up that other passes use.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "nephele_test_shaders.h"
#include "passes/light/cloud_shadow.h"
#include "tests/support/light_scene.h"
#include "tests/support/shapes.h"

using namespace nephele;
using namespace nephele::test;

namespace {

constexpr std::uint32_t kTexelsPerTile = 2, kSide = shared::kLightTiles * kTexelsPerTile;

struct Shadow {
  std::vector<glm::vec4> texels;
  std::vector<float> probes;  // at the points asked for
};

Shadow cast(const LightScene& scene, const std::vector<glm::vec3>& points_m) {
  Workshop make(test_kernels());
  LightTiles tiles(make, scene.particle_capacity(), 1u << 20);
  CloudShadow shadow(make, kTexelsPerTile);
  ComputeKernel probe(test_device(), shaders::cloud_shadow_probe_comp);
  Buffer points(test_device(), "points", points_m.size() * sizeof(glm::vec3));
  points.write_vector(points_m);
  Buffer probes(test_device(), "probes", points_m.size() * sizeof(float));

  FrameBuilder frame(test_device());
  const LightTileLists lists = tiles.add(frame, scene.constants, scene.particles, scene.counters);
  const Image& image = shadow.add(frame, scene.constants, lists);
  const std::uint32_t count = static_cast<std::uint32_t>(points_m.size());
  frame.compute({.name = "probe",
                 .kernel = &probe,
                 .bindings = {{0, scene.constants, Access::uniform},
                              {1, image, Access::sampled},
                              {2, points, Access::storage_read},
                              {3, probes, Access::storage_write}},
                 .push = as_push(count),
                 .groups = {(count + 63) / 64, 1, 1}});
  FrameExecutor(test_device()).run(frame);

  Shadow result;
  result.texels.resize(kSide * kSide);
  image.read(std::as_writable_bytes(std::span(result.texels)));
  result.probes = probes.read_vector<float>(count);
  return result;
}

// Transmittance of everything on the sun ray through a point.
double true_transmittance(const LightScene& scene, dvec3 point) {
  double depth = 0.0;
  for (const Particle& particle : scene.particles_value) depth += depth_through(particle, point, scene.sun(), 1500.0);
  return std::exp(-depth);
}

dvec3 from_light(const LightScene& scene, dvec3 light_m) {
  return transpose(glm::dmat3(scene.constants_value.light_from_render)) * light_m;
}

LightScene sky(std::uint32_t seed, std::uint32_t count, double elevation_deg) {
  std::mt19937 random(seed);
  std::vector<Particle> particles(count);
  for (Particle& particle : particles) particle = random_particle(random, 3000.0f);
  return LightScene(light_constants(220, elevation_deg), particles, {});
}

}  // namespace

TEST_CASE("every texel holds the opacity of its sun ray") {
  for (double elevation : {90.0, 30.0, 3.0}) {
    CAPTURE(elevation);
    const LightScene scene = sky(12, 250, elevation);
    const Shadow shadow = cast(scene, {glm::vec3(0.0f)});
    int shaded = 0, opaque = 0;
    for (std::uint32_t y = 0; y < kSide; y += 2)
      for (std::uint32_t x = 0; x < kSide; x += 2) {
        const glm::vec2 across = shared::light_across(glm::vec2(x + 0.5f, y + 0.5f) / float(kSide), 80000.0f);
        const double opacity = 1.0 - true_transmittance(scene, from_light(scene, {across.x, across.y, -20000.0}));
        const glm::vec4 texel = shadow.texels[y * kSide + x];
        // The walk stops at 1e-3, and a ray off by 2e-4 m may graze a particle.
        REQUIRE(std::abs(texel.x - opacity) < 3e-3);
        shaded += opacity > 0.01;
        opaque += opacity > 0.9;
        if (texel.x > 0.0f) {  // top, mean and bottom lie in this order
          REQUIRE(texel.y >= texel.z - 0.02f);
          REQUIRE(texel.z >= texel.w - 0.02f);
        }
      }
    CHECK(shaded > 300);
    CHECK(opaque > 30);
  }
}

TEST_CASE("shadow look-up: all of it below the clouds, none above, none outside the field") {
  // One wide flat cloud between 400 and 600 m above the camera, sun at 50 degrees.
  Particle cloud;
  std::memset(&cloud, 0, sizeof cloud);
  cloud.center_m = glm::vec3(0.0f, 0.0f, 500.0f);
  cloud.shape = {glm::vec3(3000.0f, 3000.0f, 100.0f), glm::vec3(0.0f)};
  cloud.extinction_per_m = 0.01f;
  cloud.base_m = shared::kNoBaseM;
  cloud.flags = shared::kParticleHomogeneous;
  const LightScene scene(light_constants(220, 50), {cloud}, {});
  const dvec3 sun = scene.sun();
  const auto at_height = [&](double z) { return glm::vec3(sun * ((z - 500.0) / sun.z)) + glm::vec3(0, 0, 500.0f); };
  const std::vector<glm::vec3> points = {at_height(-1500.0),         at_height(380.0),
                                         at_height(500.0),           at_height(620.0),
                                         at_height(5000.0),          glm::vec3(20000.0f, 0.0f, -1500.0f),
                                         glm::vec3(3e6f, 0.0f, 0.0f)};
  const std::vector<float> probes = cast(scene, points).probes;
  const double through = true_transmittance(scene, dvec3(points[0]));
  REQUIRE(through < 0.2);
  CHECK(probes[0] == doctest::Approx(through).epsilon(0.02));
  CHECK(probes[1] == doctest::Approx(through).epsilon(0.02));
  CHECK(probes[2] == doctest::Approx(0.5 * (1.0 + through)).epsilon(0.05));
  CHECK(probes[3] > 0.98f);
  CHECK(probes[4] == 1.0f);
  CHECK(probes[5] == 1.0f);
  CHECK(probes[6] == 1.0f);
}

TEST_CASE("shadows on the ground: unbiased under a scattered sky") {
  const LightScene scene = sky(77, 250, 40.0);
  std::mt19937 random(6);
  std::uniform_real_distribution<float> across(-4000.0f, 4000.0f);
  std::vector<glm::vec3> points(2000);
  for (glm::vec3& point : points) point = glm::vec3(across(random), across(random), -1500.0f);
  const std::vector<float> probes = cast(scene, points).probes;
  double bias = 0.0, square = 0.0, mean = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double truth = true_transmittance(scene, dvec3(points[i]));
    REQUIRE(probes[i] >= 0.0f);
    REQUIRE(probes[i] <= 1.0f);
    mean += truth / double(points.size());
    bias += (probes[i] - truth) / double(points.size());
    square += (probes[i] - truth) * (probes[i] - truth) / double(points.size());
  }
  CHECK(mean > 0.5);
  CHECK(mean < 0.95);
  // Texels of some 50 to 150 m blur the outlines of particles of 60 to 260 m, half of them sharp-edged.
  CHECK(std::abs(bias) < 0.01);
  CHECK(std::sqrt(square) < 0.12);
}

TEST_CASE("a step of a millimetre changes no shadow") {
  // A layer of clouds, points on the ground and in the air below and among them, all standing still in the world.
  constexpr double kHalfM = 25000.0;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto anywhere = [&](double low_m, double high_m) {
    return dvec3(kHalfM * (2.0 * unit(random) - 1.0), kHalfM * (2.0 * unit(random) - 1.0),
                 low_m + (high_m - low_m) * unit(random));
  };
  std::vector<Particle> layer(3000);
  std::vector<dvec3> centers_m, points_m;
  for (Particle& particle : layer) {
    particle = random_particle(random, 3000.0f);
    particle.shape = test::scaled(particle.shape, 3.0f);
    particle.extinction_per_m *= 0.5f;
    particle.base_m = shared::kNoBaseM;
    centers_m.push_back(anywhere(1500.0, 2400.0));
  }
  for (int i = 0; i < 4000; ++i) points_m.push_back(anywhere(0.0, i % 2 ? 0.0 : 4000.0));
  const auto probes_from = [&](FrameConstants constants, dvec3 camera_m) {
    constants.camera_grid_m = glm::vec3(camera_m);
    constants.view_distance_m = 200000.0f;
    for (std::size_t i = 0; i < layer.size(); ++i) layer[i].center_m = glm::vec3(centers_m[i] - camera_m);
    std::vector<glm::vec3> points;
    for (const dvec3& p : points_m) points.push_back(glm::vec3(p - camera_m));
    return cast(LightScene(constants, layer, {}), points).probes;
  };
  for (const double altitude_m : {1500.0, 200000.0})
    for (const double elevation_deg : {12.0, 35.0, 60.0})
      for (const double azimuth_deg : {220.0, 75.0})
        for (int place = 0; place < 2; ++place) {
          CAPTURE(altitude_m);
          CAPTURE(elevation_deg);
          CAPTURE(azimuth_deg);
          CAPTURE(place);
          const FrameConstants constants = light_constants(azimuth_deg, elevation_deg);
          const dvec3 camera_m(137.3 * place, -91.7 * place, altitude_m);
          const std::vector<float> before = probes_from(constants, camera_m),
                                   after = probes_from(constants, camera_m + dvec3(1e-3, -1e-3, 0.0));
          double largest = 0.0, mean = 0.0;
          for (std::size_t i = 0; i < before.size(); ++i) {
            largest = std::max(largest, std::abs(double(after[i]) - double(before[i])));
            mean += double(before[i]) / double(before.size());
          }
          CHECK(mean > 0.3);
          CHECK(mean < 0.8);
          CHECK(largest <
                1.0 / 255.0);  // of the sun's light: places at 200 km are floats of 16 mm, and some graze a particle
        }
}

TEST_CASE("an empty sky casts no shadow") {
  const Shadow shadow = cast(LightScene(light_constants(220, 35), {}, {}), {glm::vec3(0.0f, 0.0f, -1500.0f)});
  CHECK(shadow.probes[0] == 1.0f);
  for (const glm::vec4 texel : shadow.texels) REQUIRE(texel == glm::vec4(0.0f));
}
