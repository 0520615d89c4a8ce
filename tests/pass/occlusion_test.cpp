// Sunlight at particles against brute force over all of them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/quaternion.hpp>
#include <optional>

#include "tests/support/light_scene.h"
#include "tests/support/shapes.h"

using namespace nephele;
using namespace nephele::test;
using shared::ParticleLight;

namespace {

// near_m: as with the light field, which asks for depths near the camera alone.
std::vector<ParticleLight> light(const LightScene& scene, const Image* transmittance = nullptr,
                                 std::optional<float> near_m = std::nullopt) {
  Workshop make(test_kernels());
  LightTiles tiles(make, scene.particle_capacity(), 400000);
  Occlusion occlusion(make, scene.visible_capacity(), near_m);
  FrameBuilder frame(test_device());
  const LightTileLists lists = tiles.add(frame, scene.constants, scene.particles, scene.counters);
  const Buffer& lights =
      occlusion.add(frame, scene.constants, scene.particles, scene.visible, scene.counters, lists, transmittance);
  FrameExecutor(test_device()).run(frame);
  const FrameCounters counters = scene.read_counters();
  REQUIRE(counters.tile_pair_demand == counters.tile_pair_count);
  return lights.read_vector<ParticleLight>(scene.visible_value.size());
}

struct TrueLight {
  double tau;
  dvec3 gradient_per_m;
};

TrueLight true_light(const LightScene& scene, std::uint32_t index) {
  const Particle& particle = scene.particles_value[index];
  const glm::dmat3 shape = test::matrix_of(particle.shape), inverse = glm::inverse(shape);
  const dvec3 corners[4] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  const dvec3 center(particle.center_m);

  TrueLight truth{0.0, dvec3(0.0)};
  for (const dvec3& along : corners) {
    const glm::vec4 q = shared::unpack_orientation(particle.orientation);
    const dvec3 corner = glm::dquat(q.w, q.x, q.y, q.z) * (along / std::sqrt(3.0));
    const dvec3 inside = center + shape * (0.6 * corner);
    const double depth = true_depth(scene.particles_value, inside, scene.sun(), index);
    truth.tau += 0.25 * depth;
    truth.gradient_per_m += inverse * corner * depth * (0.75 / 0.6);
  }
  return truth;
}

LightScene crowd(std::uint32_t seed, std::uint32_t count, float range_m, double azimuth_deg, double elevation_deg) {
  std::mt19937 random(seed);
  std::vector<Particle> particles(count);
  for (Particle& particle : particles) {
    particle = random_particle(random, range_m);
    particle.shape = test::scaled(particle.shape, std::max(1.0f, range_m / 2500.0f));
  }
  return LightScene(light_constants(azimuth_deg, elevation_deg), particles, every(count));
}

}  // namespace

TEST_CASE("occlusion equals brute force over all particles") {
  // Positions in float are good to 2e-4 m at 2 km, 4e-3 m at 30 km; a ray that grazes a homogeneous particle turns
  // an error e into a chord of sqrt(8 r e), hence the looser maximum.
  struct Case {
    std::uint32_t count;
    float range_m;
    double azimuth_deg, elevation_deg;
  };
  for (const Case& setup : {Case{300, 1500, 220, 35}, Case{300, 1500, 0, 90}, Case{400, 2500, 45, 2},
                            Case{300, 1500, 135, 0}, Case{200, 600, 300, 70}, Case{200, 30000, 10, 5}}) {
    CAPTURE(setup.elevation_deg);
    CAPTURE(setup.range_m);
    const LightScene scene = crowd(setup.count, setup.count, setup.range_m, setup.azimuth_deg, setup.elevation_deg);
    const std::vector<ParticleLight> lights = light(scene);
    double worst = 0.0, mean = 0.0, depth = 0.0, worst_gradient = 0.0;
    for (std::uint32_t i = 0; i < setup.count; ++i) {
      const TrueLight truth = true_light(scene, i);
      const double radius = test::shortest_axis_at_least_m(scene.particles_value[i].shape);
      const double error = std::abs(lights[i].tau_sun - truth.tau);
      worst = std::max(worst, error);
      const dvec3 gradient_error = dvec3(lights[i].tau_gradient_per_m) - truth.gradient_per_m;
      worst_gradient = std::max(worst_gradient, glm::length(gradient_error) * radius);
      mean += error / setup.count;
      depth += truth.tau / setup.count;
    }
    CHECK(depth > 1.0);
    CHECK(mean < 1e-4);
    CHECK(worst < 0.01);
    CHECK(worst_gradient < 0.02);
  }
}

