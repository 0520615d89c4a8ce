// The sky as a flight meets it: the same far from the origin, after any path, with or without culling, and at the
// places where grids and projections are degenerate. Whole frames through the public interface.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "passes/nephele.h"
#include "shared/world.h"
#include "tests/support/support.h"
#include "tests/support/test_device.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using nephele::test::test_sky;

namespace {

constexpr RenderSettings kSmall{.width = 64, .height = 36, .quality = Quality::low};

Scene fair_weather(float view_distance_m = 80000.0f) {
  Scene scene;
  scene.clouds->coverage = 0.4f;
  scene.clouds->thickness_m = 1200.0f;
  scene.clouds->view_distance_m = view_distance_m;
  return scene;
}

CameraState camera_at(glm::dvec3 position_m, double yaw_rad, double pitch_rad) {
  CameraState camera;
  camera.position_m = position_m;
  camera.yaw_rad = yaw_rad;
  camera.pitch_rad = pitch_rad;
  return camera;
}

std::unique_ptr<Renderer> make_renderer(const Scene& scene, const RenderSettings& settings = kSmall) {
  auto renderer = Renderer::create(test_sky(), scene, settings);
  REQUIRE(renderer);
  return std::move(*renderer);
}

struct Frame {
  std::vector<float> hdr, layers;
  std::vector<std::uint8_t> display;
};

Frame frame_of(Renderer& renderer, const CameraState& camera, double time_s = 0.0) {
  renderer.render(camera, time_s);
  return {renderer.read_hdr(), renderer.read_layers(), renderer.read_display()};
}

bool same_bits(const Frame& a, const Frame& b) {
  // Transmittance and depth may be infinite but never NaN, so that == is bit for bit but for the sign of zero.
  return a.hdr == b.hdr && a.layers == b.layers && a.display == b.display;
}

int largest_step(const Frame& a, const Frame& b) {
  int largest = 0;
  for (std::size_t i = 0; i < a.display.size(); ++i)
    largest = std::max(largest, std::abs(int(a.display[i]) - int(b.display[i])));
  return largest;
}

// Of the cloud layer, light and transmittance.
double largest_difference(const Frame& a, const Frame& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.layers.size(); ++i)
    if (i % 5 != 4) largest = std::max(largest, double(std::abs(a.layers[i] - b.layers[i])));
  return largest;
}

bool clouds_show(const Frame& frame) {
  std::size_t covered = 0;
  for (std::size_t i = 3; i < frame.layers.size(); i += 5) covered += frame.layers[i] < 0.5f;
  return covered > frame.layers.size() / 5 / 100;
}

// Every value a number, light not negative, transmittance within [0, 1], nothing lost.
void check_well_formed(const Renderer& renderer, const Frame& frame) {
  std::size_t bad = 0;
  for (const float v : frame.hdr) bad += !(std::isfinite(v) && v >= 0.0f);
  for (std::size_t i = 0; i < frame.layers.size(); i += 5) {
    for (std::size_t c = 0; c < 3; ++c) bad += !(std::isfinite(frame.layers[i + c]) && frame.layers[i + c] >= 0.0f);
    bad += !(frame.layers[i + 3] >= 0.0f && frame.layers[i + 3] <= 1.0f);
    bad += !(frame.layers[i + 4] >= 0.0f);  // +inf without matter
  }
  CHECK(bad == 0);
  for (const auto& [buffer, lost] : renderer.stats().overflow) {
    CAPTURE(buffer);
    CHECK(lost == 0);
  }
}

}  // namespace

TEST_CASE("the picture 10 000 km out is the one at home") {
  Scene home = fair_weather();
  home.particles.resize(1);
  home.particles[0].center_m = {-120.0, 900.0, 1500.0};
  home.particles[0].ellipsoid.diagonal_m = {150.0f, 100.0f, 80.0f};
  for (const glm::dvec2 shift_m : {glm::dvec2(1e7, 0.0), glm::dvec2(-1e7, 1e7 + 1.0 / 3.0)}) {
    CAPTURE(shift_m.y);
    Scene away = home;
    away.world_origin_m = shift_m;
    away.particles[0].center_m += glm::dvec3(shift_m, 0.0);
    const auto here = make_renderer(home), there = make_renderer(away);
    for (const double time_s : {0.0, 3600.0}) {
      CameraState camera = camera_at({35.25, -72.5, 1450.0}, 0.3, 0.05);
      const Frame a = frame_of(*here, camera, time_s);
      camera.position_m += glm::dvec3(shift_m, 0.0);
      const Frame b = frame_of(*there, camera, time_s);
      CHECK(clouds_show(a));
      CHECK(largest_step(a, b) <= 1);  // of 255
    }
  }
}

TEST_CASE("where the grid's origin snaps to the next unit nothing is seen of it") {
  // Beyond half a unit the same places are counted from another origin: floats round differently by up to 4 mm.
  const auto renderer = make_renderer(fair_weather());
  const double border_m = 0.5 * double(shared::kOriginUnitM);
  const Frame before = frame_of(*renderer, camera_at({border_m - 1e-3, 0.0, 1400.0}, 1.2, 0.05));
  const Frame after = frame_of(*renderer, camera_at({border_m + 1e-3, 0.0, 1400.0}, 1.2, 0.05));
  CHECK(clouds_show(before));
  CHECK(largest_step(before, after) <= 2);  // of 255: the millimetres, and the camera's own two
}

