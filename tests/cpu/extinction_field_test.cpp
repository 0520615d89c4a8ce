// The path tracer's medium against its definition and against closed forms.
#include "tools/path_tracer/extinction_field.h"
#include "tests/support/shapes.h"

#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include "lut/oracles.h"
#include "shared/reference_particle.h"
#include "shared/world.h"
#include "tests/support/blend_oracle.h"
#include "tests/support/truth_scene.h"

using namespace nephele;
using namespace nephele::test;
using glm::dvec3;
using glm::vec3;

namespace {

// The definition, in doubles: the reference particle itself in the particle's frame, cut at its base.
double true_extinction(const shared::Particle& p, dvec3 at) {
  const dvec3 unit = unit_matrix_of(p.shape) * (at - dvec3(p.center_m));
  if (glm::dot(unit, unit) >= 1) return 0;
  const glm::vec4 q = shared::unpack_orientation(p.orientation);
  const dvec3 turned = glm::inverse(glm::dquat(q.w, q.x, q.y, q.z)) * unit;
  const dvec3 from_planet = at + dvec3(0, 0, 6360000.0 + kTruthAltitudeM);
  const double above = std::clamp((glm::length(from_planet) - 6360000.0 - p.base_m) / 50, 0.0, 1.0);
  const bool homogeneous = (p.flags & shared::kParticleHomogeneous) != 0u;
  const double density =
      homogeneous ? 1.0 : shared::reference_particle_density(vec3(turned), TableParameters{}.particle_seed);
  return p.extinction_per_m * density * above * above * (3 - 2 * above);
}

vec3 random_direction(UniformNumbers& uniform) {
  const double z = 2 * uniform() - 1, a = 2 * M_PI * uniform(), r = std::sqrt(1 - z * z);
  return {r * std::cos(a), r * std::sin(a), z};
}

}  // namespace

TEST_CASE("extinction field: the lattice stands for the reference particle itself") {
  const truth::DensityLattice lattice(TableParameters{}.particle_seed);
  UniformNumbers uniform(1);
  double worst = 0, squares = 0, signed_sum = 0;
  int count = 0;
  while (count < 20000) {
    const vec3 p(2 * uniform() - 1, 2 * uniform() - 1, 2 * uniform() - 1);
    if (glm::dot(p, p) >= 1) continue;
    const double error = lattice(p) - shared::reference_particle_density(p, TableParameters{}.particle_seed);
    worst = std::max(worst, std::abs(error));
    squares += error * error;
    signed_sum += error;
    ++count;
  }
  MESSAGE("lattice: RMS error " << std::sqrt(squares / count) << ", bias " << signed_sum / count << ", worst "
                                << worst);
  // Of a density between 0 and 1; twice what is measured. The finest structure is 0.7 radii long and the vertices 0.02
  // apart. What counts over a chord is the bias, far below the percent that references are rendered to.
  CHECK(std::sqrt(squares / count) < 0.002);
  CHECK(std::abs(signed_sum / count) < 0.0001);
}

TEST_CASE("extinction field: bounds hold in every box") {
  const truth::DensityLattice lattice(TableParameters{}.particle_seed);
  UniformNumbers uniform(2);
  for (int i = 0; i < 2000; ++i) {
    const vec3 center(2.4 * uniform() - 1.2, 2.4 * uniform() - 1.2, 2.4 * uniform() - 1.2);
    const vec3 half(0.2 * uniform(), 0.2 * uniform(), 0.2 * uniform());
    const float bound = lattice.bound(center, half);
    for (int k = 0; k < 20; ++k) {
      const vec3 p = center + half * vec3(2 * uniform() - 1, 2 * uniform() - 1, 2 * uniform() - 1);
      if (glm::dot(p, p) < 1) CHECK(lattice(p) <= bound + 1e-5f);  // rounding
    }
  }
}

