// The tiled backend: its exact blend against the integral, its volume blend against the raster one, and its lists.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "shared/blend.h"
#include "tests/support/layer_scene.h"
#include "tests/support/shapes.h"

using namespace nephele;
using namespace nephele::test;
using shared::Particle;

namespace {

struct Crowd {
  int count;
  bool spread;         // over the whole view, or heaped on one place
  bool around_camera;  // the camera stands in the middle of it
};

std::vector<Particle> crowd(const Crowd& kind, std::uint32_t seed) {
  std::mt19937 random(seed), turns(seed + 1000);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> particles;
  for (int i = 0; i < kind.count; ++i) {
    const glm::vec3 offset = (kind.spread ? 600.0f : 120.0f) * (glm::vec3(u(random), u(random), u(random)) - 0.5f);
    const glm::vec3 center = offset + glm::vec3(0, kind.around_camera ? 0 : 450, 0);
    const glm::vec3 radius = glm::vec3(20 + 80 * u(random), 20 + 80 * u(random), 20 + 60 * u(random));
    // From nearly nothing to opaque; a crowd together stays within a few optical depths or far beyond.
    Particle p = emissive(center, radius, std::exp2(-12 + 9 * u(random)), {u(random), u(random), u(random)});
    p.shape = test::shape_along(test::random_axes(turns), glm::dvec3(radius));
    particles.push_back(p);
  }
  return particles;
}

LayerError exact_error(const std::vector<Particle>& particles, LayerSize size = {},
                       const CameraState& camera = kLevelCamera) {
  const Layer layer = draw_layer(particles, camera, Backend::tiled, BlendMode::exact, size);
  CHECK(layer.pairs_lost == 0);
  CHECK(layer.rays_cut_short == 0);
  return layer_error(layer, oracle_layer(particles, camera, size), 2e-4);
}

// The pixels that are opaque in the truth, or those that are not; the others cleared.
Layer pixels_of(Layer layer, const Layer& truth, bool opaque) {
  for (std::size_t i = 0; i < layer.color.size(); ++i)
    if ((truth.color[i].w < shared::kOpaqueTransmittance) != opaque) layer.color[i] = glm::vec4(0);
  return layer;
}

std::vector<Particle> shell(int count, float extinction_per_m, bool coincident) {
  std::vector<Particle> particles;
  for (int i = 0; i < count; ++i) {
    const float radius = coincident ? 100.0f : 20.0f + 80.0f * float(i + 1) / float(count);
    particles.push_back(emissive({0, 300, 0}, glm::vec3(radius), extinction_per_m,
                                 {float(i % 3) / 2, float(i % 5) / 4, float(i % 7) / 6}));
  }
  return particles;
}

// Wide, thin and one behind the other, six deep in each other. All together a few optical depths.
std::vector<Particle> layers(int count) {
  std::vector<Particle> particles;
  for (int i = 0; i < count; ++i) {
    particles.push_back(emissive({0, 1000 + 2.0f * float(i), 0}, {6000, 6, 6000}, 0.4f / float(count),
                                 {float(i % 2), float(i) / float(count), 0.5f}));
    particles.back().shape = {glm::vec3(6000, 6, 6000), glm::vec3(0)};
  }
  return particles;
}

CameraState narrow_camera() {
  CameraState narrow = kLevelCamera;
  narrow.vertical_fov_rad = 0.05;
  return narrow;
}

constexpr LayerSize kOneTile{8, 8};

// Places in each tile's list.
std::vector<std::uint32_t> list_lengths(const std::vector<Particle>& particles, const CameraState& camera,
                                        LayerSize size) {
  const shared::FrameConstants frame = layer_constants(camera, size);
  const glm::uvec2 tiles = (frame.layer_size_px + shared::kScreenTilePx - 1u) / shared::kScreenTilePx;
  std::vector<std::uint32_t> lengths(tiles.x * tiles.y);
  for (const Particle& p : particles) {
    const glm::uvec2 covered = shared::tiles_of_pixels(
        shared::screen_pixels(frame.clip_from_render, glm::mat3(test::matrix_of(p.shape)), p.center_m,
                              frame.image_size_px, frame.scale, frame.layer_size_px));
    const glm::uvec2 low = shared::rectangle_low(covered), past = shared::rectangle_high(covered);
    for (std::uint32_t y = low.y; y < past.y; ++y)
      for (std::uint32_t x = low.x; x < past.x; ++x) ++lengths[y * tiles.x + x];
  }
  return lengths;
}

}  // namespace

