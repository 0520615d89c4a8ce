// Clouds around what a host has drawn: a scene's depth cuts particles where it stands, hides what lies behind, and its
// edges stay sharp when the cloud layer is coarser than the image.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "passes/nephele.h"
#include "tests/support/layer_scene.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::test;

namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();

// A host's images: distance and grey radiance of every pixel.
struct Host {
  Host(std::uint32_t width, std::uint32_t height, const std::vector<float>& distance_m, float radiance)
      : radiance_image(test_device(), "host_radiance", {VK_FORMAT_R32G32B32A32_SFLOAT, width, height}),
        distance_image(test_device(), "host_distance", {VK_FORMAT_R32_SFLOAT, width, height}) {
    const std::vector<glm::vec4> grey(width * height, glm::vec4(radiance));
    radiance_image.write(std::as_bytes(std::span(grey)));
    distance_image.write(std::as_bytes(std::span(distance_m)));
  }
  HostScene scene() const { return {&radiance_image, &distance_image}; }

  Image radiance_image, distance_image;
};

constexpr std::uint32_t kWidth = 64, kHeight = 36;

Scene cloudy() {
  Scene scene;
  scene.clouds->coverage = 0.9f;
  scene.clouds->view_distance_m = 20000.0f;
  return scene;
}

std::unique_ptr<Renderer> make_renderer(const Scene& scene, std::uint32_t scale = 1) {
  auto renderer = Renderer::create(test_sky(), scene,
                                   {.width = kWidth, .height = kHeight, .quality = Quality::low, .scale = scale});
  REQUIRE(renderer);
  return std::move(*renderer);
}

}  // namespace

TEST_CASE("a scene cuts particles at its depth, pixel by pixel, in every blend") {
  std::mt19937 random(12);
  std::uniform_real_distribution<float> u(0, 1);
  const LayerSize size;
  std::vector<float> scene_m(size.width * size.height);
  for (float& d : scene_m) d = u(random) < 0.1f ? kNothing : 250.0f + 400.0f * u(random);
  std::vector<shared::Particle> pair = {emissive({-20, 400, 0}, {120, 100, 80}, 0.008f, {1, 0.5f, 0.2f}),
                                        emissive({30, 460, 10}, {100, 130, 70}, 0.02f, {0.2f, 0.5f, 1})};
  std::vector<shared::Particle> crowd;
  for (int i = 0; i < 60; ++i)
    crowd.push_back(emissive({300 * (u(random) - 0.5f), 300 + 300 * u(random), 150 * (u(random) - 0.5f)},
                             glm::vec3(20 + 60 * u(random)), 0.02f * u(random), {u(random), u(random), u(random)}));
  for (const Backend backend : {Backend::attachment, Backend::tiled, Backend::interlock}) {
    if (!backend_available(test_device().info(), backend)) continue;
    CAPTURE(backend_name(backend));
    const Layer layer = draw_layer(pair, kLevelCamera, backend, BlendMode::volume, size, 1, &scene_m);
    // The tolerances of the same scenes without a cut.
    CHECK(layer_error(layer, oracle_layer(pair, kLevelCamera, size, &scene_m), 1e-3).failing <= 0.001);
  }
  const LayerError exact =
      layer_error(draw_layer(crowd, kLevelCamera, Backend::tiled, BlendMode::exact, size, 1, &scene_m),
                  oracle_layer(crowd, kLevelCamera, size, &scene_m), 2e-4);
  CHECK(exact.failing <= 0.001);
  CHECK(exact.worst <= 1e-2);
}

TEST_CASE("a host that has drawn nothing changes nothing") {
  const Scene scene = cloudy();
  const auto renderer = make_renderer(scene);
  renderer->render(scene.camera, 0.0);
  const std::vector<float> alone = renderer->read_hdr();
  for (const float nothing :
       {kNothing, -1.0f, std::nanf("")}) {  // a cleared buffer may hold anything that is no distance
    const Host host(kWidth, kHeight, std::vector<float>(kWidth * kHeight, nothing), 7.0f);
    renderer->render(scene.camera, 0.0, host.scene());
    CHECK(renderer->read_hdr() == alone);
  }
  renderer->render(scene.camera, 0.0);
  CHECK(renderer->read_hdr() == alone);
}

