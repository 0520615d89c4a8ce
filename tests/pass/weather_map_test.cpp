// The weather map through the passes: particles where it wants them, on the ground it was drawn for, whatever the
// origin, the path and the wind.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "passes/nephele.h"
#include "shared/cell_particles.h"
#include "tests/support/field_run.h"
#include "tests/support/test_device.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using nephele::shared::FieldFrame;
using nephele::shared::FrameCounters;
using nephele::test::cloud_frame;
using nephele::test::FieldRun;
using nephele::test::test_sky;

namespace {

// Three bands of 12 km from west to east, in texels of 1 km: clear, half covered, closed.
WeatherMap three_bands() {
  WeatherMap map{.width = 36, .height = 1, .origin_m = {-18000.0, -40000.0}, .extent_m = {36000.0, 80000.0}};
  for (std::uint32_t x = 0; x < map.width; ++x) map.texels.emplace_back(x < 12 ? 0 : x < 24 ? 128 : 255, 255);
  return map;
}

Scene mapped_scene(const WeatherMap& map) {
  Scene scene;
  scene.clouds->coverage = 0.0f;  // beyond the map
  scene.clouds->view_distance_m = 15000.0f;
  scene.clouds->weather_map = map;
  return scene;
}

std::unique_ptr<Renderer> make_renderer(const Scene& scene) {
  auto renderer = Renderer::create(test_sky(), scene, {.width = 64, .height = 36, .quality = Quality::low});
  REQUIRE(renderer);
  return std::move(*renderer);
}

CameraState camera_at(glm::dvec3 position_m) {
  CameraState camera;
  camera.position_m = position_m;
  camera.yaw_rad = 0.6;
  camera.pitch_rad = -0.1;
  return camera;
}

struct Frame {
  std::vector<float> layers;
  std::vector<std::uint8_t> display;
};

Frame frame_of(Renderer& renderer, const CameraState& camera, double time_s) {
  renderer.render(camera, time_s);
  return {renderer.read_layers(), renderer.read_display()};
}

}  // namespace

TEST_CASE("particles follow the map: none where it is clear, all where it is closed, half in between") {
  FieldFrame frame = cloud_frame();
  frame.field.coverage = 0.0f;
  frame.field.ring_count = 2;
  frame.field.view_distance_m = 18000.0f;
  const WeatherMap map = three_bands();
  frame.field.weather = shared::weather_placement({map.width, map.height}, map.origin_m, map.extent_m, glm::dvec2(0.0));
  FieldRun field(frame, 0, &map);
  std::vector<double> looked(3), occupied(3), expected(3);
  for (const std::uint32_t seed : {3u, 4u, 5u, 6u}) {
    frame.field.seed = seed;
    const FrameCounters counters = field.run(frame).counters;
    CHECK(counters.particle_demand == counters.particle_count);
    const auto first = field.grid().cell_first.read_vector<std::uint32_t>(shared::grid_cell_count(frame.field) + 1);
    std::vector<std::uint32_t> texels;
    for (const glm::u8vec2 t : map.texels) texels.push_back(t.x | std::uint32_t{t.y} << 8);
    shared::CloudParams params = shared::cloud_params(frame.field);
    params.weather.texels = texels.data();
    for (std::uint32_t i = 0; i + 1 < first.size(); ++i) {
      const shared::GridCell cell = shared::grid_cell(frame.field, i);
      const float x = cell.corner_m.x + 0.5f * cell.size_m;
      if (shared::cell_weight(frame, cell) <= 0.0f || std::abs(x) > 17000.0f) continue;
      // A texel and the widest reach of a cloud away from the borders between bands.
      const std::size_t band = x < -8500.0f ? 0 : x > 7500.0f ? 2 : std::abs(x) < 4500.0f ? 1 : 3;
      if (band == 3) continue;
      looked[band] += 1;
      occupied[band] += first[i + 1] > first[i];
      if (i % 7 == 0)
        expected[band] +=
            7.0 * static_cast<double>(shared::covered_share(shared::cell_cloud(frame.field, params, cell).core));
    }
  }
  for (std::size_t band = 0; band < 3; ++band) {
    CAPTURE(band);
    MESSAGE("cells ", looked[band], ", occupied ", occupied[band] / looked[band], ", covered ",
            expected[band] / looked[band]);
    REQUIRE(looked[band] > 4000);
  }
  CHECK(occupied[0] == 0.0);
  CHECK(occupied[2] / looked[2] > 0.99);
  // Four skies over less than one swell of the weather: 0.5 give or take a seventh; a cell is occupied where any of its
  // four places is.
  CHECK(expected[1] / looked[1] == doctest::Approx(128.0 / 255.0).epsilon(0.15));
  CHECK(occupied[1] >= expected[1]);
  CHECK(occupied[1] / looked[1] < 0.85);
}

