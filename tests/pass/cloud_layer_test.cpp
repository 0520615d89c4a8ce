// The cloud layer against the closed form: homogeneous ellipsoids with given radiance, blended by each backend that
// the device has, compared with a double-precision integral of overlapping chords.
#include "passes/cloud_layer.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engine/camera.h"
#include "shared/ellipsoid.h"
#include "shared/types.h"
#include "tests/support/support.h"

using namespace nephele;
using nephele::test::test_device;
using shared::Particle;

namespace {

constexpr std::uint32_t kWidth = 96, kHeight = 64;

// One-texel tables: homogeneous emissive particles never look into them.
Tables blank_tables() {
  Tables tables;
  tables.optical_depth.name = "optical_depth";
  tables.optical_depth.array = {ElementType::uint8, {1, 1, 1, 2}, std::vector<std::byte>(2)};
  tables.multiple_scattering.name = "multiple_scattering";
  tables.multiple_scattering.array = {ElementType::float16, {1, 1, 1, 4}, std::vector<std::byte>(8)};
  tables.mean_fill = 0.3f;
  return tables;
}

Particle particle(glm::vec3 center_m, glm::vec3 radius_m, float extinction_per_m, glm::vec3 radiance) {
  Particle p{};
  p.center_m = center_m;
  p.radius_m = radius_m;
  p.extinction_per_m = extinction_per_m;
  p.radiance_per_sr = radiance;
  p.yaw_rad = 0.3f;
  p.orientation = shared::pack_orientation({0, 0, 0, 1});
  p.flags = shared::kParticleHomogeneous | shared::kParticleEmissive;
  p.base_m = -1e30f;
  return p;
}

struct Layer {
  std::vector<glm::vec4> color;
  std::vector<float> depth;
};

shared::FrameConstants frame_constants(const CameraState& camera) {
  shared::FrameConstants constants{};
  const CameraMatrices matrices = camera_matrices(camera, double(kWidth) / kHeight);
  constants.clip_from_render = matrices.clip_from_render;
  constants.render_from_clip = matrices.render_from_clip;
  constants.camera_grid_m = {0, 0, 1000};
  constants.sun_direction = {0, 0, 1};
  constants.image_size_px = constants.layer_size_px = {kWidth, kHeight};
  constants.scale = 1;
  return constants;
}

Layer draw(const std::vector<Particle>& particles, const CameraState& camera, Backend backend) {
  Device& device = test_device();
  const GpuTables tables(device, blank_tables());
  const std::uint32_t count = static_cast<std::uint32_t>(particles.size());
  const VkDeviceSize room = std::max(1u, count);
  Buffer constants(device, "constants", sizeof(shared::FrameConstants)), particle_buffer(device, "particles", room * sizeof(Particle)),
      visible(device, "visible", room * 4), order(device, "order", room * 4), lights(device, "lights", room * sizeof(shared::ParticleLight)),
      counters(device, "counters", sizeof(shared::FrameCounters));
  Image sky(device, "sky", {VK_FORMAT_R32G32B32A32_SFLOAT, 1, 1});
  constants.write_vector(std::vector{frame_constants(camera)});
  particle_buffer.write_vector(particles);
  std::vector<std::uint32_t> slots(count), by_distance(count);
  for (std::uint32_t i = 0; i < count; ++i) slots[i] = by_distance[i] = i;
  std::stable_sort(by_distance.begin(), by_distance.end(), [&](auto a, auto b) { return glm::length(particles[a].center_m) > glm::length(particles[b].center_m); });
  visible.write_vector(slots);
  order.write_vector(by_distance);
  shared::FrameCounters counts{};
  counts.visible_count = count;
  counts.visible_groups = {(count + 63) / 64, 1, 1};
  counts.draw = {6 * count, 1, 0, 0};
  counters.write_vector(std::vector{counts});

  CloudLayer layer(device, {kWidth, kHeight, 1}, backend, BlendMode::volume, static_cast<std::uint32_t>(room));
  FrameBuilder frame(device);
  layer.add(frame, {constants, particle_buffer, visible, order, lights, counters, sky, tables});
  FrameExecutor(device).run(frame);
  Layer result{std::vector<glm::vec4>(kWidth * kHeight), std::vector<float>(kWidth * kHeight)};
  layer.color().read(std::as_writable_bytes(std::span(result.color)));
  layer.depth().read(std::as_writable_bytes(std::span(result.depth)));
  return result;
}

// The truth of one pixel: between consecutive chord ends extinctions add and the source is their weighted mean.
glm::dvec4 integrate(const std::vector<Particle>& particles, glm::dvec3 direction, double& first_m) {
  struct Chord {
    double near_m, far_m;
    const Particle* particle;
  };
  std::vector<Chord> chords;
  std::vector<double> events;
  first_m = INFINITY;
  for (const Particle& p : particles) {
    const double s = std::sin(double(p.yaw_rad)), c = std::cos(double(p.yaw_rad));
    const auto unit = [&](glm::dvec3 v) {
      return glm::dvec3((c * v.x - s * v.y) / p.radius_m.x, (s * v.x + c * v.y) / p.radius_m.y, v.z / p.radius_m.z);
    };
    const glm::dvec3 o = unit(-glm::dvec3(p.center_m)), d = unit(direction);
    const double a = glm::dot(d, d), b = glm::dot(o, d), q = b * b - a * (glm::dot(o, o) - 1);
    if (q <= 0) continue;
    const double near_m = std::max(0.0, (-b - std::sqrt(q)) / a), far_m = (-b + std::sqrt(q)) / a;
    if (far_m <= near_m) continue;
    chords.push_back({near_m, far_m, &p});
    events.insert(events.end(), {near_m, far_m});
    first_m = std::min(first_m, near_m);
  }
  std::sort(events.begin(), events.end());
  glm::dvec4 result(0, 0, 0, 1);
  for (std::size_t i = 0; i + 1 < events.size(); ++i) {
    const double middle = 0.5 * (events[i] + events[i + 1]);
    double extinction = 0;
    glm::dvec3 source(0);
    for (const Chord& chord : chords)
      if (chord.near_m <= middle && middle <= chord.far_m) {
        extinction += chord.particle->extinction_per_m;
        source += glm::dvec3(chord.particle->radiance_per_sr) * double(chord.particle->extinction_per_m);
      }
    if (extinction <= 0) continue;
    const double alpha = -std::expm1(-extinction * (events[i + 1] - events[i]));
    result += glm::dvec4(result.w * alpha * source / extinction, 0);
    result.w *= 1 - alpha;
  }
  return result;
}

// Fraction of pixels off by more than `tolerance` in any channel, over those not within a pixel of a silhouette.
double failing_fraction(const Layer& layer, const std::vector<Particle>& particles, const CameraState& camera, double tolerance, double& worst) {
  const CameraMatrices matrices = camera_matrices(camera, double(kWidth) / kHeight);
  std::size_t failing = 0;
  worst = 0;
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      const glm::dvec4 ndc((x + 0.5) / kWidth * 2 - 1, (y + 0.5) / kHeight * 2 - 1, 1, 1);
      double first_m = 0;
      const glm::dvec3 direction = glm::normalize(glm::dvec3(glm::dmat4(matrices.render_from_clip) * ndc));
      const glm::dvec4 truth = integrate(particles, direction, first_m);
      const glm::dvec4 off = glm::abs(truth - glm::dvec4(layer.color[y * kWidth + x]));
      const double error = std::max({off.x, off.y, off.z, off.w});
      worst = std::max(worst, error);
      failing += error > tolerance;
    }
  return double(failing) / (kWidth * kHeight);
}

