// Small linear images of the product's own scenes against committed ones. The limits allow for another CPU's rounding
// in a shader compiler (a particle's edge may flip a pixel), not for another picture: after an intended change,
// NEPHELE_UPDATE_GOLDENS=1 writes new ones, and the commit says why.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "engine/image_io.h"
#include "passes/nephele.h"
#include "tests/support/support.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using nephele::test::test_sky;

namespace {

constexpr std::uint32_t kWidth = 128, kHeight = 72;
constexpr double kPixelTolerance = 0.004;  // radiance per sun irradiance: a fiftieth of a lit cloud
constexpr double kFailingFraction = 0.01;  // of the pixels
constexpr double kLargestDifference = 0.15;
constexpr double kMeanBias = 0.002;  // relative

ImageF render(const std::string& scene_name) {
  const auto scene = load_scene(std::string(NEPHELE_SOURCE_DIR) + "/tools/scenes/" + scene_name + ".json");
  REQUIRE(scene);
  const auto renderer =
      Renderer::create(test_sky(), *scene, {.width = kWidth, .height = kHeight, .quality = Quality::low});
  REQUIRE(renderer);
  (*renderer)->render(scene->camera, 0.0);
  const std::vector<float> rgba = (*renderer)->read_hdr();
  ImageF image{kWidth, kHeight, {"R", "G", "B"}, {}};
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    image.data.insert(image.data.end(), {rgba[i], rgba[i + 1], rgba[i + 2]});
  return image;
}

}  // namespace

TEST_CASE("scenes look as they did") {
  for (const std::string scene : {"fair_weather", "sunset", "above_deck", "inside_cloud"}) {
    CAPTURE(scene);
    const std::string path = std::string(NEPHELE_SOURCE_DIR) + "/tests/golden/" + scene + ".exr";
    const ImageF image = render(scene);
    if (std::getenv("NEPHELE_UPDATE_GOLDENS")) {
      REQUIRE(write_exr(path, image));
      continue;
    }
    const auto golden = read_exr(path);
    REQUIRE(golden);
    REQUIRE(golden->width == kWidth);
    REQUIRE(golden->height == kHeight);
    std::size_t failing = 0;
    double largest = 0, sum = 0, golden_sum = 0;
    for (std::size_t i = 0; i < image.data.size(); ++i) {
      const std::size_t pixel = i / 3;
      const auto channel = golden->channel_index(image.channels[i % 3]);  // files order channels by name
      REQUIRE(channel);
      const double wanted = golden->data[pixel * golden->channels.size() + *channel];
      const double difference = std::abs(image.data[i] - wanted);
      REQUIRE(std::isfinite(image.data[i]));
      failing += difference > kPixelTolerance;
      largest = std::max(largest, difference);
      sum += image.data[i];
      golden_sum += wanted;
    }
    CHECK(double(failing) / double(image.data.size()) <= kFailingFraction);
    CHECK(largest <= kLargestDifference);
    CHECK(std::abs(sum / golden_sum - 1.0) <= kMeanBias);
  }
}

TEST_CASE("two frames of one renderer, and of two, are identical") {
  const auto scene = load_scene(std::string(NEPHELE_SOURCE_DIR) + "/tools/scenes/fair_weather.json");
  REQUIRE(scene);
  std::vector<std::vector<float>> images;
  for (int maker = 0; maker < 2; ++maker) {
    const auto renderer =
        Renderer::create(test_sky(), *scene, {.width = kWidth, .height = kHeight, .quality = Quality::low});
    REQUIRE(renderer);
    for (int frame = 0; frame < 2; ++frame) {
      (*renderer)->render(scene->camera, 0.0);
      images.push_back((*renderer)->read_hdr());
    }
  }
  for (const auto& image : images) CHECK(image == images[0]);
}