TEST_CASE("the exact blend is the integral: spread and heaped crowds, from outside and from inside") {
  for (const int count : {2, 3, 8, 64, 1000})
    for (const bool spread : {true, false})
      for (const bool around_camera : {false, true}) {
        CAPTURE(count);
        CAPTURE(spread);
        CAPTURE(around_camera);
        const LayerError error = exact_error(crowd({count, spread, around_camera}, 10 + count));
        CHECK(error.failing <= 0.001);
        CHECK(error.worst < 1e-2);
      }
}

TEST_CASE("the exact blend: hundreds of thin particles on a pixel") {
  std::mt19937 random(13);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> particles;
  for (int i = 0; i < 400; ++i)
    particles.push_back(emissive(200.0f * (glm::vec3(u(random), u(random), u(random)) - 0.5f) + glm::vec3(0, 440, 0),
                                 glm::vec3(30 + 40 * u(random)), 2e-4f, {u(random), u(random), u(random)}));
  const LayerError error = exact_error(particles);
  CHECK(error.failing <= 0.001);
  CHECK(error.worst < 1e-2);
}

TEST_CASE("the exact blend: coincident and concentric particles, thin to opaque") {
  for (const bool coincident : {true, false})
    for (const float extinction : {1e-7f, 1e-3f, 1e4f}) {
      CAPTURE(coincident);
      CAPTURE(extinction);
      const LayerError error = exact_error(shell(40, extinction, coincident));
      CHECK(error.failing <= 0.001);
      CHECK(error.worst < 1e-2);
    }
}

TEST_CASE("the exact blend: from a centimetre to 100 km in one picture") {
  const std::vector<Particle> sizes = {emissive({0, 2e5f, 2e4f}, glm::vec3(1e5f), 1e-6f, {1, 0.8f, 0.6f}),
                                       emissive({-2e3f, 8e3f, 500}, {2e3f, 1e3f, 500}, 1e-3f, {0.2f, 0.8f, 1}),
                                       emissive({20, 100, -5}, {10, 10, 5}, 0.1f, {1, 0.2f, 0.2f}),
                                       emissive({0.02f, 0.1f, 0.01f}, glm::vec3(0.01f), 100, {0.3f, 1, 0.3f}),
                                       emissive({-0.05f, 0.3f, 0}, {0.1f, 0.1f, 0.01f}, 3, {1, 1, 1})};
  const LayerError error = exact_error(sizes);
  CHECK(error.failing <= 0.001);
  CHECK(error.worst < 1e-2);
}

TEST_CASE("zero density changes nothing") {
  const std::vector<Particle> one = {emissive({0, 300, 0}, glm::vec3(80), 0.01f, {1, 0.5f, 0})};
  std::vector<Particle> with_nothing = one;
  with_nothing.push_back(emissive({10, 300, 0}, glm::vec3(80), 0, {9, 9, 9}));
  // 1e-6: one more place in the list is one more point where a chord's integral is cut in two.
  CHECK(layer_error(draw_layer(one, kLevelCamera, Backend::tiled, BlendMode::exact),
                    draw_layer(with_nothing, kLevelCamera, Backend::tiled, BlendMode::exact), 1e-6)
            .failing == 0);
}

// 4096 are one page of a list, 4097 two; 70 000 more than the rounds that lavapipe lets a loop go.
TEST_CASE("thousands of layers on a pixel are all counted") {
  for (const int count : {4096, 4097, 20000, 70000}) {
    CAPTURE(count);
    const std::vector<Particle> particles = layers(count);
    const LayerError error = exact_error(particles, kOneTile, narrow_camera());
    CHECK(error.failing == 0);
    const Layer volume = draw_layer(particles, narrow_camera(), Backend::tiled, BlendMode::volume, kOneTile);
    CHECK(volume.rays_cut_short == 0);
    if (backend_available(test_device().info(), Backend::attachment))
      CHECK(layer_error(volume,
                        draw_layer(particles, narrow_camera(), Backend::attachment, BlendMode::volume, kOneTile), 1e-3)
                .failing == 0);
  }
}

