// Not part of the suite: errors and times of the blends on the same scenes, the table in docs/blending.md.
//   test_pass --no-skip --test-case="blending study"
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <random>

#include "tests/support/layer_scene.h"

using namespace nephele;
using namespace nephele::test;

TEST_CASE("blending study" * doctest::skip()) {
  struct Scene {
    const char* name;
    int count;
    float extent_m, extinction_per_m;
  };
  struct Way {
    const char* name;
    Backend backend;
    BlendMode blend;
  };
  constexpr LayerSize kSize{320, 200};
  std::printf("%-24s %-20s %10s %10s %9s\n", "scene", "blend", "RMSE", "worst", "ms");
  for (const Scene& scene :
       {Scene{"3 near-opaque", 3, 120, 0.15f}, Scene{"64 apart", 64, 800, 0.02f}, Scene{"64 heaped", 64, 150, 0.02f},
        Scene{"1000 apart", 1000, 1500, 0.02f}, Scene{"1000 heaped, thin", 1000, 200, 2e-4f}}) {
    std::mt19937 random(13);
    std::uniform_real_distribution<float> u(0, 1);
    std::vector<shared::Particle> particles;
    for (int i = 0; i < scene.count; ++i)
      particles.push_back(emissive(scene.extent_m * (glm::vec3(u(random), u(random), u(random)) - 0.5f) +
                                       glm::vec3(0, 300 + 0.7f * scene.extent_m, 0),
                                   glm::vec3(30 + 40 * u(random)), scene.extinction_per_m,
                                   {u(random), u(random), u(random)}));
    const Layer truth = oracle_layer(particles, kLevelCamera, kSize);
    for (const Way& way : {Way{"alpha", Backend::alpha, BlendMode::volume},
                           Way{"volume, attachment", Backend::attachment, BlendMode::volume},
                           Way{"volume, tiled", Backend::tiled, BlendMode::volume},
                           Way{"exact, tiled", Backend::tiled, BlendMode::exact}}) {
      if (!backend_available(test_device().info(), way.backend)) continue;
      const Layer layer = draw_layer(particles, kLevelCamera, way.backend, way.blend, kSize, 7);
      const LayerError error = layer_error(layer, truth, 2e-4);
      std::printf("%-24s %-20s %10.2e %10.2e %9.2f\n", scene.name, way.name, error.rmse, error.worst, layer.shade_ms);
    }
  }

  // How far the picture jumps when everything moves by a millimetre, beyond the truth's own change.
  std::mt19937 random(5);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<shared::Particle> crowd;
  for (int i = 0; i < 64; ++i)
    crowd.push_back(emissive(150.0f * (glm::vec3(u(random), u(random), u(random)) - 0.5f) + glm::vec3(0, 450, 0),
                             glm::vec3(30 + 40 * u(random)), 0.05f, {u(random), u(random), u(random)}));
  for (const Way& way :
       {Way{"alpha", Backend::alpha, BlendMode::volume}, Way{"volume, tiled", Backend::tiled, BlendMode::volume},
        Way{"exact, tiled", Backend::tiled, BlendMode::exact}}) {
    std::vector<shared::Particle> moved = crowd;
    Layer before = draw_layer(moved, kLevelCamera, way.backend, way.blend),
          truth_before = oracle_layer(moved, kLevelCamera);
    double most = 0;
    for (int step = 0; step < 40; ++step) {
      for (shared::Particle& p : moved) p.center_m += glm::vec3(-0.001f, 0, 0.0005f);
      const Layer after = draw_layer(moved, kLevelCamera, way.backend, way.blend);
      const Layer truth = oracle_layer(moved, kLevelCamera);
      most = std::max(most, step_error(before, after, truth_before, truth));
      before = after;
      truth_before = truth;
    }
    std::printf("%-24s %-20s largest jump a millimetre: %.2e\n", "64 heaped, moving", way.name, most);
  }
}
