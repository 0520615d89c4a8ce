// A renderer whose scene and settings change: every frame equals a new renderer's bit for bit, nothing is compiled, and
// nothing that still fits is allocated again.
#include <doctest/doctest.h>

#include "passes/nephele.h"
#include "tests/support/test_device.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::test;

namespace {

// What a change may cost: new buffers and images, and the pipelines of what was not there before.
enum class Costs { nothing, memory, memory_and_kernels };

struct Change {
  const char* what;
  Scene scene;
  RenderSettings settings;
  double time_s = 0.0;
  Costs costs = Costs::nothing;
};

RenderSettings small() { return {.width = 64, .height = 40, .quality = Quality::low, .ring_size_cells = 40}; }

Scene fair_sky() {
  Scene scene;
  scene.clouds->view_distance_m = 12000.0f;
  scene.camera.position_m.z = 1300.0;
  return scene;
}

WeatherMap patchy_map(std::uint8_t coverage) {
  WeatherMap map{.width = 2, .height = 2, .texels = {}, .origin_m = {-8000, -8000}, .extent_m = {16000, 16000}};
  map.texels = {{coverage, 255}, {0, 255}, {10, 0}, {coverage, 128}};
  return map;
}

bool same_frame(Renderer& a, Renderer& b) {
  return a.read_hdr() == b.read_hdr() && a.read_layers() == b.read_layers() && a.read_display() == b.read_display();
}

}  // namespace

TEST_CASE("a frame after a change equals a new renderer's, and little is made for it") {
  std::vector<Change> changes;
  const auto add = [&](const char* what, Costs costs, auto&& edit) {
    Change change = changes.empty() ? Change{what, fair_sky(), small()} : changes.back();
    change.what = what;
    change.costs = costs;
    edit(change);
    changes.push_back(std::move(change));
  };
  using enum Costs;
  add("the sun", nothing, [](Change& c) { c.scene.sun.elevation_rad = 0.1; });
  add("the sun below the horizon", nothing, [](Change& c) { c.scene.sun.elevation_rad = -0.3; });
  add("noon", nothing, [](Change& c) { c.scene.sun.elevation_rad = 1.2; });
  add("a fuller sky", memory, [](Change& c) { c.scene.clouds->coverage = 0.7f; });
  add("an emptier sky", nothing, [](Change& c) { c.scene.clouds->coverage = 0.3f; });
  add("denser clouds", nothing, [](Change& c) { c.scene.clouds->extinction_per_m = 0.09f; });
  add("wind", nothing, [](Change& c) { c.scene.clouds->wind_m_per_s = {-9, 30}; });
  add("time", nothing, [](Change& c) { c.time_s = 400.0; });
  add("exposure", nothing, [](Change& c) { c.scene.exposure_ev = 1.5f; });
  add("ground", nothing, [](Change& c) { c.scene.ground.albedo = {0.5f, 0.3f, 0.1f}; });
  add("exact blend", memory, [](Change& c) { c.settings.blend = BlendMode::exact; });
  add("volume blend", nothing, [](Change& c) { c.settings.blend = BlendMode::volume; });
  add("a weather map", memory, [](Change& c) { c.scene.clouds->weather_map = patchy_map(200); });
  add("another map of the same size", memory, [](Change& c) { c.scene.clouds->weather_map = patchy_map(90); });
  add("no map", memory, [](Change& c) { c.scene.clouds->weather_map.reset(); });
  add("a first listed particle", memory_and_kernels, [](Change& c) {
    c.scene.particles = {{.center_m = {0, 900, 1350}}};
  });
  add("another place of it", memory, [](Change& c) { c.scene.particles[0].center_m.x = 150; });
  add("a larger image", memory, [](Change& c) { c.settings.width = 80; });
  add("half resolution", memory_and_kernels, [](Change& c) { c.settings.scale = 2; });
  add("no air", memory_and_kernels, [](Change& c) { c.scene.atmosphere.enabled = false; });
  add("air again", nothing, [](Change& c) { c.scene.atmosphere.enabled = true; });
  add("no clouds at all", memory_and_kernels, [](Change& c) { c.scene.clouds.reset(), c.scene.particles.clear(); });
  add("clouds again", memory, [](Change& c) { c.scene.clouds = fair_sky().clouds; });

  Device& device = test_device();
  auto changing = Renderer::create(test_sky(), fair_sky(), small());
  REQUIRE(changing);
  (*changing)->render(fair_sky().camera, 0.0);
  for (const Change& change : changes) {
    CAPTURE(std::string(change.what));
    const std::size_t pipelines = test_sky().pipeline_count();
    const std::uint64_t allocations = device.allocation_count();
    REQUIRE((*changing)->set(change.scene, change.settings));
    if (change.costs == nothing) CHECK(device.allocation_count() == allocations);
    (*changing)->render(change.scene.camera, change.time_s);
    if (change.costs != memory_and_kernels) CHECK(test_sky().pipeline_count() == pipelines);
    const auto fresh = Renderer::create(test_sky(), change.scene, change.settings);
    REQUIRE(fresh);
    (*fresh)->render(change.scene.camera, change.time_s);
    CHECK(same_frame(**changing, **fresh));
    CHECK((*changing)->stats().particles_generated == (*fresh)->stats().particles_generated);
  }
}

