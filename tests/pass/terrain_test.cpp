// Terrain through its passes: distances against a walk along every pixel's ray in double precision, shadows against
// geometry, and what it may not change.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "engine/camera.h"
#include "passes/nephele.h"
#include "passes/sky/terrain.h"
#include "tests/support/sky_frame.h"
#include "tests/support/test_device.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::test;

namespace {

constexpr double kPlanetM = 6360000.0;
constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr std::uint32_t kWidth = 96, kHeight = 54;

// Heights as a share of the highest, at texels' middles counted in metres from the map's south-west corner.
Terrain terrain_of(std::uint32_t side, double extent_m, float highest_m,
                   const std::function<double(double x_m, double y_m)>& share) {
  Terrain terrain{.width = side, .height = side, .extent_m = glm::dvec2(extent_m), .highest_m = highest_m};
  for (std::uint32_t row = 0; row < side; ++row)
    for (std::uint32_t column = 0; column < side; ++column) {
      const double texel_m = extent_m / side;
      const double s = share((column + 0.5) * texel_m, (side - 1 - row + 0.5) * texel_m);
      terrain.texels.push_back(static_cast<std::uint16_t>(std::lround(std::clamp(s, 0.0, 1.0) * 65535.0)));
    }
  return terrain;
}

// Peaks, saddles and valleys of all sizes, none of them aligned with the texels.
Terrain rough_terrain() {
  Terrain terrain = terrain_of(100, 20000.0, 2500.0f, [](double x, double y) {
    return 0.30 + 0.22 * std::sin(x / 1700.0 + 0.6 * std::sin(y / 2100.0)) * std::cos(y / 1900.0) +
           0.12 * std::sin(x / 610.0 - y / 730.0) + 0.06 * std::sin(x / 270.0 + 1.3 * std::cos(y / 310.0)) +
           0.04 * std::sin((x + 2.0 * y) / 390.0);
  });
  terrain.origin_m = {-10000.0, -10000.0};
  return terrain;
}

// The surface by the words of engine/scene.h and engine/terrain_grid.h, from the texels themselves.
class Oracle {
 public:
  explicit Oracle(const Terrain& terrain)
      : terrain_(terrain), texel_m_(terrain.extent_m / glm::dvec2(terrain.width, terrain.height)) {}

  double height_m(const glm::dvec2& world_m) const {
    const glm::dvec2 texel = (world_m - terrain_.origin_m) / texel_m_ - 0.5, cell = glm::floor(texel), f = texel - cell;
    const auto at = [&](double i, double j) { return vertex_m(cell.x + i, cell.y + j); };
    return (1 - f.y) * ((1 - f.x) * at(0, 0) + f.x * at(1, 0)) + f.y * ((1 - f.x) * at(0, 1) + f.x * at(1, 1));
  }

  // Along a ray from a place, in steps of a 40th of a texel, finer near the eye, then by halving. What dips below a
  // crest for less than a step is missed.
  double hit_m(const glm::dvec3& camera_m, const glm::dvec3& direction) const {
    const auto over_m = [&](double t) {
      const glm::dvec3 p = t * direction;
      const double across = std::hypot(p.x, p.y), down = p.z + kPlanetM + camera_m.z;
      const glm::dvec2 way = across > 0 ? glm::dvec2(p) / across : glm::dvec2(0);
      const double altitude_m = std::hypot(across, down) - kPlanetM;
      return altitude_m - height_m(glm::dvec2(camera_m) + way * (kPlanetM * std::atan2(across, down)));
    };
    double before = 0.0;
    for (double t = 0.01; t < 120000.0;) {
      const double step_m = std::min(texel_m_.x / 40.0, 0.01 + 0.01 * t);
      const double over = over_m(t);
      if (over <= 0.0) {
        double low = before, high = t;
        for (int i = 0; i < 60; ++i) (over_m(0.5 * (low + high)) > 0.0 ? low : high) = 0.5 * (low + high);
        const glm::dvec3 p = high * direction;
        const glm::dvec2 place = glm::dvec2(camera_m) + glm::dvec2(p);
        const glm::dvec2 beyond_m = glm::max(terrain_.origin_m - place, place - terrain_.origin_m - terrain_.extent_m);
        return std::max(beyond_m.x, beyond_m.y) > 2050.0 ? -1.0 : high;  // the plain's: not terrain's to tell
      }
      before = t;
      t += std::max(step_m, 0.3 * (over - terrain_.highest_m));  // a ray sinks by no more than it goes
    }
    return kNothing;
  }