TEST_CASE("with the light field, particles near the camera alone bring depths of their own, the same ones") {
  const LightScene scene = crowd(7, 300, 1500, 220, 35);
  const std::vector<ParticleLight> all = light(scene), near = light(scene, nullptr, 400.0f);
  std::size_t with = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Particle& p = scene.particles_value[i];
    const bool wanted = glm::length(p.center_m) - shared::longest_axis_m(p.shape) < 400.0f;
    CHECK(all[i].own_depth == 1.0f);
    CHECK(near[i].own_depth == (wanted ? 1.0f : 0.0f));
    CHECK(near[i].tau_sun == (wanted ? all[i].tau_sun : 0.0f));
    CHECK(near[i].sun_irradiance == all[i].sun_irradiance);
    with += wanted;
  }
  CHECK(with > 5);
  CHECK(with < all.size() / 2);
}

TEST_CASE("a particle alone is not shaded, not even by itself") {
  const LightScene scene = crowd(1, 1, 500.0f, 220, 35);
  const ParticleLight lone = light(scene)[0];
  CHECK(lone.tau_sun == 0.0f);
  CHECK(lone.tau_gradient_per_m == glm::vec3(0.0f));
  CHECK(lone.sun_irradiance == scene.constants_value.sun_irradiance);
}

TEST_CASE("coincident particles shade each other alike") {
  std::mt19937 random(2);
  Particle particle = random_particle(random, 400.0f);
  particle.base_m = shared::kNoBaseM;
  const LightScene scene(light_constants(220, 35), {particle, particle, particle}, every(3));
  const std::vector<ParticleLight> lights = light(scene);
  const TrueLight truth = true_light(scene, 0);
  CHECK(truth.tau > 0.1);
  for (const ParticleLight& one : lights) CHECK(one.tau_sun == doctest::Approx(truth.tau).epsilon(1e-4));
}

TEST_CASE("a stack of slabs: the depth grows with what is above, and the gradient points away from the sun") {
  // Three wide homogeneous particles above each other, the sun overhead.
  std::vector<Particle> stack(3);
  for (int i = 0; i < 3; ++i) {
    std::memset(&stack[i], 0, sizeof(Particle));
    stack[i].center_m = glm::vec3(0.0f, 0.0f, 300.0f * i);
    stack[i].shape.diagonal_m = glm::vec3(5000.0f, 5000.0f, 100.0f);
    stack[i].extinction_per_m = 0.01f;
    stack[i].base_m = shared::kNoBaseM;
    stack[i].flags = shared::kParticleHomogeneous;
  }
  // Only sample points within 0.35 of the radius: each higher slab adds 0.01/m * 200 m * sqrt(1 - 0.24).
  const double slab = 2.0 * std::sqrt(1.0 - 0.24);
  const std::vector<ParticleLight> lights = light(LightScene(light_constants(0, 90), stack, every(3)));
  for (int i = 0; i < 3; ++i) CHECK(lights[i].tau_sun == doctest::Approx(slab * (2 - i)).epsilon(1e-3));

  // Two overlapping halves: deeper means darker.
  stack[1].center_m.z = 60.0f;
  stack.resize(2);
  const std::vector<ParticleLight> pair = light(LightScene(light_constants(0, 90), stack, every(2)));
  CHECK(pair[0].tau_gradient_per_m.z < -1e-3f);
  CHECK(pair[0].tau_gradient_per_m.z > -0.0101f);  // no steeper than the occluder's extinction
  CHECK(std::abs(pair[0].tau_gradient_per_m.x) < 1e-6f);
}