TEST_CASE(
    "a heap of thousands on a pixel: the volume blend is the raster's, the exact one merges and keeps every optical "
    "depth") {
  std::mt19937 random(17);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> heap;
  for (int i = 0; i < 6000; ++i)
    heap.push_back(emissive({20 * (u(random) - 0.5f), 500 + 600 * u(random), 20 * (u(random) - 0.5f)},
                            glm::vec3(30 + 30 * u(random)), 1e-5f * u(random), {u(random), u(random), u(random)}));
  const Layer exact = draw_layer(heap, narrow_camera(), Backend::tiled, BlendMode::exact, kOneTile),
              truth = oracle_layer(heap, narrow_camera(), kOneTile);
  CHECK(exact.rays_cut_short == 0);
  for (std::size_t i = 0; i < truth.color.size(); ++i)
    CHECK(exact.color[i].w == doctest::Approx(truth.color[i].w).epsilon(1e-4));
  // Only the order within merged segments is lost: random colours of mean 1/2 are off by far less.
  CHECK(layer_error(exact, truth, 1.0).worst < 0.01);
  const Layer volume = draw_layer(heap, narrow_camera(), Backend::tiled, BlendMode::volume, kOneTile);
  CHECK(volume.rays_cut_short == 0);
  if (!backend_available(test_device().info(), Backend::attachment)) return;
  CHECK(layer_error(volume, draw_layer(heap, narrow_camera(), Backend::attachment, BlendMode::volume, kOneTile), 1e-3)
            .failing == 0);
}

// What lies behind opaque matter is left out tiled, but in raster order mixed into what it overlaps, hidden or not.
TEST_CASE(
    "the volume blend is the same picture tiled and in raster order, and behind opaque matter nearer to the truth") {
  if (!backend_available(test_device().info(), Backend::attachment)) return;
  int opaque_pixels = 0;
  for (const int count : {2, 8, 64, 1000})
    for (const bool spread : {true, false})
      for (const bool around_camera : {false, true}) {
        CAPTURE(count);
        CAPTURE(spread);
        CAPTURE(around_camera);
        const std::vector<Particle> particles = crowd({count, spread, around_camera}, 10 + count);
        const Layer truth = oracle_layer(particles, kLevelCamera);
        const Layer tiled = draw_layer(particles, kLevelCamera, Backend::tiled),
                    raster = draw_layer(particles, kLevelCamera, Backend::attachment);
        CHECK(layer_error(pixels_of(tiled, truth, false), pixels_of(raster, truth, false), 1e-3).failing <= 0.001);
        const Layer opaque = pixels_of(truth, truth, true);
        const double off = layer_error(pixels_of(tiled, truth, true), opaque, 1e-3).rmse;
        CHECK(off <= 1.001 * layer_error(pixels_of(raster, truth, true), opaque, 1e-3).rmse + 1e-5);
        opaque_pixels += int(std::count_if(truth.color.begin(), truth.color.end(),
                                           [](const glm::vec4& c) { return c.w < shared::kOpaqueTransmittance; }));
      }
  CHECK(opaque_pixels > 1000);
}

// On a CPU a thread keeps the segments of a column of eight pixels on a stack of 256. A pixel whose segments do not fit
// is started again on an empty stack: with 32 layers all eight pixels fit, with 33 the last one does not, with 256 each
// pixel fills the stack alone. 257 layers make a long list; 1 025 are more than a pixel looks at on its way forward.
TEST_CASE("the volume blend of a tile is the raster's however many layers its pixels have") {
  if (!backend_available(test_device().info(), Backend::attachment)) return;
  for (const int count : {32, 33, 43, 256, 257, 1025}) {
    CAPTURE(count);
    const std::vector<Particle> particles = layers(count);
    const Layer tiled = draw_layer(particles, narrow_camera(), Backend::tiled, BlendMode::volume, kOneTile);
    CHECK(tiled.pairs_shaded >= 64u * static_cast<unsigned>(count));
    CHECK(layer_error(tiled, draw_layer(particles, narrow_camera(), Backend::attachment, BlendMode::volume, kOneTile),
                      1e-4)
              .failing == 0);
  }
}