 private:
  double vertex_m(double i, double j) const {
    const glm::dvec2 size(terrain_.width, terrain_.height), texel(i, j);
    const glm::dvec2 outside_m = glm::max(glm::max(-0.5 - texel, texel - (size - 0.5)), 0.0) * texel_m_;
    const double away = std::min(glm::length(outside_m) / 2000.0, 1.0);
    const glm::dvec2 inside = glm::clamp(texel, glm::dvec2(0), size - 1.0);
    const auto index = static_cast<std::size_t>((size.y - 1 - inside.y) * size.x + inside.x);
    const double height_m =
        terrain_.lowest_m + (terrain_.highest_m - terrain_.lowest_m) * terrain_.texels[index] / 65535.0;
    return height_m * (1 - away * away * (3 - 2 * away));
  }

  const Terrain& terrain_;
  glm::dvec2 texel_m_;
};

shared::FrameConstants constants_of(const CameraState& camera) {
  shared::FrameConstants frame = sky_constants({.altitude_m = camera.position_m.z, .width = kWidth, .height = kHeight});
  const CameraMatrices matrices = camera_matrices(camera, double(kWidth) / kHeight);
  frame.clip_from_render = matrices.clip_from_render;
  frame.render_from_clip = matrices.render_from_clip;
  return frame;
}

std::vector<float> distances(TerrainPass& pass, const CameraState& camera, const Image* host_m = nullptr) {
  Device& device = test_device();
  const shared::FrameConstants constants = constants_of(camera);
  Buffer buffer(device, "constants", sizeof constants);
  buffer.write(std::as_bytes(std::span(&constants, 1)));
  const Image no_host(device, "no_host", {VK_FORMAT_R32_SFLOAT});
  FrameExecutor executor(device);
  FrameBuilder frame(device);
  const Image& image = pass.add_distance(frame, buffer, camera.position_m, camera.position_m,
                                         {host_m ? *host_m : no_host, no_host, host_m != nullptr});
  executor.run(frame);
  std::vector<float> result(kWidth * kHeight);
  image.read(std::as_writable_bytes(std::span(result)));
  return result;
}

glm::dvec3 direction_at(const CameraState& camera, std::uint32_t x, std::uint32_t y) {
  const glm::dmat4 m(camera_matrices(camera, double(kWidth) / kHeight).render_from_clip);
  const glm::dvec2 ndc = (glm::dvec2(x, y) + 0.5) / glm::dvec2(kWidth, kHeight) * 2.0 - 1.0;
  return glm::normalize(glm::dvec3(m * glm::dvec4(ndc, 1.0, 1.0)));
}

CameraState looking(const glm::dvec3& position_m, double yaw_deg, double pitch_deg, double fov_deg = 55.0) {
  return {.position_m = position_m,
          .yaw_rad = yaw_deg * M_PI / 180,
          .pitch_rad = pitch_deg * M_PI / 180,
          .roll_rad = 0,
          .vertical_fov_rad = fov_deg * M_PI / 180};
}

std::unique_ptr<Renderer> renderer_of(const Scene& scene, std::uint32_t width = kWidth,
                                      std::uint32_t height = kHeight) {
  auto renderer = Renderer::create(test_sky(), scene, {.width = width, .height = height, .quality = Quality::low});
  REQUIRE(renderer);
  return std::move(*renderer);
}

Scene bare_scene(const Terrain& terrain) {
  Scene scene;
  scene.clouds.reset();
  scene.terrain = terrain;
  return scene;
}

}  // namespace