TEST_CASE("depth stops at its maximum in a crowd far too thick") {
  std::vector<Particle> crowd_of_same(500);
  std::mt19937 random(8);
  for (Particle& particle : crowd_of_same) {
    particle = random_particle(random, 300.0f);
    particle.extinction_per_m = 1.0f;
    particle.base_m = shared::kNoBaseM;
  }
  const LightScene scene(light_constants(220, 35), crowd_of_same, every(500));
  const std::vector<ParticleLight> lights = light(scene);
  int full = 0;
  for (std::uint32_t i = 0; i < 500; ++i) {
    CHECK(lights[i].tau_sun <= shared::kMaxSunOpticalDepth);
    CHECK(lights[i].tau_sun == doctest::Approx(true_light(scene, i).tau).epsilon(1e-3));
    full += lights[i].tau_sun == shared::kMaxSunOpticalDepth;
  }
  CHECK(full > 100);
}

TEST_CASE("emissive particles cast shadows and need no light; a set sun lights nothing") {
  std::mt19937 random(31);
  std::vector<Particle> two = {random_particle(random, 10.0f), random_particle(random, 10.0f)};
  two[0].flags |= shared::kParticleEmissive;
  two[0].base_m = two[1].base_m = shared::kNoBaseM;
  const std::vector<ParticleLight> lights = light(LightScene(light_constants(220, 35), two, every(2)));
  CHECK(lights[0].sun_irradiance == glm::vec3(0.0f));
  CHECK(lights[0].tau_sun == 0.0f);
  CHECK(lights[1].tau_sun > 0.1f);

  for (const ParticleLight& dark : light(LightScene(light_constants(220, -10), two, every(2)))) {
    CHECK(dark.sun_irradiance == glm::vec3(0.0f));
    CHECK(dark.tau_sun == 0.0f);
  }
}

TEST_CASE("sunlight passes the atmosphere's transmittance table") {
  constexpr std::uint32_t kWidth = shared::kTransmittanceWidth, kHeight = shared::kTransmittanceHeight;
  Image table(test_device(), "transmittance", {.width = kWidth, .height = kHeight});
  std::vector<glm::vec4> texels(kWidth * kHeight, glm::vec4(0.5f, 0.25f, 0.125f, 1.0f));
  table.write(std::as_bytes(std::span(texels)));
  LightScene scene = crowd(4, 20, 1000.0f, 220, 35);
  scene.constants_value.atmosphere_enabled = 1;
  scene.constants.write(std::as_bytes(std::span(&scene.constants_value, 1)));
  for (const ParticleLight& one : light(scene, &table)) {
    const glm::vec3 expected = scene.constants_value.sun_irradiance * glm::vec3(0.5f, 0.25f, 0.125f);
    CHECK(glm::length(one.sun_irradiance - expected) < 1e-5f);
  }
}

TEST_CASE("lights follow the visible list, do not depend on it, and two runs are identical") {
  const LightScene all = crowd(6, 200, 1200.0f, 220, 20);
  const std::vector<ParticleLight> everything = light(all);
  std::vector<std::uint32_t> seen;
  for (std::uint32_t i = 199; i < 200; i -= 3) seen.push_back(i);
  LightScene some(all.constants_value, all.particles_value, seen);
  const std::vector<ParticleLight> part = light(some);
  for (std::size_t slot = 0; slot < seen.size(); ++slot)
    CHECK(std::memcmp(&part[slot], &everything[seen[slot]], sizeof(ParticleLight)) == 0);

  const LightScene again = crowd(6, 200, 1200.0f, 220, 20);
  const std::vector<ParticleLight> second = light(again);
  CHECK(std::memcmp(second.data(), everything.data(), second.size() * sizeof(ParticleLight)) == 0);
}

TEST_CASE("nothing visible, nothing there") {
  const LightScene scene(light_constants(220, 35), {}, {});
  CHECK(light(scene).empty());
}
