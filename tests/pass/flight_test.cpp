// A straight flight: what a change of ring adds to the change from frame to frame.
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

// Per pixel, the largest change between two consecutive frames in the cloud layer's radiance and transmittance.
void add_changes(Renderer& renderer, CameraState camera, Changes& changes) {
  renderer.render(camera, 0.0);
  const std::vector<float> before = renderer.read_layers();
  camera.position_m.y += kStepM;
  renderer.render(camera, 0.0);
  const std::vector<float> after = renderer.read_layers();
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
      add_changes(*rings, camera, with_rings);
      add_changes(*finest, camera, without);
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