TEST_CASE("the map stays over its ground while the clouds drift") {
  // Clear but for the east; the wind blows clouds out of it to the west.
  WeatherMap map{.width = 160, .height = 1, .origin_m = {-8e4, -8e4}, .extent_m = {1.6e5, 1.6e5}};
  for (int x = 0; x < 160; ++x) map.texels.emplace_back(x < 80 ? 0 : 180, 255);
  Scene scene = mapped_scene(map);
  scene.clouds->wind_m_per_s = {-12.0, 3.0};
  const auto renderer = make_renderer(scene);
  for (const double time_s : {0.0, 600.0, 86400.0}) {
    CAPTURE(time_s);
    renderer->render(camera_at({0.0, 0.0, 3000.0}), time_s);
    double west = 0, east = 0;
    for (const shared::Particle& p : renderer->read_particles())
      (p.center_m.x < 0.0f ? west : east) += p.center_m.x < -4000.0f || p.center_m.x > 4000.0f;
    CHECK(west == 0.0);
    CHECK(east > 1000.0);
  }
}

TEST_CASE("with a map, too, the picture 10 000 km out is the one at home, and a flight leaves no trace") {
  const Scene home = mapped_scene(three_bands());
  const auto here = make_renderer(home);
  const glm::dvec3 position_m(1500.25, -2000.5, 1450.0);
  const Frame a = frame_of(*here, camera_at(position_m), 3600.0);
  CHECK(std::count_if(a.layers.begin(), a.layers.end(), [](float v) { return v > 0.0f && v < 0.5f; }) > 100);
  for (const glm::dvec2 shift_m : {glm::dvec2(1e7, 0.0), glm::dvec2(-1e7, 1e7 + 1.0 / 3.0)}) {
    CAPTURE(shift_m.y);
    Scene away = home;
    away.world_origin_m = shift_m;
    away.clouds->weather_map->origin_m += shift_m;
    const Frame b = frame_of(*make_renderer(away), camera_at(position_m + glm::dvec3(shift_m, 0.0)), 3600.0);
    int largest = 0;
    for (std::size_t i = 0; i < a.display.size(); ++i)
      largest = std::max(largest, std::abs(int(a.display[i]) - int(b.display[i])));
    CHECK(largest <= 1);  // of 255
  }
  here->render(camera_at({90000.0, -31000.0, 3200.0}), 1000.0);
  here->render(camera_at({-7000.0, 3000.0, 500.0}), 7200.0);
  const Frame back = frame_of(*here, camera_at(position_m), 3600.0);
  CHECK(back.layers == a.layers);
  CHECK(back.display == a.display);
}

TEST_CASE("a camera that drifts with the wind sees the map pass below, whatever is kept between frames") {
  // Its place among the clouds is the same in both frames, to the bit; under them the clear band has come to it.
  Scene scene = mapped_scene(three_bands());
  scene.clouds->wind_m_per_s = {-16.0, 0.0};
  const auto flown = make_renderer(scene), fresh = make_renderer(scene);
  const Frame first = frame_of(*flown, camera_at({4096.0, 0.0, 1450.0}), 0.0);
  const CameraState later = camera_at({4096.0 - 16.0 * 1024.0, 0.0, 1450.0});
  const Frame arrived = frame_of(*flown, later, 1024.0), anew = frame_of(*fresh, later, 1024.0);
  CHECK(arrived.layers == anew.layers);
  CHECK(arrived.display == anew.display);
  CHECK(arrived.layers != first.layers);
}

TEST_CASE("a map that is not well-formed is refused") {
  Scene scene = mapped_scene(three_bands());
  scene.clouds->weather_map->texels.pop_back();
  const auto renderer = Renderer::create(test_sky(), scene, {.width = 64, .height = 36});
  REQUIRE_FALSE(renderer);
  CHECK(renderer.error().message.find("weather map") != std::string::npos);
}