std::vector<Backend> available_backends() {
  std::vector<Backend> list;
  for (Backend backend : {Backend::interlock, Backend::attachment, Backend::tiled, Backend::alpha})
    if (backend_available(test_device().info(), backend)) list.push_back(backend);
  return list;
}

const CameraState kLevel{.position_m = {0, 0, 1000}, .yaw_rad = 0, .pitch_rad = 0};

}  // namespace

TEST_CASE("nothing to draw is a clear layer") {
  for (Backend backend : available_backends()) {
    const Layer layer = draw({}, kLevel, backend);
    CHECK(std::all_of(layer.color.begin(), layer.color.end(), [](const auto& c) { return c == glm::vec4(0, 0, 0, 1); }));
    CHECK(std::all_of(layer.depth.begin(), layer.depth.end(), [](float z) { return std::isinf(z); }));
  }
}

TEST_CASE("one particle is exact with every backend: far, near, flat, dense, thin, around the camera") {
  const std::vector<Particle> cases = {
      particle({0, 500, 0}, {100, 150, 60}, 0.02f, {1, 0.5f, 0.2f}),  particle({5e4f, 9e4f, 2000}, {9000, 5000, 3000}, 1e-3f, {1, 1, 1}),
      particle({1, 3, 0.5f}, {1, 1, 0.5f}, 2, {0.2f, 1, 0.5f}),       particle({10, 20, -5}, {100, 100, 100}, 0.01f, {1, 0.5f, 2}),
      particle({0, 300, 0}, {100, 100, 100}, 1e4f, {3, 2, 1}),        particle({0, 300, 0}, {100, 100, 100}, 1e-6f, {3, 2, 1}),
      particle({0, 150, 30}, {400, 100, 0.5f}, 1, {1, 1, 1}),         particle({0, 0, 0}, {50, 50, 50}, 0.05f, {1, 1, 1}),
      particle({0, -500, 0}, {100, 100, 100}, 1, {1, 1, 1})};
  for (Backend backend : available_backends())
    for (const Particle& p : cases) {
      CAPTURE(backend_name(backend));
      CAPTURE(p.center_m.y);
      CAPTURE(p.extinction_per_m);
      const Layer layer = draw({p}, kLevel, backend);
      double worst = 0;
      // 1e-3: floats hold a chord's depth to 1e-6 relative, a silhouette of near-opaque matter amplifies that.
      CHECK(failing_fraction(layer, {p}, kLevel, 1e-3, worst) <= 0.001);
    }
}

