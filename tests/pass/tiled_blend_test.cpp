// The tiled backend: its exact blend against the integral, its volume blend against the raster one, and its lists.
#include <doctest/doctest.h>

#include <random>

#include "tests/support/layer_scene.h"

using namespace nephele;
using namespace nephele::test;
using shared::Particle;

namespace {

struct Crowd {
  int count;
  bool spread;         // over the whole view, or heaped on one place
  bool around_camera;  // the camera stands in the middle of it
};

std::vector<Particle> crowd(const Crowd& kind, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> particles;
  for (int i = 0; i < kind.count; ++i) {
    const glm::vec3 offset = (kind.spread ? 600.0f : 120.0f) * (glm::vec3(u(random), u(random), u(random)) - 0.5f);
    const glm::vec3 center = offset + glm::vec3(0, kind.around_camera ? 0 : 450, 0);
    const glm::vec3 radius = glm::vec3(20 + 80 * u(random), 20 + 80 * u(random), 20 + 60 * u(random));
    // From nearly nothing to opaque; a crowd together stays within a few optical depths or far beyond.
    Particle p = emissive(center, radius, std::exp2(-12 + 9 * u(random)), {u(random), u(random), u(random)});
    p.yaw_rad = 6 * u(random);
    particles.push_back(p);
  }
  return particles;
}

LayerError exact_error(const std::vector<Particle>& particles, LayerSize size = {}, const CameraState& camera = kLevelCamera) {
  const Layer layer = draw_layer(particles, camera, Backend::tiled, BlendMode::exact, size);
  CHECK(layer.pairs_lost == 0);
  return layer_error(layer, oracle_layer(particles, camera, size), 2e-4);
}

std::vector<Particle> shell(int count, float extinction_per_m, bool coincident) {
  std::vector<Particle> particles;
  for (int i = 0; i < count; ++i) {
    const float radius = coincident ? 100.0f : 20.0f + 80.0f * float(i + 1) / float(count);
    particles.push_back(emissive({0, 300, 0}, glm::vec3(radius), extinction_per_m, {float(i % 3) / 2, float(i % 5) / 4, float(i % 7) / 6}));
  }
  return particles;
}

}  // namespace

TEST_CASE("the exact blend is the integral: spread and heaped crowds, from outside and from inside") {
  for (const int count : {2, 3, 8, 64, 1000})
    for (const bool spread : {true, false})
      for (const bool around_camera : {false, true}) {
        CAPTURE(count);
        CAPTURE(spread);
        CAPTURE(around_camera);
        const LayerError error = exact_error(crowd({count, spread, around_camera}, 10 + count));
        CHECK(error.failing <= 0.001);
        CHECK(error.worst < 1e-2);
      }
}

TEST_CASE("the exact blend: hundreds of thin particles on a pixel") {
  std::mt19937 random(13);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> particles;
  for (int i = 0; i < 400; ++i)
    particles.push_back(emissive(200.0f * (glm::vec3(u(random), u(random), u(random)) - 0.5f) + glm::vec3(0, 440, 0), glm::vec3(30 + 40 * u(random)),
                                 2e-4f, {u(random), u(random), u(random)}));
  const LayerError error = exact_error(particles);
  CHECK(error.failing <= 0.001);
  CHECK(error.worst < 1e-2);
}

TEST_CASE("the exact blend: coincident and concentric particles, thin to opaque") {
  for (const bool coincident : {true, false})
    for (const float extinction : {1e-7f, 1e-3f, 1e4f}) {
      CAPTURE(coincident);
      CAPTURE(extinction);
      const LayerError error = exact_error(shell(40, extinction, coincident));
      CHECK(error.failing <= 0.001);
      CHECK(error.worst < 1e-2);
    }
}

TEST_CASE("the exact blend: from a centimetre to 100 km in one picture") {
  const std::vector<Particle> sizes = {
      emissive({0, 2e5f, 2e4f}, glm::vec3(1e5f), 1e-6f, {1, 0.8f, 0.6f}), emissive({-2e3f, 8e3f, 500}, {2e3f, 1e3f, 500}, 1e-3f, {0.2f, 0.8f, 1}),
      emissive({20, 100, -5}, {10, 10, 5}, 0.1f, {1, 0.2f, 0.2f}), emissive({0.02f, 0.1f, 0.01f}, glm::vec3(0.01f), 100, {0.3f, 1, 0.3f}),
      emissive({-0.05f, 0.3f, 0}, {0.1f, 0.1f, 0.01f}, 3, {1, 1, 1})};
  const LayerError error = exact_error(sizes);
  CHECK(error.failing <= 0.001);
  CHECK(error.worst < 1e-2);
}