// With a host every tile of the image is composed by the kernel that knows of everything, without one by that of its
// kind.
TEST_CASE("a tile of sky, with clouds or none, is composed as one that may show anything") {
  Scene scene = cloudy();
  scene.clouds->coverage = 0.3f;  // clear tiles too
  scene.camera.position_m.z = 300.0;
  scene.camera.pitch_rad = 0.6;
  const Host host(kWidth, kHeight, std::vector<float>(kWidth * kHeight, kNothing), 7.0f);
  for (const std::uint32_t scale : {1u, 2u, 4u}) {
    for (const bool sun_in_view : {false, true}) {
      CAPTURE(scale);
      CAPTURE(sun_in_view);
      scene.sun.azimuth_rad = sun_in_view ? scene.camera.yaw_rad : scene.camera.yaw_rad + 2.0;
      scene.sun.elevation_rad = 0.6;
      const auto renderer = make_renderer(scene, scale);
      renderer->render(scene.camera, 0.0);
      const std::vector<float> alone = renderer->read_hdr(), layers = renderer->read_layers();
      const std::vector<std::uint8_t> display = renderer->read_display();
      renderer->render(scene.camera, 0.0, host.scene());
      CHECK(renderer->read_hdr() == alone);
      CHECK(renderer->read_display() == display);
      const std::vector<float> mixed = renderer->read_layers();
      float worst = 0.0f, clearest = 0.0f, densest = 1.0f;
      for (std::size_t i = 0; i < layers.size(); ++i)
        if (i % 5 < 4)
          worst = std::max(worst, std::abs(layers[i] - mixed[i]));  // clear tiles are 1, not a weighted sum of ones
      for (std::size_t i = 3; i < layers.size(); i += 5) {
        clearest = std::max(clearest, layers[i]);
        densest = std::min(densest, layers[i]);
      }
      CHECK(worst <= 1e-6f);
      CHECK(clearest == 1.0f);
      CHECK(densest < 0.5f);
    }
  }
}

TEST_CASE("a wall hides clouds, sky and ground, and the air takes its share of it") {
  Scene scene = cloudy();
  scene.camera.position_m.z = 300.0;  // below the clouds
  for (const bool air : {true, false}) {
    CAPTURE(air);
    scene.atmosphere.enabled = air;
    const auto renderer = make_renderer(scene);
    const Host near_wall(kWidth, kHeight, std::vector<float>(kWidth * kHeight, 0.5f), 0.3f);
    renderer->render(scene.camera, 0.0, near_wall.scene());
    const std::vector<float> near_hdr = renderer->read_hdr();
    for (std::size_t i = 0; i < near_hdr.size(); i += 4)
      REQUIRE(near_hdr[i + 1] == doctest::Approx(0.3f).epsilon(1e-3));
    // 15 km of air dim a bright wall, blue more than red, and veil a black one, more in blue than in red.
    scene.clouds->coverage = 0.0f;
    const auto clear = make_renderer(scene);
    const std::vector<float> far_m(kWidth * kHeight, 15000.0f);
    clear->render(scene.camera, 0.0, Host(kWidth, kHeight, far_m, 1.0f).scene());
    const std::vector<float> bright = clear->read_hdr();
    clear->render(scene.camera, 0.0, Host(kWidth, kHeight, far_m, 0.0f).scene());
    const std::vector<float> dark = clear->read_hdr();
    const std::size_t middle = 4 * (kWidth * kHeight / 2 + kWidth / 2);
    const glm::vec3 through(bright[middle] - dark[middle], bright[middle + 1] - dark[middle + 1],
                            bright[middle + 2] - dark[middle + 2]);
    if (air) {
      CHECK(through.x < 0.97f);
      CHECK(through.z < through.x);
      CHECK(through.z > 0.1f);
      CHECK(dark[middle + 2] > dark[middle]);
      CHECK(dark[middle] > 1e-3f);
    } else {
      CHECK(through == glm::vec3(1.0f));
      CHECK(dark[middle] == 0.0f);
    }
    scene.clouds->coverage = 0.9f;
  }
}

TEST_CASE("a coarse cloud layer keeps the host's edges sharp") {
  Scene scene = cloudy();
  scene.atmosphere.enabled = false;
  scene.camera.pitch_rad = 0.35;
  scene.camera.position_m.z = 300.0;
  std::vector<float> distance_m(kWidth * kHeight, kNothing);
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < 31; ++x) distance_m[y * kWidth + x] = 2.0f;  // off the coarse pixels' borders
  const Host half(kWidth, kHeight, distance_m, 0.0f);
  for (const std::uint32_t scale : {2u, 4u}) {
    CAPTURE(scale);
    const auto renderer = make_renderer(scene, scale);
    renderer->render(scene.camera, 0.0);
    const std::vector<float> open = renderer->read_layers();
    renderer->render(scene.camera, 0.0, half.scene());
    const std::vector<float> cut = renderer->read_layers();
    double bled = 0.0, lost = 0.0, opacity = 0.0;
    for (std::uint32_t y = 0; y < kHeight; ++y)
      for (std::uint32_t x = 0; x < kWidth; ++x) {
        const std::size_t t = 5 * (y * kWidth + x) + 3;
        if (x < 31)
          bled = std::max(bled, 1.0 - cut[t]);
        else {
          lost += std::abs(cut[t] - open[t]);
          opacity += 1.0 - open[t];
        }
      }
    CHECK(opacity > 100.0);        // of some 1 200 pixels
    CHECK(bled < 0.02);            // no cloud before the wall
    CHECK(lost < 0.02 * opacity);  // none eaten beside it
  }
}
