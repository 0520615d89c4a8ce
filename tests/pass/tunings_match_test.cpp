// The kernels of every tuning draw the same picture on one device.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "engine/image_compare.h"
#include "passes/nephele.h"
#include "tests/support/layer_scene.h"
#include "tests/support/support.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::test;
using shared::Particle;

namespace {

// Particles of all densities in front of the camera, and two heaps of small ones, each on a few tiles.
std::vector<Particle> crowd_with_heaps(int left_heap, int right_heap) {
  std::mt19937 random(31);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> particles;
  for (int i = 0; i < 100; ++i) {
    const glm::vec3 offset = 600.0f * (glm::vec3(u(random), u(random), u(random)) - 0.5f);
    particles.push_back(emissive(offset + glm::vec3(0, 450, 0), glm::vec3(20) + 80.0f * glm::vec3(u(random)),
                                 std::exp2(-12 + 9 * u(random)), {u(random), u(random), u(random)}));
  }
  const auto heap = [&](int count, float x_m) {
    for (int i = 0; i < count; ++i)
      particles.push_back(emissive({x_m, 500 + 300 * u(random), 40}, glm::vec3(4 + 4 * u(random)), 2e-4f,
                                   {u(random), u(random), u(random)}));
  };
  heap(left_heap, -150);
  heap(right_heap, 150);
  return particles;
}

ImageF as_image(const std::vector<float>& rgba, std::uint32_t width, std::uint32_t height) {
  ImageF image{width, height, {"R", "G", "B"}, {}};
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    image.data.insert(image.data.end(), {rgba[i], rgba[i + 1], rgba[i + 2]});
  return image;
}

}  // namespace

// Storage buffers hold the same bits as texel buffers, and the same kernels read them. Between the CPU's kernels and
// the GPU's the bounds are those of tiled_blend_test.cpp: of the tiled and the raster volume blend, and of the exact
// blend and the integral. Through thousands of places the GPU's exact blend goes more often than lavapipe's loops may,
// so its lists are short and, some, just longer than short.
TEST_CASE("the tiled blends of each tuning are one picture") {
  struct Case {
    BlendMode blend;
    std::vector<Particle> particles;
    bool gpu;
  };
  const Case cases[] = {{BlendMode::volume, crowd_with_heaps(500, 4200), true},
                        {BlendMode::exact, crowd_with_heaps(500, 4200), false},
                        {BlendMode::exact, crowd_with_heaps(150, 0), true}};
  for (const auto& [blend, particles, gpu] : cases) {
    CAPTURE(std::string(blend_mode_name(blend)));
    std::vector<Layer> layers;
    for (const TestTuning tuning : kTestTunings) {
      if (tuning == TestTuning::gpu && !gpu) continue;
      const WithTuning with(tuning);
      CHECK(test_device().tuning().pixel_columns == (tuning != TestTuning::gpu));
      layers.push_back(draw_layer(particles, kLevelCamera, Backend::tiled, blend));
      CHECK(layers.back().pairs_lost == 0);
      CHECK(layers.back().rays_cut_short == 0);
    }
    CHECK(layers[1].color == layers[0].color);
    CHECK(layers[1].depth == layers[0].depth);
    if (!gpu) continue;
    const LayerError error = layer_error(layers[2], layers[0], blend == BlendMode::exact ? 2e-4 : 1e-3);
    CHECK(error.failing <= 0.001);
    CHECK(error.worst < 1e-2);
  }
}

// Storage buffers hold the same bits as texel buffers; the GPU's kernels may add in another order, and for smooth
// particles sample the optical depth table as a texture, whose values are whole 256ths as those of the packed table
// are.
TEST_CASE("a frame of each tuning is one picture") {
  constexpr std::uint32_t kWidth = 96, kHeight = 54;
  struct Case {
    std::string name;
    bool detail;
  };
  for (const auto& [scene_name, detail] :
       {Case{"fair_weather", true}, Case{"fair_weather", false}, Case{"inside_cloud", true}}) {
    const std::string name = scene_name;
    CAPTURE(name);
    CAPTURE(detail);
    const auto scene = load_scene(std::string(NEPHELE_SOURCE_DIR) + "/tools/scenes/" + name + ".json");
    REQUIRE(scene);
    std::vector<std::vector<float>> pictures;
    for (const TestTuning tuning : kTestTunings) {
      const WithTuning with(tuning);
      const auto renderer = Renderer::create(
          test_sky(), *scene, {.width = kWidth, .height = kHeight, .quality = Quality::low, .detail = detail});
      REQUIRE(renderer);
      (*renderer)->render(scene->camera, 0.0);
      pictures.push_back((*renderer)->read_hdr());
    }
    CHECK(pictures[1] == pictures[0]);
    if (!detail) CHECK(pictures[2] != pictures[0]);  // a proof that other kernels ran
    const ImageF cpu = as_image(pictures[0], kWidth, kHeight), gpu = as_image(pictures[2], kWidth, kHeight);
    const auto metrics = compare_images(gpu, "gpu", cpu, "cpu", cpu.channels);
    REQUIRE(metrics);
    CHECK(metrics->relmse < 1e-8);  // 1e-13 on lavapipe: sums in another order; a pixel off by 0.01 would fail
  }
}