TEST_CASE("a frame after an hour's flight is the frame rendered fresh there") {
  const Scene scene = fair_weather();
  for (const Backend backend : {Backend::tiled, Backend::attachment}) {
    RenderSettings settings = kSmall;
    settings.backend = backend;
    const auto flown = make_renderer(scene, settings);
    const CameraState end = camera_at({720000.0, -31000.0, 3200.0}, 2.0, -0.1);
    for (int stop = 0; stop < 8; ++stop) {
      const double way = stop / 8.0;
      flown->render(
          camera_at(end.position_m * way + glm::dvec3(0, 0, 2.0 + 900.0 * (stop % 3)), 0.8 * stop, 0.3 - 0.2 * stop),
          3600.0 * way);
    }
    const Frame arrived = frame_of(*flown, end, 3600.0);
    const auto fresh = make_renderer(scene, settings);
    CHECK(clouds_show(arrived));
    CHECK(same_bits(arrived, frame_of(*fresh, end, 3600.0)));
  }
}

TEST_CASE("culling changes no bit of the picture") {
  const Scene scene = fair_weather(4000.0f);  // 200 cameras take a while, and all that is out of view is lit
  RenderSettings settings{.width = 48, .height = 27, .quality = Quality::low};
  int cameras = 0;
  double largest = 0.0;  // difference of the layer
  SUBCASE("attachment: bit for bit") {
    settings.backend = Backend::attachment;
    cameras = 200;
  }
  SUBCASE("tiled: lists may hold more that covers nothing, which moves the place where a ray stops") {
    settings.backend = Backend::tiled;
    cameras = 30;
    largest = 1e-4;  // what the early end may cost (tiled_blend.h)
  }
  const auto culled = make_renderer(scene, settings);
  settings.culling = false;
  const auto whole = make_renderer(scene, settings);
  std::mt19937 random(77);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int with_clouds = 0;
  std::uint64_t spared = 0;
  for (int view = 0; view < cameras; ++view) {
    CAPTURE(view);
    CameraState camera = camera_at({1e5 * unit(random), 1e5 * unit(random), 1500.0 + 1499.0 * unit(random)},
                                   3.2 * unit(random), 1.5 * std::pow(unit(random), 3));
    if (view % 10 == 0) camera.position_m.z = 10000.0 + 6000.0 * unit(random);
    camera.roll_rad = 3.2 * unit(random);
    camera.vertical_fov_rad = 0.9 + 0.8 * unit(random);
    const Frame a = frame_of(*culled, camera, 1000.0 * view), b = frame_of(*whole, camera, 1000.0 * view);
    if (largest == 0.0)
      CHECK(same_bits(a, b));
    else
      CHECK(largest_difference(a, b) <= largest);
    with_clouds += clouds_show(a);
    spared += whole->stats().particles_visible - culled->stats().particles_visible;
  }
  CHECK(with_clouds > cameras / 2);
  CHECK(spared > 200u * static_cast<std::uint64_t>(cameras));
}

TEST_CASE("degenerate places and settings give well-formed frames") {
  const double cell_m = 184.0;
  struct Case {
    const char* name;
    CameraState camera;
    float coverage = 0.4f, thickness_m = 1200.0f, view_distance_m = 80000.0f;
    bool clouds = true;  // expected in the picture
  };
  const double up = std::numbers::pi / 2;
  const Case cases[] = {
      {.name = "on a cell corner", .camera = camera_at({cell_m * 8, -cell_m * 16, 1500.0}, 0.0, 0.0)},
      {.name = "on a ring's snapping border", .camera = camera_at({cell_m, cell_m, 1500.0}, 1.0, 0.0)},
      {.name = "straight up", .camera = camera_at({300.0, 200.0, 2.0}, 0.7, up), .coverage = 0.9f},
      {.name = "straight down", .camera = camera_at({300.0, 200.0, 9000.0}, 0.7, -up)},
      {.name = "10 cm above the ground", .camera = camera_at({0.0, 0.0, 0.1}, 0.0, 0.1)},
      {.name = "clear", .camera = camera_at({0.0, 0.0, 1500.0}, 0.0, 0.1), .coverage = 0.0f, .clouds = false},
      {.name = "overcast", .camera = camera_at({0.0, 0.0, 500.0}, 0.0, 0.3), .coverage = 1.0f},
      {.name = "1 m thick", .camera = camera_at({0.0, 0.0, 500.0}, 0.0, 0.1), .thickness_m = 1.0f, .clouds = false},
      {.name = "15 km thick", .camera = camera_at({0.0, 0.0, 500.0}, 0.0, 0.3), .thickness_m = 15000.0f},
      {.name = "a view distance below a cell",
       .camera = camera_at({0.0, 0.0, 1500.0}, 0.0, 0.1),
       .view_distance_m = 50.0f,
       .clouds = false},
      {.name = "in the middle of the layer", .camera = camera_at({500.0, 0.0, 1500.0}, 0.0, 0.1), .coverage = 1.0f},
      {.name = "from 200 km",
       .camera = camera_at({0.0, 0.0, 200000.0}, 0.0, -1.2),
       .view_distance_m = 200000.0f,
       .clouds = false},
  };
  for (const Case& c : cases) {
    CAPTURE(std::string(c.name));
    Scene scene = fair_weather(c.view_distance_m);
    scene.clouds->coverage = c.coverage;
    scene.clouds->thickness_m = c.thickness_m;
    const auto renderer = make_renderer(scene);
    const Frame frame = frame_of(*renderer, c.camera);
    check_well_formed(*renderer, frame);
    if (c.clouds) CHECK(clouds_show(frame));
    // A step of a millimetre: degenerate places are not edges.
    CameraState moved = c.camera;
    moved.position_m += glm::dvec3(1e-3, -1e-3, 0.0);
    CHECK(largest_step(frame, frame_of(*renderer, moved)) <= 3);  // of 255: float rounding of places at the silhouettes
  }
}