TEST_CASE("terrain: distances are those along the ray, from near, from a ridge, from high, from afar") {
  Terrain terrain = rough_terrain();
  const Oracle home(terrain);
  double ridge_m = 0.0;
  glm::dvec2 ridge(0.0);
  for (double x = -6000; x < 6000; x += 190)
    for (double y = -6000; y < 6000; y += 170)
      if (home.height_m({x, y}) > ridge_m) ridge = {x, y}, ridge_m = home.height_m(ridge);
  const double here_m = home.height_m({1234.0, -321.0});
  struct View {
    std::string name;
    CameraState camera;
  };
  const View views[] = {
      {"on a slope", looking({1234.0, -321.0, here_m + 1.7}, 40, -3, 70)},
      {"on the highest ridge", looking({ridge, ridge_m + 2.0}, 200, -8, 80)},
      {"from the side, grazing", looking({-19000.0, 500.0, 900.0}, 88, -1.5, 12)},
      {"over the plain, along it", looking({-16000.0, -15000.0, 30.0}, 45, 1, 40)},
      {"20 km up", looking({3000.0, -9000.0, 20000.0}, 15, -60)},
      {"straight down", looking({500.0, 700.0, 9000.0}, 0, -90, 90)},
      {"from 90 km away", looking({0.0, -90000.0, 4000.0}, 0, -2, 8)},
  };
  for (const glm::dvec2 shift_m : {glm::dvec2(0.0), glm::dvec2(-1e7, 1e7 + 1.0 / 3.0)}) {
    CAPTURE(shift_m.x);
    terrain.origin_m = glm::dvec2(-10000.0) + shift_m;
    const Oracle oracle(terrain);
    Workshop make(test_kernels());
    TerrainPass pass(make, terrain, kWidth, kHeight);
    for (const View& view : views) {
      CAPTURE(view.name);
      CameraState camera = view.camera;
      camera.position_m += glm::dvec3(shift_m, 0.0);
      const std::vector<float> found_m = distances(pass, camera);
      std::size_t compared = 0, hits = 0, wrong = 0;
      for (std::uint32_t y = 0; y < kHeight; ++y)
        for (std::uint32_t x = 0; x < kWidth; ++x) {
          const double expected_m = oracle.hit_m(camera.position_m, direction_at(camera, x, y));
          const float got_m = found_m[y * kWidth + x];
          if (expected_m < 0.0) continue;
          ++compared;
          hits += expected_m < kNothing;
          const bool right = std::isinf(expected_m) ? std::isinf(got_m)
                                                    : std::abs(got_m - expected_m) <= std::max(1.0, 1e-3 * expected_m);
          wrong += !right;
        }
      MESSAGE(view.name, ": ", compared, " pixels compared, ", hits, " of them land, ", wrong, " wrong");
      CHECK(hits > 400);
      // Of rays that touch a crest within the float's rounding, some pass and some do not.
      CHECK(wrong * 1000 <= compared);
    }
  }
}

TEST_CASE("terrain: a camera flown a millimetre moves no silhouette by more than a pixel") {
  const Terrain terrain = rough_terrain();
  Workshop make(test_kernels());
  TerrainPass pass(make, terrain, kWidth, kHeight);
  for (const glm::dvec3& step_m : {glm::dvec3(1e-3, 0, 0), glm::dvec3(0, 1e-3, 0), glm::dvec3(0, 0, 1e-3)}) {
    const CameraState before = looking({-3000.0, -14000.0, 1500.0}, 20, 1);
    CameraState after = before;
    after.position_m += step_m;
    const std::vector<float> a = distances(pass, before), b = distances(pass, after);
    int edges = 0, torn = 0;
    for (int y = 1; y + 1 < static_cast<int>(kHeight); ++y)
      for (int x = 1; x + 1 < static_cast<int>(kWidth); ++x) {
        const float now_m = b[y * kWidth + x];
        // Some pixel about this one showed the same surface, or the sky, before.
        bool known = false, edge = false;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const float was_m = a[(y + dy) * kWidth + x + dx];
            known = known || (std::isinf(now_m) ? std::isinf(was_m) : std::abs(was_m - now_m) <= 0.2f * now_m);
            edge = edge || std::isinf(was_m) != std::isinf(now_m);
          }
        edges += edge;
        torn += !known;
      }
    CHECK(edges > 100);
    CHECK(torn == 0);
  }
}