TEST_CASE("two particles are exact with the volume-aware backends, overlapping or not") {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(0, 1);
  for (Backend backend : available_backends()) {
    if (backend == Backend::alpha) continue;
    for (int scene = 0; scene < 12; ++scene) {
      std::vector<Particle> pair;
      for (int i = 0; i < 2; ++i)
        pair.push_back(particle({100 * (u(random) - 0.5f), 300 + 150 * u(random), 60 * (u(random) - 0.5f)},
                                {40 + 80 * u(random), 40 + 80 * u(random), 40 + 60 * u(random)}, std::exp2(-9 + 6 * u(random)),
                                {u(random), u(random), u(random)}));
      const Layer layer = draw(pair, kLevel, backend);
      double worst = 0;
      CAPTURE(scene);
      CHECK(failing_fraction(layer, pair, kLevel, 1e-3, worst) <= 0.001);
      CHECK(worst < 1e-2);
    }
  }
}

TEST_CASE("many particles: transmittance is exact, colour close, the order of submission does not matter") {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> cloud;
  for (int i = 0; i < 300; ++i)
    cloud.push_back(particle({600 * (u(random) - 0.5f), 400 + 400 * u(random), 300 * (u(random) - 0.5f)}, glm::vec3(20 + 40 * u(random)),
                             0.02f * u(random), glm::vec3(1.0f)));
  std::vector<Particle> shuffled = cloud;
  std::shuffle(shuffled.begin(), shuffled.end(), random);
  for (Backend backend : available_backends()) {
    CAPTURE(backend_name(backend));
    const Layer layer = draw(cloud, kLevel, backend);
    double worst = 0;
    failing_fraction(layer, cloud, kLevel, 1.0, worst);
    CHECK(worst < 1e-3);  // white light: colour and transmittance are complements, both exact for any overlap
    CHECK(draw(shuffled, kLevel, backend).color == layer.color);
  }
}