TEST_CASE("an error in a change leaves the renderer as it was") {
  const auto renderer = Renderer::create(test_sky(), fair_sky(), small());
  REQUIRE(renderer);
  (*renderer)->render(fair_sky().camera, 0.0);
  const std::vector<float> before = (*renderer)->read_hdr();
  RenderSettings settings = small();
  settings.scale = 3;
  CHECK_FALSE((*renderer)->set(fair_sky(), settings));
  Scene scene = fair_sky();
  scene.phase.g = 0.2;
  const auto other_phase = (*renderer)->set(scene, small());
  REQUIRE_FALSE(other_phase);
  CHECK(other_phase.error().message.find("g = 0.2") != std::string::npos);
  (*renderer)->render(fair_sky().camera, 0.0);
  CHECK((*renderer)->read_hdr() == before);
}

TEST_CASE("two renderers of one sky share its pipelines and disturb each other in nothing") {
  Scene evening = fair_sky();
  evening.sun.elevation_rad = 0.2;
  const auto alone = Renderer::create(test_sky(), evening, small());
  REQUIRE(alone);
  (*alone)->render(evening.camera, 0.0);
  const std::size_t pipelines = test_sky().pipeline_count();
  const auto a = Renderer::create(test_sky(), evening, small()), b = Renderer::create(test_sky(), fair_sky(), small());
  REQUIRE(a);
  REQUIRE(b);
  CHECK(test_sky().pipeline_count() == pipelines);
  for (int i = 0; i < 2; ++i) {
    (*a)->render(evening.camera, 0.0);
    (*b)->render(evening.camera, 0.0);
  }
  CHECK(same_frame(**a, **alone));
  CHECK((*b)->read_hdr() != (*a)->read_hdr());
}

TEST_CASE("views that take turns on one renderer each show what they show alone") {
  const auto shared = Renderer::create(test_sky(), fair_sky(), small());
  REQUIRE(shared);
  CameraState ahead = fair_sky().camera, aside = fair_sky().camera;
  aside.yaw_rad = 1.0;
  aside.position_m += glm::dvec3(3000.0, 500.0, 700.0);
  for (int i = 0; i < 2; ++i)
    for (const CameraState& view : {ahead, aside}) {
      const auto alone = Renderer::create(test_sky(), fair_sky(), small());
      REQUIRE(alone);
      (*alone)->render(view, 10.0);
      (*shared)->render(view, 10.0);
      CHECK(same_frame(**shared, **alone));
    }
}