TEST_CASE("terrain: a wall's shadow is as long as the sun is low, and straight") {
  // Texels of 50 m; the wall runs north through the middles of one column of them, 450 m high.
  const double spacing_m = 50.0, wall_x_m = 5025.0, wall_m = 450.0;
  Terrain terrain = terrain_of(200, 10000.0, 450.0f, [&](double x, double y) {
    return std::abs(x - wall_x_m) < 1.0 && y > 2500.0 && y < 7500.0 ? 1.0 : 0.0;
  });
  Scene scene = bare_scene(terrain);
  scene.atmosphere.enabled = false;
  scene.camera = looking({wall_x_m - 500.0, 5000.0, 4000.0}, 0, -90, 60);
  const auto green = [&](double elevation_deg) {
    scene.sun = {.azimuth_rad = M_PI / 2, .elevation_rad = elevation_deg * M_PI / 180, .irradiance = glm::vec3(1.0f)};
    const auto renderer = renderer_of(scene);
    renderer->render(scene.camera, 0.0);
    return renderer->read_hdr();
  };
  const std::vector<float> noon = green(89.5);
  for (const double elevation_deg : {20.0, 35.0}) {
    CAPTURE(elevation_deg);
    const std::vector<float> low = green(elevation_deg);
    const double shadow_m = wall_m / std::tan(elevation_deg * M_PI / 180);
    int lit = 0, dark = 0;
    for (std::uint32_t y = 0; y < kHeight; ++y)
      for (std::uint32_t x = 0; x < kWidth; ++x) {
        const glm::dvec3 d = direction_at(scene.camera, x, y);
        const glm::dvec3 p = scene.camera.position_m + d * (-scene.camera.position_m.z / d.z);
        const double west_m = wall_x_m - p.x;
        const bool beside = p.y > 2500.0 + 2 * spacing_m && p.y < 7500.0 - 2 * spacing_m;
        // The plain alone: off the wall's own slopes, and off the shadow's end by a spacing, over which horizons are
        // interpolated; the penumbra is narrower.
        if (!beside || std::abs(west_m) < 2 * spacing_m || std::abs(west_m - shadow_m) < spacing_m) continue;
        const std::size_t i = 4 * (y * kWidth + x) + 1;
        const double share = low[i] / (noon[i] * std::sin(elevation_deg * M_PI / 180));
        if (west_m > 0.0 && west_m < shadow_m) {
          CHECK(share < 0.02);
          ++dark;
        } else {
          CHECK(std::abs(share - 1.0) < 0.02);  // the smooth normal beside the wall, and sin 89.5
          ++lit;
        }
      }
    CHECK(dark > 200);
    CHECK(lit > 200);
  }
}

TEST_CASE("terrain without height looks as the plain does, in sun and under clouds") {
  for (const bool clouds : {false, true}) {
    CAPTURE(clouds);
    Scene scene;
    if (!clouds) scene.clouds.reset();
    scene.camera = looking({0.0, 0.0, 1000.0}, 20, -20);
    const auto plain = renderer_of(scene);
    plain->render(scene.camera, 0.0);
    const std::vector<float> expected = plain->read_hdr();
    scene.terrain = terrain_of(16, 40000.0, 0.0f, [](double, double) { return 0.0; });
    scene.terrain->origin_m = {-20000.0, -20000.0};
    const auto flat = renderer_of(scene);
    flat->render(scene.camera, 0.0);
    const std::vector<float> got = flat->read_hdr();
    double worst = 0.0, sum = 0.0, of = 0.0;
    int apart = 0, values = 0;
    for (std::size_t i = 0; i < got.size(); ++i) {
      if (i % 4 == 3) continue;
      const double error = std::abs(double{got[i]} / expected[i] - 1.0);
      worst = std::max(worst, error);
      apart += error > 0.03;
      ++values;
      sum += got[i] - expected[i];
      of += expected[i];
    }
    MESSAGE("worst ", worst, ", mean ", sum / of, ", ", apart, " of ", values, " apart");
    // Haze of a whole ray and up to a distance come from two tables, .02 apart here; and borders of fields are as sharp
    // as a pixel, whose footprint is rounded differently.
    CHECK(apart < 0.005 * values);
    CHECK(worst < 0.06);
    CHECK(std::abs(sum / of) < 0.01);
  }
}

