// The cloud layer against the closed form: homogeneous ellipsoids with given radiance, blended by each backend that
// the device has, compared with a double-precision integral of overlapping chords.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/layer_scene.h"

using namespace nephele;
using namespace nephele::test;
using shared::Particle;

namespace {

std::vector<Backend> available_backends() {
  std::vector<Backend> list;
  for (Backend backend : {Backend::interlock, Backend::attachment, Backend::tiled, Backend::alpha})
    if (backend_available(test_device().info(), backend)) list.push_back(backend);
  return list;
}

LayerError off_from_truth(const Layer& layer, const std::vector<Particle>& particles, double tolerance) {
  return layer_error(layer, oracle_layer(particles, kLevelCamera), tolerance);
}

}  // namespace

TEST_CASE("nothing to draw is a clear layer") {
  for (Backend backend : available_backends()) {
    const Layer layer = draw_layer({}, kLevelCamera, backend);
    CHECK(
        std::all_of(layer.color.begin(), layer.color.end(), [](const auto& c) { return c == glm::vec4(0, 0, 0, 1); }));
    CHECK(std::all_of(layer.depth.begin(), layer.depth.end(), [](float z) { return std::isinf(z); }));
  }
}

TEST_CASE("one particle is exact with every backend: far, near, flat, dense, thin, around the camera") {
  const std::vector<Particle> cases = {emissive({0, 500, 0}, {100, 150, 60}, 0.02f, {1, 0.5f, 0.2f}),
                                       emissive({5e4f, 9e4f, 2000}, {9000, 5000, 3000}, 1e-3f, {1, 1, 1}),
                                       emissive({1, 3, 0.5f}, {1, 1, 0.5f}, 2, {0.2f, 1, 0.5f}),
                                       emissive({10, 20, -5}, {100, 100, 100}, 0.01f, {1, 0.5f, 2}),
                                       emissive({0, 300, 0}, {100, 100, 100}, 1e4f, {3, 2, 1}),
                                       emissive({0, 300, 0}, {100, 100, 100}, 1e-6f, {3, 2, 1}),
                                       emissive({0, 150, 30}, {400, 100, 0.5f}, 1, {1, 1, 1}),
                                       emissive({0, 0, 0}, {50, 50, 50}, 0.05f, {1, 1, 1}),
                                       emissive({0, -500, 0}, {100, 100, 100}, 1, {1, 1, 1})};
  for (Backend backend : available_backends())
    for (const Particle& p : cases) {
      CAPTURE(backend_name(backend));
      CAPTURE(p.center_m.y);
      CAPTURE(p.extinction_per_m);
      const Layer layer = draw_layer({p}, kLevelCamera, backend);
      // 1e-3: floats hold a chord's depth to 1e-6 relative, a silhouette of near-opaque matter amplifies that.
      CHECK(off_from_truth(layer, {p}, 1e-3).failing <= 0.001);
    }
}

TEST_CASE("two particles are exact with the volume-aware backends, overlapping or not") {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(0, 1);
  for (Backend backend : available_backends()) {
    if (backend == Backend::alpha) continue;
    for (int scene = 0; scene < 12; ++scene) {
      std::vector<Particle> pair;
      for (int i = 0; i < 2; ++i)
        pair.push_back(emissive({100 * (u(random) - 0.5f), 300 + 150 * u(random), 60 * (u(random) - 0.5f)},
                                {40 + 80 * u(random), 40 + 80 * u(random), 40 + 60 * u(random)},
                                std::exp2(-9 + 6 * u(random)), {u(random), u(random), u(random)}));
      const Layer layer = draw_layer(pair, kLevelCamera, backend);
      CAPTURE(scene);
      const LayerError error = off_from_truth(layer, pair, 1e-3);
      CHECK(error.failing <= 0.001);
      CHECK(error.worst < 1e-2);
    }
  }
}

TEST_CASE("many particles: transmittance is exact, colour close, the order of submission does not matter") {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> cloud;
  for (int i = 0; i < 300; ++i)
    cloud.push_back(emissive({600 * (u(random) - 0.5f), 400 + 400 * u(random), 300 * (u(random) - 0.5f)},
                             glm::vec3(20 + 40 * u(random)), 0.02f * u(random), glm::vec3(1.0f)));
  std::vector<Particle> shuffled = cloud;
  std::shuffle(shuffled.begin(), shuffled.end(), random);
  for (Backend backend : available_backends()) {
    CAPTURE(backend_name(backend));
    const Layer layer = draw_layer(cloud, kLevelCamera, backend);
    CHECK(off_from_truth(layer, cloud, 1e-3).worst <
          1e-3);  // white light: colour and transmittance are complements, both exact for any overlap
    CHECK(draw_layer(shuffled, kLevelCamera, backend).color == layer.color);
  }
}