TEST_CASE("extinction field: the sum of all particles at any point") {
  auto particles = heaped_particles(12, 3, 0.05f, false, true);
  const auto balls = heaped_particles(4, 4, 0.03f, true);
  particles.insert(particles.end(), balls.begin(), balls.end());
  const TruthScene t(truth_scene(), particles, vec3(0.0f));
  UniformNumbers uniform(5);
  double sum = 0, squares = 0;
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const dvec3 p(500 * uniform() - 250, 250 + 500 * uniform(), 300 * uniform() - 150);
    double expected = 0;
    for (const shared::Particle& particle : particles) expected += true_extinction(particle, p);
    const double error = t.field.extinction_per_m(vec3(p)) - expected;
    sum += expected;
    squares += error * error;
    if (expected > 0) ++inside;
  }
  REQUIRE(inside > 2000);
  // What the lattice leaves (above), a few of them summed; edges of homogeneous particles round either way.
  CHECK(std::sqrt(squares / inside) < 0.005 * sum / inside);
}

TEST_CASE("extinction field: overlapping homogeneous particles let through what the closed form says") {
  const auto particles = heaped_particles(10, 6, 0.004f, true);
  const TruthScene t(truth_scene(), particles, vec3(0.0f));
  UniformNumbers uniform(7);
  int thin = 0, overlapping = 0;
  for (int ray = 0; ray < 24; ++ray) {
    const dvec3 direction = glm::normalize(dvec3(0.5 * uniform() - 0.25, 1, 0.2 * uniform() - 0.1));
    const auto segments = chords(particles, direction);
    const double expected = integrate(segments).color.w;
    MeanAndError ratio, flights;
    for (int i = 0; i < 4000; ++i) {
      truth::Random random(8, ray, i);
      ratio.add(t.field.transmittance(vec3(0.0f), vec3(direction), truth::ExtinctionField::kNever, random));
      flights.add(t.field.collide(vec3(0.0f), vec3(direction), truth::ExtinctionField::kNever, random) ==
                  truth::ExtinctionField::kNever);
    }
    CAPTURE(expected);
    // Four standard errors, and at the very edge of a particle the float chord.
    CHECK(std::abs(ratio.mean() - expected) < 4 * ratio.error() + 1e-4);
    CHECK(std::abs(flights.mean() - expected) < 4 * flights.error() + 1e-4);
    thin += expected > 0.05 && expected < 0.95;
    overlapping += segments.size() > 1;
  }
  CHECK(thin > 8);
  CHECK(overlapping > 8);
}

TEST_CASE("extinction field: noisy particles let through what quadrature says") {
  const auto particles = heaped_particles(8, 9, 0.03f, false, true);
  const TruthScene t(truth_scene(), particles, vec3(0.0f));
  UniformNumbers uniform(10);
  for (int ray = 0; ray < 12; ++ray) {
    const dvec3 direction = glm::normalize(dvec3(0.4 * uniform() - 0.2, 1, 0.2 * uniform() - 0.1));
    double depth = 0;
    constexpr double kStepM = 0.5;
    for (double at = 0.5 * kStepM; at < 1000; at += kStepM)
      for (const shared::Particle& particle : particles) depth += kStepM * true_extinction(particle, at * direction);
    MeanAndError ratio;
    for (int i = 0; i < 4000; ++i) {
      truth::Random random(11, ray, i);
      ratio.add(t.field.transmittance(vec3(0.0f), vec3(direction), truth::ExtinctionField::kNever, random));
    }
    // The lattice again: its bias over a chord is well below 0.3 % of the depth.
    CHECK(std::abs(ratio.mean() - std::exp(-depth)) < 4 * ratio.error() + 0.003 * depth * std::exp(-depth) + 1e-5);
  }
}