TEST_CASE("terrain: the picture 10 000 km out is the one at home, and a flight leaves no trace") {
  Scene home = bare_scene(rough_terrain());
  home.clouds = CloudSettings{};
  home.clouds->base_m = 1600.0f;
  home.clouds->view_distance_m = 20000.0f;
  const glm::dvec3 position_m(-3000.25, -14000.5, 1900.0);
  home.camera = looking(position_m, 20, -4);
  const auto frame = [](Renderer& renderer, const CameraState& camera, double time_s) {
    renderer.render(camera, time_s);
    return renderer.read_display();
  };
  const auto here = renderer_of(home);
  const std::vector<std::uint8_t> a = frame(*here, home.camera, 60.0);
  const glm::dvec2 shift_m(-1e7, 1e7 + 1.0 / 3.0);
  Scene away = home;
  away.world_origin_m = shift_m;
  away.terrain->origin_m += shift_m;
  away.camera.position_m += glm::dvec3(shift_m, 0.0);
  const std::vector<std::uint8_t> b = frame(*renderer_of(away), away.camera, 60.0);
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.size(); ++i) different += std::abs(int{a[i]} - int{b[i]}) > 1;
  CHECK(different * 1000 <= a.size());  // crests, where the last bit of a place decides
  frame(*here, looking({4000.0, 3000.0, 3500.0}, 130, -20), 500.0);
  CHECK(frame(*here, home.camera, 60.0) == a);
}

TEST_CASE("terrain: of it and a host's scene the nearer shows") {
  Scene scene = bare_scene(rough_terrain());
  scene.atmosphere.enabled = false;
  scene.camera = looking({-3000.0, -8000.0, 2600.0}, 20, -15);  // over the map: below is land
  const auto renderer = renderer_of(scene);
  renderer->render(scene.camera, 0.0);
  const std::vector<float> alone = renderer->read_hdr();
  std::vector<float> distance_m(kWidth * kHeight, kNothing);
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth / 2; ++x) distance_m[y * kWidth + x] = x < kWidth / 4 ? 5.0f : 119000.0f;
  Image radiance(test_device(), "host_radiance", {VK_FORMAT_R32G32B32A32_SFLOAT, kWidth, kHeight});
  Image distance(test_device(), "host_distance", {VK_FORMAT_R32_SFLOAT, kWidth, kHeight});
  const std::vector<glm::vec4> grey(kWidth * kHeight, glm::vec4(3.0f));
  radiance.write(std::as_bytes(std::span(grey)));
  distance.write(std::as_bytes(std::span(distance_m)));
  renderer->render(scene.camera, 0.0, {&radiance, &distance});
  const std::vector<float> both = renderer->read_hdr();
  int land = 0;
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      const std::size_t i = 4 * (y * kWidth + x) + 1;
      if (x < kWidth / 4) CHECK(both[i] == 3.0f);
      if (x >= kWidth / 2) CHECK(both[i] == alone[i]);
      if (x >= kWidth / 4 && x < kWidth / 2 && y > kHeight * 3 / 4) {  // land before the far wall
        CHECK(both[i] == alone[i]);
        ++land;
      }
    }
  CHECK(land > 100);
}

TEST_CASE("terrain: a scene without it has none of its passes, and bad heights are refused") {
  Scene scene = bare_scene(rough_terrain());
  const auto with = renderer_of(scene);
  const auto has = [](const Renderer& renderer, const char* name) {
    const auto& passes = renderer.stats().passes;
    return std::any_of(passes.begin(), passes.end(), [&](const PassTime& pass) { return pass.name == name; });
  };
  with->render(scene.camera, 0.0);
  for (const char* pass : {"terrain_distance", "terrain_horizon", "terrain_openness", "terrain_radiance"})
    CHECK(has(*with, pass));
  with->render(looking({100.0, 0.0, 3000.0}, 0, -10), 0.0);
  CHECK(has(*with, "terrain_radiance"));
  CHECK_FALSE(has(*with, "terrain_horizon"));  // the sun has not moved
  Scene moved = scene;
  moved.sun.elevation_rad += 0.01;
  REQUIRE(with->set(moved, {.width = kWidth, .height = kHeight, .quality = Quality::low}));
  with->render(scene.camera, 0.0);
  CHECK(has(*with, "terrain_horizon"));
  CHECK_FALSE(has(*with, "terrain_openness"));  // the land has not
  scene.terrain->texels.pop_back();
  const auto refused = Renderer::create(test_sky(), scene, {.width = kWidth, .height = kHeight});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().message.starts_with("terrain"));
  scene.terrain.reset();
  const auto without = renderer_of(scene);
  without->render(scene.camera, 0.0);
  CHECK(without->describe_frame().find("terrain") == std::string::npos);
}
