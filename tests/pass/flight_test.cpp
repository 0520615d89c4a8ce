// What changes from frame to frame: in a straight flight, where rings change, and while clouds grow, decay and drift
// under a weather map.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "passes/nephele.h"
#include "tests/support/test_device.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using nephele::test::test_sky;

namespace {

constexpr double kStepM = 200.0 / 60.0;  // 200 m/s at 60 frames/s
constexpr float kFirstFadeM = 8000.0f;   // the finest ring of 104 cells fades from 8.3 to 9.5 km
constexpr float kWhite = 0.31831f;       // radiance of a white surface in full sun, per unit of its irradiance

std::unique_ptr<Renderer> make_renderer(const Scene& scene, std::uint32_t ring_size_cells) {
  auto renderer = Renderer::create(
      test_sky(), scene, {.width = 160, .height = 90, .quality = Quality::low, .ring_size_cells = ring_size_cells});
  REQUIRE(renderer);
  return std::move(*renderer);
}

struct Changes {
  std::vector<double> all;
  std::vector<double> far;  // of pixels whose clouds stand where rings fade into each other, or beyond
};

std::vector<float> layers_at(Renderer& renderer, const CameraState& camera, double time_s) {
  renderer.render(camera, time_s);
  return renderer.read_layers();
}

// Per pixel, the largest change between two frames in the cloud layer's radiance and transmittance.
void add_changes(const std::vector<float>& before, const std::vector<float>& after, Changes& changes) {
  for (std::size_t i = 0; i < before.size(); i += 5) {
    double change = std::abs(double(after[i + 3]) - double(before[i + 3]));
    for (std::size_t c = 0; c < 3; ++c)
      change = std::max(change, std::abs(double(after[i + c]) - double(before[i + c])) / double(kWhite));
    changes.all.push_back(change);
    if (before[i + 4] > kFirstFadeM && after[i + 4] > kFirstFadeM && std::isfinite(before[i + 4]))
      changes.far.push_back(change);
  }
}

double percentile_999(std::vector<double> values) {
  REQUIRE(values.size() > 1000);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 999 / 1000);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

TEST_CASE("rings change without a step in flight") {
  Scene scene;
  scene.clouds->coverage = 0.4f;
  scene.clouds->view_distance_m = 20000.0f;
  const auto rings = make_renderer(scene, 104);   // three rings
  const auto finest = make_renderer(scene, 232);  // one, of the finest cells
  for (const double altitude_m : {1700.0, 4000.0}) {
    Changes with_rings, without;
    // Places where rings snap (every two cells), and others, over two kilometres.
    for (const double y : {-kStepM / 2, 184.0 - kStepM / 2, 368.0 - kStepM / 2, 470.0, 736.0 - kStepM / 2, 1033.0,
                           1472.0 - kStepM / 2, 1900.0}) {
      CameraState camera;
      camera.position_m = {0.0, y, altitude_m};
      camera.pitch_rad = altitude_m > 2000.0 ? -0.2 : 0.0;
      CameraState next = camera;
      next.position_m.y += kStepM;
      add_changes(layers_at(*rings, camera, 0.0), layers_at(*rings, next, 0.0), with_rings);
      add_changes(layers_at(*finest, camera, 0.0), layers_at(*finest, next, 0.0), without);
    }
    const auto compare = [&](const std::vector<double>& rings_changes, const std::vector<double>& finest_changes) {
      const double changed = 255.0 * percentile_999(rings_changes), expected = 255.0 * percentile_999(finest_changes);
      MESSAGE("at ", altitude_m, " m: 99.9 % of the changes are below ", changed, " / 255 with rings, ", expected,
              " / 255 without");
      CHECK(changed - expected <= 2.0);  // of 255: what an eye that follows the clouds does not notice
    };
    compare(with_rings.all, without.all);
    compare(with_rings.far, without.far);
  }
}

// Growth over half an hour at 30 frames a second, and a weather map under wind, beside clouds of one size that drift.
TEST_CASE("clouds grow, decay and drift under a weather map without a step") {
  constexpr double kFrameS = 1.0 / 30.0;
  CameraState camera;
  camera.position_m = {0.0, 0.0, 500.0};
  camera.pitch_rad = 0.14;
  Scene drifting;
  drifting.clouds->coverage = 0.35f;
  drifting.clouds->wind_m_per_s = {8.0, 3.0};
  Scene growing = drifting, mapped = drifting;
  growing.clouds->growth_period_s = 1800.0f;
  WeatherMap map{
      .width = 8, .height = 8, .texels = {}, .origin_m = {-16000.0, -16000.0}, .extent_m = {32000.0, 32000.0}};
  for (unsigned i = 0; i < 64; ++i)
    map.texels.push_back({static_cast<unsigned char>((i * 37) % 200), static_cast<unsigned char>((i * 91) % 256)});
  mapped.clouds->weather_map = map;
  const auto still = make_renderer(drifting, 104), grown = make_renderer(growing, 104),
             under_map = make_renderer(mapped, 104);
  Changes drift, growth, map_drift;
  for (const double time_s : {1.2036, 217.0, 433.4, 700.0, 901.7, 1234.5, 1500.0, 1777.7}) {
    add_changes(layers_at(*still, camera, time_s), layers_at(*still, camera, time_s + kFrameS), drift);
    add_changes(layers_at(*grown, camera, time_s), layers_at(*grown, camera, time_s + kFrameS), growth);
    add_changes(layers_at(*under_map, camera, time_s), layers_at(*under_map, camera, time_s + kFrameS), map_drift);
  }
  const double alone = 255.0 * percentile_999(drift.all);
  const double with_growth = 255.0 * percentile_999(growth.all), with_map = 255.0 * percentile_999(map_drift.all);
  MESSAGE("99.9 % of the changes are below ", alone, " / 255 in drift, ", with_growth, " with growth, ", with_map,
          " under a map");
  CHECK(with_growth - alone <= 2.0);
  CHECK(with_map - alone <= 2.0);

  // A fifth of a millisecond: once particles of a cell changed places by 100 m in it, and a pixel's transmittance by
  // 0.41.
  Scene early;
  early.clouds->seed = 2;
  early.clouds->coverage = 0.35f;
  early.clouds->base_m = early.clouds->thickness_m = 1300.0f;
  early.clouds->growth_period_s = 1800.0f;
  camera.yaw_rad = 0.8727;
  const auto renderer = make_renderer(early, 104);
  const std::vector<float> before = layers_at(*renderer, camera, 1.2036), after = layers_at(*renderer, camera, 1.2038);
  double worst = 0;
  for (std::size_t i = 3; i < before.size(); i += 5)
    worst = std::max(worst, std::abs(double(after[i]) - double(before[i])));
  MESSAGE("in 0.2 ms transmittance changes by ", worst, " at most");
  CHECK(worst < 0.02);
}