TEST_CASE("tiles with short, long and paged lists stand side by side") {
  if (!backend_available(test_device().info(), Backend::attachment)) return;
  const LayerSize odd{91, 61};  // tiles hang over two edges
  std::mt19937 random(23);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> particles = crowd({60, true, false}, 23);
  const auto heap = [&](int count, std::uint32_t pixel_x, std::uint32_t pixel_y) {
    const glm::vec3 ray(pixel_ray(kLevelCamera, odd, pixel_x, pixel_y));
    for (int i = 0; i < count; ++i)
      particles.push_back(emissive((500 + 300 * u(random)) * ray, glm::vec3(4 + 4 * u(random)), 2e-4f,
                                   {u(random), u(random), u(random)}));
  };
  heap(4200, 20, 12);
  heap(4100, 76, 59);
  for (int i = 0; i < 12; ++i) heap(150 + 60 * i, 4 + 7 * i, 30 + 13 * (i % 3));
  const std::vector<std::uint32_t> lengths = list_lengths(particles, kLevelCamera, odd);
  CHECK(std::count_if(lengths.begin(), lengths.end(), [](auto n) { return n > shared::kPagePlaces; }) >= 2);
  CHECK(std::count_if(lengths.begin(), lengths.end(),
                      [](auto n) { return n > shared::kColumnPlaces && n <= shared::kPagePlaces; }) >= 6);
  const Layer raster = draw_layer(particles, kLevelCamera, Backend::attachment, BlendMode::volume, odd);
  const Layer tiled = draw_layer(particles, kLevelCamera, Backend::tiled, BlendMode::volume, odd);
  CHECK(tiled.rays_cut_short == 0);
  CHECK(tiled.pairs_lost == 0);
  CHECK(layer_error(tiled, raster, 1e-3).failing <= 0.001);
  CHECK(layer_error(tiled, raster, 1e-3).worst < 1e-2);
  // Transmittance is the same in any order: of the exact blend too, merged or not.
  Layer exact = draw_layer(particles, kLevelCamera, Backend::tiled, BlendMode::exact, odd), truth = raster;
  CHECK(exact.rays_cut_short == 0);
  for (Layer* layer : {&exact, &truth})
    for (glm::vec4& c : layer->color) c = glm::vec4(0, 0, 0, c.w);
  CHECK(layer_error(exact, truth, 1e-3).failing == 0);
}

TEST_CASE("the exact blend moves without a jump when particles swap order") {
  std::vector<Particle> moved = crowd({64, false, false}, 5);
  Layer before = draw_layer(moved, kLevelCamera, Backend::tiled, BlendMode::exact),
        truth_before = oracle_layer(moved, kLevelCamera);
  for (int step = 0; step < 12; ++step) {
    for (Particle& p : moved) p.center_m.x -= 0.001f;  // the camera goes right by a millimetre
    const Layer after = draw_layer(moved, kLevelCamera, Backend::tiled, BlendMode::exact),
                truth = oracle_layer(moved, kLevelCamera);
    CHECK(step_error(before, after, truth_before, truth) < 1e-3);
    before = after;
    truth_before = truth;
  }
}

TEST_CASE("work ends behind opaque matter and there is none in empty tiles") {
  std::vector<Particle> particles;
  for (int i = 0; i < 200; ++i)
    particles.push_back(emissive({0, 300 + 50.0f * float(i), 0}, glm::vec3(30), 1.0f, {1, 1, 1}));
  for (const BlendMode blend : {BlendMode::volume, BlendMode::exact}) {
    const Layer layer = draw_layer(particles, kLevelCamera, Backend::tiled, blend);
    const std::size_t covered = static_cast<std::size_t>(
        std::count_if(layer.color.begin(), layer.color.end(), [](const glm::vec4& c) { return c.w < 1; }));
    CHECK(covered > 100);
    CHECK(layer.pairs_shaded >= covered);
    CHECK(layer.pairs_shaded < 6 * covered);
  }
}
