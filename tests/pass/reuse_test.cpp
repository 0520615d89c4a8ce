// Work that is not done again: every frame equals, bit for bit, one that does all its work.
#include <doctest/doctest.h>

#include <algorithm>

#include "passes/nephele.h"
#include "tests/support/test_device.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using nephele::test::test_device;
using nephele::test::test_sky;

namespace {

constexpr std::uint32_t kWidth = 64, kHeight = 36;

Scene windy_sky(glm::dvec2 wind_m_per_s) {
  Scene scene;
  scene.clouds->wind_m_per_s = wind_m_per_s;
  scene.clouds->view_distance_m = 20000.0f;
  return scene;
}

std::unique_ptr<Renderer> make_renderer(const Scene& scene, bool reuse) {
  auto renderer = Renderer::create(test_sky(), scene,
                                   {.width = kWidth, .height = kHeight, .quality = Quality::low, .reuse = reuse});
  REQUIRE(renderer);
  return std::move(*renderer);
}

bool same_frame(Renderer& a, Renderer& b) {
  return a.read_hdr() == b.read_hdr() && a.read_layers() == b.read_layers() && a.read_display() == b.read_display();
}

std::size_t steps_named(const Renderer& renderer, const std::string& pass) {
  const std::string plan = renderer.describe_frame();
  std::size_t count = 0;
  const std::string begin = '\n' + pass + ':';
  for (std::size_t at = plan.find(begin); at != std::string::npos; at = plan.find(begin, at + 1)) ++count;
  return count;
}

bool has_pass(const Renderer& renderer, const std::string& name) {
  const auto& passes = renderer.stats().passes;
  return std::any_of(passes.begin(), passes.end(), [&](const PassTime& pass) { return pass.name == name; });
}

}  // namespace

TEST_CASE("a flight that keeps what lasts equals one that does all its work in every frame") {
  const Scene scene = windy_sky({20.0, -7.0});
  const auto keeping = make_renderer(scene, true), working = make_renderer(scene, false);
  CameraState camera;
  camera.position_m = {-94208.0 * 1.5 - 300.0, 50.0, 1300.0};  // on a border of the grid's units, soon crossed
  std::size_t full = 0, light = 0;
  for (int frame = 0; frame < 36; ++frame) {
    camera.position_m.x += frame < 12 ? 4.0 : frame < 24 ? 61.0 : -0.5;  // slowly, over many cells, back again
    camera.position_m.z += frame % 5 == 0 ? 3.0 : 0.0;
    camera.yaw_rad += 0.11;
    keeping->render(camera, 0.5 * frame);
    working->render(camera, 0.5 * frame);
    CAPTURE(frame);
    CHECK(same_frame(*keeping, *working));
    const std::size_t all = steps_named(*working, "field"), done = steps_named(*keeping, "field");
    (done == all ? full : light) += 1;
    CHECK(has_pass(*working, "sky_view"));
    CHECK(has_pass(*keeping, "sky_view") == (frame % 5 == 0));
  }
  CHECK(full > 3);
  CHECK(light > 15);
}

TEST_CASE("a frame whose inputs are the last one's does nothing and shows the same") {
  const auto renderer = make_renderer(windy_sky({0.0, 0.0}), true), fresh = make_renderer(windy_sky({0.0, 0.0}), true);
  CameraState camera;
  camera.position_m.z = 1300.0;
  renderer->render(camera, 0.0);
  const FrameStats drawn = renderer->stats();
  renderer->render(camera, 5.0);  // no wind: time moves nothing
  CHECK(renderer->stats().passes.empty());
  CHECK(renderer->stats().particles_visible == drawn.particles_visible);
  CHECK(renderer->stats().pairs_shaded == drawn.pairs_shaded);
  fresh->render(camera, 5.0);
  CHECK(same_frame(*renderer, *fresh));
  camera.yaw_rad += 1e-3;
  renderer->render(camera, 5.0);
  CHECK(!renderer->stats().passes.empty());
  fresh->render(camera, 5.0);
  CHECK(same_frame(*renderer, *fresh));
}

TEST_CASE("a host's images are looked at in every frame") {
  const auto renderer = make_renderer(windy_sky({0.0, 0.0}), true);
  Image distance(test_device(), "distance", {VK_FORMAT_R32_SFLOAT, kWidth, kHeight});
  Image radiance(test_device(), "radiance", {VK_FORMAT_R32G32B32A32_SFLOAT, kWidth, kHeight});
  const auto paint = [](Image& image, std::vector<float> values) { image.write(std::as_bytes(std::span(values))); };
  constexpr std::size_t kPixels = std::size_t{kWidth} * kHeight;
  paint(distance, std::vector<float>(kPixels, 100.0f));
  paint(radiance, std::vector<float>(4 * kPixels, 0.1f));
  const HostScene host{&radiance, &distance};
  renderer->render({}, 0.0, host);
  const std::vector<float> grey = renderer->read_hdr();
  paint(radiance, std::vector<float>(4 * kPixels, 0.2f));
  renderer->render({}, 0.0, host);
  const std::vector<float> bright = renderer->read_hdr();
  CHECK(bright[0] > 1.5f * grey[0]);
  renderer->render({}, 0.0);
  CHECK(renderer->read_hdr() != bright);
}

TEST_CASE("a layer that is not kept at full size changes no pixel of the frame") {
  for (const bool air : {true, false}) {
    CAPTURE(air);
    Scene scene = windy_sky({0.0, 0.0});
    if (!air) scene.atmosphere.enabled = false;
    const auto render = [&](bool full_layer) {
      auto renderer = Renderer::create(
          test_sky(), scene,
          {.width = kWidth, .height = kHeight, .quality = Quality::low, .scale = 2, .full_layer = full_layer});
      REQUIRE(renderer);
      CameraState camera;
      camera.position_m.z = 1300.0;
      (*renderer)->render(camera, 0.0);
      return std::move(*renderer);
    };
    const auto kept = render(true), spared = render(false);
    CHECK(kept->cloud_color() != nullptr);
    CHECK(kept->cloud_depth() != nullptr);
    CHECK(spared->cloud_color() == nullptr);
    CHECK(spared->cloud_depth() == nullptr);
    CHECK(kept->read_hdr() == spared->read_hdr());
    CHECK(kept->read_display() == spared->read_display());
  }
}
