// Not part of the suite: what a pixel leaves of the structure, the tables in docs/shape.md.
//   test_study --no-skip --test-case="structure study"
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

#include "engine/image_compare.h"
#include "engine/image_io.h"
#include "passes/nephele.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::test;

namespace {

constexpr std::uint32_t kWidth = 320, kHeight = 180;
constexpr int kSamples = 4;      // a side, of a pixel
constexpr double kSigmas = 4.0;  // of a speck
constexpr double kCloud = 0.5;   // at most so much transmittance

std::vector<float> layers_of(const Scene& scene, std::uint32_t width, std::uint32_t height) {
  auto renderer = Renderer::create(test_sky(), scene, {.width = width, .height = height});
  REQUIRE(renderer);
  (*renderer)->render(scene.camera, 0.0);
  return (*renderer)->read_layers();
}

double luminance(const float* p) { return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]; }

// relMSE, as `nephele compare` has it, of one sample a pixel against the mean of many.
double relative_error(const std::vector<float>& one, const std::vector<float>& many) {
  ImageF test{kWidth, kHeight, {"R", "G", "B"}, {}}, mean = test;
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (int j = 0; j < kSamples; ++j)
          for (int i = 0; i < kSamples; ++i)
            sum += many[((std::size_t{y} * kSamples + j) * kWidth * kSamples + std::size_t{x} * kSamples + i) * 5 + c];
        mean.data.push_back(static_cast<float>(sum / (kSamples * kSamples)));
        test.data.push_back(one[(std::size_t{y} * kWidth + x) * 5 + c]);
      }
  const auto errors = compare_images(test, "one sample", mean, "many samples", mean.channels);
  REQUIRE(errors);
  return errors->relmse;
}

// Pixels of cloud whose luminance lies more than kSigmas deviations off the others of their 5 x 5 neighbourhood.
double specks(const std::vector<float>& layers) {
  std::size_t found = 0, looked = 0;
  for (std::uint32_t y = 2; y + 2 < kHeight * kSamples; ++y)
    for (std::uint32_t x = 2; x + 2 < kWidth * kSamples; ++x) {
      const auto at = [&](std::uint32_t px, std::uint32_t py) {
        return &layers[(std::size_t{py} * kWidth * kSamples + px) * 5];
      };
      if (at(x, y)[3] > kCloud) continue;
      double sum = 0, squares = 0;
      for (std::uint32_t j = y - 2; j <= y + 2; ++j)
        for (std::uint32_t i = x - 2; i <= x + 2; ++i) {
          if (i == x && j == y) continue;
          const double l = luminance(at(i, j));
          sum += l;
          squares += l * l;
        }
      const double mean = sum / 24, deviation = std::sqrt(std::max(squares / 24 - mean * mean, 0.0));
      found +=
          std::abs(luminance(at(x, y)) - mean) > kSigmas * deviation + 2e-3 * mean;  // of even cloud, rounding aside
      ++looked;
    }
  return looked > 0 ? double(found) / double(looked) : 0.0;
}

}  // namespace

TEST_CASE("structure study" * doctest::skip()) {
  for (const char* name : {"fair_weather", "towering", "coast", "sunset", "above_deck"}) {
    const auto scene = load_scene(std::string(NEPHELE_SOURCE_DIR) + "/tools/scenes/" + name + ".json");
    REQUIRE(scene);
    const std::vector<float> one = layers_of(*scene, kWidth, kHeight),
                             many = layers_of(*scene, kWidth * kSamples, kHeight * kSamples);
    std::printf("| %s | %.4f | %.1e |\n", name, relative_error(one, many), specks(many));
    std::fflush(stdout);
  }
}