TEST_CASE("zero density changes nothing, 4096 layers on a pixel are all counted") {
  const std::vector<Particle> one = {emissive({0, 300, 0}, glm::vec3(80), 0.01f, {1, 0.5f, 0})};
  std::vector<Particle> with_nothing = one;
  with_nothing.push_back(emissive({10, 300, 0}, glm::vec3(80), 0, {9, 9, 9}));
  // 1e-6: one more place in the list is one more point where a chord's integral is cut in two.
  CHECK(layer_error(draw_layer(one, kLevelCamera, Backend::tiled, BlendMode::exact),
                    draw_layer(with_nothing, kLevelCamera, Backend::tiled, BlendMode::exact), 1e-6).failing == 0);

  std::vector<Particle> layers;
  for (int i = 0; i < 4096; ++i)
    layers.push_back(emissive({0, 1000 + 2.0f * float(i), 0}, {6000, 3, 6000}, 2e-4f, {float(i % 2), float(i) / 4096, 0.5f}));
  for (Particle& p : layers) p.yaw_rad = 0;
  const LayerSize small{8, 8};
  CameraState narrow = kLevelCamera;
  narrow.vertical_fov_rad = 0.05;
  const LayerError error = exact_error(layers, small, narrow);
  CHECK(error.failing == 0);
  const Layer volume = draw_layer(layers, narrow, Backend::tiled, BlendMode::volume, small);
  CHECK(layer_error(volume, oracle_layer(layers, narrow, small), 1.0).worst < 0.2);
}

TEST_CASE("the volume blend is the same picture tiled and in raster order") {
  if (!backend_available(test_device().info(), Backend::attachment)) return;
  for (const int count : {2, 8, 64, 1000})
    for (const bool spread : {true, false})
      for (const bool around_camera : {false, true}) {
        CAPTURE(count);
        CAPTURE(spread);
        CAPTURE(around_camera);
        const std::vector<Particle> particles = crowd({count, spread, around_camera}, 10 + count);
        const Layer tiled = draw_layer(particles, kLevelCamera, Backend::tiled), raster = draw_layer(particles, kLevelCamera, Backend::attachment);
        CHECK(layer_error(tiled, raster, 1e-3).failing <= 0.001);
      }
}

TEST_CASE("the exact blend moves without a jump when particles swap order") {
  std::vector<Particle> moved = crowd({64, false, false}, 5);
  Layer before = draw_layer(moved, kLevelCamera, Backend::tiled, BlendMode::exact), truth_before = oracle_layer(moved, kLevelCamera);
  for (int step = 0; step < 12; ++step) {
    for (Particle& p : moved) p.center_m.x -= 0.001f;  // the camera goes right by a millimetre
    const Layer after = draw_layer(moved, kLevelCamera, Backend::tiled, BlendMode::exact), truth = oracle_layer(moved, kLevelCamera);
    CHECK(step_error(before, after, truth_before, truth) < 1e-3);
    before = after;
    truth_before = truth;
  }
}

TEST_CASE("work ends behind opaque matter and there is none in empty tiles") {
  std::vector<Particle> particles;
  for (int i = 0; i < 200; ++i) particles.push_back(emissive({0, 300 + 50.0f * float(i), 0}, glm::vec3(30), 1.0f, {1, 1, 1}));
  for (const BlendMode blend : {BlendMode::volume, BlendMode::exact}) {
    const Layer layer = draw_layer(particles, kLevelCamera, Backend::tiled, blend);
    const std::size_t covered = static_cast<std::size_t>(std::count_if(layer.color.begin(), layer.color.end(), [](const glm::vec4& c) { return c.w < 1; }));
    CHECK(covered > 100);
    CHECK(layer.pairs_shaded >= covered);
    CHECK(layer.pairs_shaded < 6 * covered);
  }
}
