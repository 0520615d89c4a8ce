// Particles with structure in the picture: what a ray is left of after them against quadrature of their density, with
// the structure by an oracle.
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "shared/ellipsoid.h"
#include "tests/support/layer_scene.h"
#include "tests/support/shapes.h"
#include "tests/support/structure_oracle.h"

using namespace nephele;
using namespace nephele::test;
using shared::Particle;

namespace {

// Narrow, so that a pixel measures some 5 m: the picture filters what is finer, quadrature along single rays does not.
const CameraState kCamera{.vertical_fov_rad = 0.35};
constexpr LayerSize kSize{64, 48};

// scale: of places and sizes, at the same optical depths.
std::vector<Particle> structured_crowd(bool wisps, float scale) {
  std::mt19937 random(11), turns(12);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<Particle> particles;
  for (int i = 0; i < 12; ++i) {
    const glm::vec3 center = glm::vec3(0, 700, 0) + 300.0f * (glm::vec3(u(random), u(random), u(random)) - 0.5f);
    const glm::vec3 radius_m = glm::vec3(80, 80, 60) + 80.0f * u(random);
    Particle p = emissive(center, radius_m, (wisps ? 0.1f : 1.0f) * (0.01f + 0.08f * u(random)),
                          {u(random), u(random), u(random)});
    p.flags = shared::kParticleEmissive | shared::kParticleDetail |
              (wisps ? shared::kMostTorn << shared::kParticleTornShift : 0u);
    p.shape = shape_along(random_axes(turns), glm::dvec3(radius_m * scale));
    p.center_m *= scale;
    p.extinction_per_m /= scale;
    particles.push_back(p);
  }
  return particles;
}

double transmittance(const std::vector<Particle>& particles, const glm::dvec3& direction, double scale) {
  const double step_m = 2.0 * scale;
  double depth = 0;
  for (double t = 0.5 * step_m; t < 1300 * scale; t += step_m) {
    const glm::dvec3 at = direction * t;
    double noise = -1, broad = 0;
    for (const Particle& p : particles) {
      const glm::dmat3 shape = matrix_of(p.shape);
      const glm::dvec3 u = glm::inverse(shape) * (at - glm::dvec3(p.center_m));
      if (glm::dot(u, u) >= 1) continue;
      if (noise < 0) {  // of the camera's place in layer_constants
        const double drop_m = (at.x * at.x + at.y * at.y) / (2 * 6360000.0);
        noise = structure_oracle()(at + glm::dvec3(0, 0, 1000 + drop_m));
        broad = structure_oracle().broad(at + glm::dvec3(0, 0, 1000 + drop_m));
      }
      const double mean_m = std::cbrt(glm::determinant(shape));
      const double shift = (p.flags >> shared::kParticleTornShift & 31u) == 31u ? 2.0 : std::min(0.6, 150 / mean_m);
      const bool torn = shift > 0.6;
      const double far = torn ? 0.0 : 0.84 * std::sqrt(1 - shift * shift / 0.36);
      const double radius = std::clamp((torn ? 0.66 : 0.8) + shift * (noise - 0.6) + far * broad, 0.05, 1.0);
      const double q = std::clamp((1 - glm::dot(u, u) / (radius * radius)) / (torn ? 0.95 : 0.35), 0.0, 1.0);
      depth += step_m * p.extinction_per_m * q * q * (3 - 2 * q);
    }
  }
  return std::exp(-depth);
}

}  // namespace

TEST_CASE("structured layer: transmittance is that of displaced balls") {
  // Bodies, wisps, and bodies so wide that the broad form moves them most.
  for (const auto& [wisps, scale] : {std::pair{false, 1.0f}, {true, 1.0f}, {false, 6.0f}}) {
    CAPTURE(wisps);
    CAPTURE(scale);
    const std::vector<Particle> particles = structured_crowd(wisps, scale);
    std::vector<double> truth;
    for (std::uint32_t y = 0; y < kSize.height; ++y)
      for (std::uint32_t x = 0; x < kSize.width; ++x)
        truth.push_back(transmittance(particles, pixel_ray(kCamera, kSize, x, y), double(scale)));
    const auto between = std::count_if(truth.begin(), truth.end(), [](double t) { return t > 0.02 && t < 0.98; });
    CHECK(between > 150);
    const auto rmse = [&](const Layer& layer) {
      double square = 0;
      for (std::size_t i = 0; i < truth.size(); ++i) square += std::pow(layer.color[i].w - truth[i], 2);
      return std::sqrt(square / double(truth.size()));
    };
    const double chords = rmse(draw_layer(particles, kCamera, Backend::tiled, BlendMode::exact, kSize));
    const double fragments = rmse(draw_layer(particles, kCamera, Backend::alpha, BlendMode::volume, kSize));
    const double marched =
        rmse(draw_layer(particles, kCamera, Backend::tiled, BlendMode::exact, kSize, 1, nullptr, 512));
    MESSAGE("RMSE of transmittance: chords " << chords << ", as fragments " << fragments << ", marched " << marched);
    // Chords are sampled every 14 to 30 m, through billows of 15 m and more: 0.022, and 0.018 of wisps.
    CHECK(chords < 0.03);
    CHECK(fragments < 0.03);
    CHECK(marched < 0.03);  // its jitter and what takes the noise out again
  }
}
