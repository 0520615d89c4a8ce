// The ray marcher: homogeneous particles against the integral of their chords, noisy ones against quadrature of their
// density in doubles, to which it must converge as its steps shrink. The same quadrature judges particles drawn as
// particles of which a flat base leaves a part.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "shared/reference_particle.h"
#include "shared/world.h"
#include "tests/support/layer_scene.h"
#include "tests/support/shapes.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::test;
using shared::Particle;

namespace {

Layer march(const std::vector<Particle>& particles, std::uint32_t steps, LayerSize size = {},
            const std::vector<float>* scene_m = nullptr) {
  const Layer layer = draw_layer(particles, kLevelCamera, Backend::tiled, BlendMode::exact, size, 1, scene_m, steps);
  CHECK(layer.pairs_lost == 0);
  return layer;
}

// Overlapping noisy particles, turned every way, some cut off at a base; thin to opaque.
std::vector<Particle> noisy_crowd() {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> particles;
  for (int i = 0; i < 12; ++i) {
    const glm::vec3 center = glm::vec3(0, 500, 0) + 300.0f * (glm::vec3(u(random), u(random), u(random)) - 0.5f);
    const glm::vec3 radius_m = glm::vec3(60, 60, 40) + 60.0f * u(random);
    Particle p = emissive(center, radius_m, 0.002f + 0.2f * u(random) * u(random), {u(random), u(random), u(random)});
    p.flags = shared::kParticleEmissive;
    p.shape = shape_along(random_axes(random), glm::dvec3(radius_m));
    p.orientation = shared::pack_orientation(shared::random_rotation(u(random), u(random), u(random)));
    if (i % 3 == 0) p.base_m = 990;  // the camera stands at 1000 m
    particles.push_back(p);
  }
  return particles;
}

double extinction_per_m(const Particle& p, const glm::vec3& at_m) {
  const glm::vec3 unit = unit_matrix_of(p.shape) * glm::dvec3(at_m - p.center_m);
  const double density = shared::reference_particle_density(
      shared::quaternion_rotate_inverse(shared::unpack_orientation(p.orientation), unit),
      TableParameters{}.particle_seed);
  const double above =
      std::clamp((double(shared::altitude_m(at_m, 1000.0f)) - p.base_m) / 50, 0.0, 1.0);  // thinned over 50 m
  return p.extinction_per_m * density * above * above * (3 - 2 * above);
}

// Midpoint rule in steps of half a metre: the finest features measure some ten metres.
double transmittance(const std::vector<Particle>& particles, const glm::dvec3& direction) {
  constexpr double kStepM = 0.5;
  double depth = 0;
  for (double t = 0.5 * kStepM; t < 900; t += kStepM)
    for (const Particle& p : particles) depth += kStepM * extinction_per_m(p, glm::vec3(direction * t));
  return std::exp(-depth);
}

}  // namespace

TEST_CASE("ray march: homogeneous particles are the integral of their chords, whatever the step") {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> crowd;
  for (int i = 0; i < 60; ++i)
    crowd.push_back(emissive(glm::vec3(0, 450, 0) + 300.0f * (glm::vec3(u(random), u(random), u(random)) - 0.5f),
                             glm::vec3(20 + 60 * u(random)), std::exp2(-12 + 9 * u(random)),
                             {u(random), u(random), u(random)}));
  std::vector<Particle> shells;  // more at one place than the march keeps open
  for (int i = 0; i < 40; ++i)
    shells.push_back(emissive({0, 300, 0}, glm::vec3(100.0f - float(i)), 1e-3f, {1, 0.5f, 0}));
  for (const std::vector<Particle>& particles : {crowd, shells}) {
    // The crowd's opacity stops at a transmittance of 1e-4, and float distances of some hundred metres are good to 3e-5
    // m. Shells past the slots begin between two steps: each is counted within a step of a 64th of its radius.
    const bool crowded = particles.size() == 40;
    const LayerError error = layer_error(march(particles, crowded ? 1024 : 16), oracle_layer(particles, kLevelCamera),
                                         crowded ? 5e-3 : 5e-4);
    CAPTURE(error.worst);
    CHECK(error.failing <= 0.002);  // pixels where a border falls between the rays of float and double
  }
}

TEST_CASE("ray march: transmittance converges to quadrature of the particles' own density") {
  const LayerSize size{48, 32};
  const std::vector<Particle> particles = noisy_crowd();
  std::vector<double> truth;
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x)
      truth.push_back(transmittance(particles, pixel_ray(kLevelCamera, size, x, y)));
  CHECK(std::count_if(truth.begin(), truth.end(), [](double t) { return t > 0.05 && t < 0.95; }) > 200);
  CHECK(std::count_if(truth.begin(), truth.end(), [](double t) { return t < 0.05; }) > 50);

  constexpr double kLattice = 2e-3;
  double before = 1;
  for (const std::uint32_t steps : {16u, 64u, 256u, 1024u}) {
    const Layer layer = march(particles, steps, size);
    double square = 0, sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      square += std::pow(layer.color[i].w - truth[i], 2);
      sum += layer.color[i].w - truth[i];
    }
    const double rmse = std::sqrt(square / double(truth.size()));
    MESSAGE(steps << " steps: RMSE " << rmse << ", bias " << sum / double(truth.size()));
    CHECK(rmse < std::max(0.5 * before, kLattice));
    before = rmse;
  }
  // What remains is the lattice of 96 vertices a side (it goes with the square of the spacing), in a crowd of optical
  // depths up to some tens: measured 1.2e-3.
  CHECK(before < kLattice);
}

TEST_CASE("particles of which a base leaves a part have that part's own depth, not its share of the whole chord's") {
  const LayerSize size{48, 32};
  std::vector<Particle> particles = noisy_crowd();
  for (Particle& p : particles) p.base_m = 980.0f + p.center_m.z;  // 20 m below their middles
  double square = 0, sum = 0;
  int between = 0;
  const Layer layer =
      draw_layer(particles, kLevelCamera, Backend::tiled, BlendMode::exact, size, 1, nullptr, 0, &test_tables());
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x) {
      const double truth = transmittance(particles, pixel_ray(kLevelCamera, size, x, y));
      if (truth > 0.999) continue;
      const double error = layer.color[y * size.width + x].w - truth;
      square += error * error;
      sum += error;
      ++between;
    }
  const double rmse = std::sqrt(square / between), bias = sum / between;
  MESSAGE(between << " pixels: RMSE " << rmse << ", bias " << bias);
  CHECK(between > 300);
  CHECK(rmse < 0.03);  // 0.019; by the whole chord's density 0.077 and -0.025
  CHECK(std::abs(bias) < 0.006);
}

TEST_CASE("ray march: ends at the scene behind it, and at nothing where there is nothing") {
  const LayerSize size{32, 24};
  const std::vector<Particle> one = {emissive({0, 300, 0}, glm::vec3(80), 0.01f, {1, 1, 1})};
  const std::vector<float> wall(size.width * size.height, 290.0f);
  CHECK(layer_error(march(one, 64, size, &wall), oracle_layer(one, kLevelCamera, size, &wall), 5e-4).failing == 0);
  const Layer nothing = march({}, 64, size);
  for (std::size_t i = 0; i < nothing.color.size(); ++i) {
    CHECK(nothing.color[i] == glm::vec4(0, 0, 0, 1));
    CHECK(std::isinf(nothing.depth[i]));
  }
}