TEST_CASE("extinction field: first matter is where the first particle begins") {
  const TruthScene t(truth_scene(), {round_particle({0, 500, 0}, 100, 0.01f)}, vec3(0.0f));
  const auto first_m = [&](vec3 direction, float end_m) {
    return t.field.first_matter_m(vec3(0.0f), direction, end_m);
  };
  CHECK(first_m({0, 1, 0}, truth::ExtinctionField::kNever) == doctest::Approx(400).epsilon(0.005));  // a 16th of a cell
  CHECK(first_m({0, 1, 0}, 300.0f) == truth::ExtinctionField::kNever);
  CHECK(first_m({0, -1, 0}, truth::ExtinctionField::kNever) == truth::ExtinctionField::kNever);
  CHECK(first_m({1, 0, 0}, truth::ExtinctionField::kNever) == truth::ExtinctionField::kNever);
}

// Light that leaves the ground at the horizon: where a float resolves centimetres, tracking must still get on.
TEST_CASE("extinction field: rays from far away") {
  const auto particles = heaped_particles(6, 14, 0.006f, true);
  const TruthScene t(truth_scene(), particles, vec3(0.0f));
  for (int ray = 0; ray < 8; ++ray) {
    const vec3 through(20.0f * static_cast<float>(ray) - 70, 500, 5), direction = glm::normalize(vec3(1, 0.3f, 0.01f));
    MeanAndError far, near;
    for (int i = 0; i < 2000; ++i) {
      truth::Random random(15, ray, i);
      far.add(
          t.field.transmittance(through - 300000.0f * direction, direction, truth::ExtinctionField::kNever, random));
      near.add(t.field.transmittance(through - 600.0f * direction, direction, truth::ExtinctionField::kNever, random));
    }
    // Standard errors; and the ray, 300 km on, is off by some centimetres of particles 100 m wide.
    CHECK(std::abs(far.mean() - near.mean()) < 4 * std::hypot(far.error(), near.error()) + 0.01);
  }
}

TEST_CASE("extinction field: nothing at all") {
  const TruthScene t(truth_scene(), {}, vec3(0.0f));
  truth::Random random(1, 2, 3);
  CHECK(t.field.extinction_per_m(vec3(1, 2, 3)) == 0.0f);
  CHECK(t.field.transmittance(vec3(0.0f), vec3(0, 1, 0), truth::ExtinctionField::kNever, random) == 1.0f);
  CHECK(t.field.collide(vec3(0.0f), vec3(0, 1, 0), truth::ExtinctionField::kNever, random) ==
        truth::ExtinctionField::kNever);
}

TEST_CASE("scattering: directions follow the phase function, which integrates to one") {
  for (const auto function : {PhaseFunction::henyey_greenstein, PhaseFunction::cornette_shanks})
    for (const double g : {-0.5, 0.0, 0.3, 0.85}) {
      const truth::Phase phase({function, g});
      const auto value = [&](double mu) { return double{phase(static_cast<float>(mu))}; };
      CHECK(2 * M_PI * adaptive_integral(value, -1, 1, 1e-7) == doctest::Approx(1).epsilon(1e-5));
      const auto bins = [](double mu) { return static_cast<std::size_t>(std::min(15.0, 8 * (mu + 1))); };
      std::vector<double> counts(16);
      constexpr int kCount = 40000;
      UniformNumbers uniform(12);
      const vec3 from = random_direction(uniform);
      for (int i = 0; i < kCount; ++i) {
        truth::Random random(13, 0, i);
        const vec3 to = phase.scatter(from, random);
        CHECK(std::abs(glm::length(to) - 1) < 1e-5f);
        counts[bins(glm::dot(from, to))] += 1;
      }
      for (int k = 0; k < 16; ++k) {
        const double share = 2 * M_PI * adaptive_integral(value, k / 8.0 - 1, (k + 1) / 8.0 - 1, 1e-7);
        // Four standard errors of a count.
        CHECK(std::abs(counts[k] / kCount - share) < 4 * std::sqrt(share * (1 - share) / kCount) + 1e-5);
        CHECK(value(k / 8.0 - 0.95) ==
              doctest::Approx(exact_phase_per_sr(function == PhaseFunction::cornette_shanks, k / 8.0 - 0.95, g))
                  .epsilon(1e-5));
      }
    }
}
