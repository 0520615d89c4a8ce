// The oracles themselves, against closed forms and identities that hold for every phase function.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "lut/oracles.h"
#include "shared/phase.h"
#include "shared/reference_particle.h"

using namespace nephele;

TEST_CASE("adaptive quadrature finds kinks, steps and endpoint singularities") {
  const auto integral = [](auto&& f) { return adaptive_integral(f, 0, 1, 1e-10); };
  CHECK(integral([](double x) { return std::pow(x, 15); }) == doctest::Approx(1.0 / 16).epsilon(1e-12));
  CHECK(integral([](double x) { return std::abs(x - 0.3); }) == doctest::Approx(0.29).epsilon(1e-9));
  CHECK(integral([](double x) { return std::sqrt(x); }) == doctest::Approx(2.0 / 3).epsilon(1e-9));
  CHECK(integral([](double x) { return x < 0.3 ? 1.0 : 0.0; }) == doctest::Approx(0.3).epsilon(1e-9));
}

TEST_CASE("single scattering by quadrature has its closed forms at every optical radius") {
  for (const double sigma : {1e-6, 1e-2, 1.0, 30.0, 1e3, 1e4}) {
    for (const double h : {1e-4, 0.1, 0.7, 1.0}) {
      CAPTURE(sigma);
      CAPTURE(h);
      const double bound = std::min(1.0, 2 * h * sigma);
      // Light towards the eye, c = h, mu = 1: u + d = chord. Light from behind the eye, c = -h, mu = -1: d = u.
      CHECK(exact_single_scattering({h, h, 1}, sigma) ==
            doctest::Approx(2 * h * sigma * std::exp(-2 * h * sigma)).epsilon(1e-8).scale(bound));
      CHECK(exact_single_scattering({-h, h, -1}, sigma) ==
            doctest::Approx(-std::expm1(-4 * h * sigma) / 2).epsilon(1e-8).scale(bound));
    }
  }
}

TEST_CASE("phase functions in doubles are those of the shaders") {
  for (const std::uint32_t function : {shared::kPhaseHenyeyGreenstein, shared::kPhaseCornetteShanks})
    for (const double g : {-0.9, 0.0, 0.7, 0.95})
      for (const double mu : {-1.0, -0.4, 0.3, 1.0})
        CHECK(exact_phase_per_sr(function, mu, g) ==
              doctest::Approx(shared::phase_per_sr(function, float(mu), float(g))).epsilon(1e-4));
}

TEST_CASE("the reference particle's mean density by quadrature is that of a fine march") {
  UniformNumbers uniform(2);
  for (int i = 0; i < 40; ++i) {
    const auto on_sphere = [&] {
      const double z = 2 * uniform() - 1, phi = 2 * std::acos(-1.0) * uniform(), s = std::sqrt(1 - z * z);
      return shared::vec3(glm::dvec3(s * std::cos(phi), s * std::sin(phi), z));
    };
    const shared::vec3 entry = on_sphere(), exit = on_sphere();
    const int steps = 4000;
    double sum = 0;
    for (int k = 0; k < steps; ++k)
      sum += shared::reference_particle_density(entry + (exit - entry) * ((float(k) + 0.5f) / steps), 5);
    CHECK(exact_mean_density(entry, exit, 5) == doctest::Approx(sum / steps).scale(1).epsilon(5e-5));
  }
}

TEST_CASE("light scatters 4/3 sigma times on average, whatever the phase function") {
  std::uint64_t seed = 1;
  for (const SphereProblem& problem :
       {SphereProblem{0, 0.0, 0.5}, SphereProblem{0, 0.85, 5}, SphereProblem{0, -0.7, 3}, SphereProblem{1, 0.6, 5}}) {
    CAPTURE(problem.g);
    const OrderPowers powers = monte_carlo_orders(problem, problem.g, 100000, ++seed);
    CHECK(std::abs(powers.scatterings.mean - 4 * problem.sigma / 3) < 4 * powers.scatterings.standard_error);
    const Estimate direct = powers.between(0, 0);
    CHECK(std::abs(direct.mean - direct_power(problem.sigma)) < 4 * direct.standard_error);
    CHECK(powers.between(0, 1 << 20).mean == doctest::Approx(1.0));
    // One scattering, by quadrature over all exit rays.
    const Estimate single = powers.between(1, 1);
    const double expected = exit_power(128, [&](const SphereRay& ray) {
      return exact_phase_per_sr(problem.phase_function, ray.mu, problem.g) *
             exact_single_scattering(ray, problem.sigma);
    });
    CHECK(std::abs(single.mean - expected) < 4 * single.standard_error + 1e-3 * expected);
  }
}

TEST_CASE("radiance along rays and power per order agree on multiple scattering") {
  // The mean over random rays of orders >= 2 is the power leaving by them over pi times the projected area, times
  // 4 pi^2: rays (impact uniform in area, light isotropic) are uniform in c, in h^2 and in azimuth.
  const SphereProblem problem{0, 0.6, 2};
  UniformNumbers uniform(9);
  double sum = 0, squares = 0;
  const int rays = 20000;
  for (int i = 0; i < rays; ++i) {
    const double value = monte_carlo_multiple(problem, random_sphere_ray(uniform), 8, 100 + i).mean;
    sum += value;
    squares += value * value;
  }
  const double mean = sum / rays, error = std::sqrt((squares / rays - mean * mean) / rays);
  const Estimate power = monte_carlo_orders(problem, problem.g, 200000, 5).between(2, 1 << 20);
  const double solid_angle = 4 * std::acos(-1.0);
  CHECK(std::abs(solid_angle * mean - power.mean) < 4 * std::hypot(solid_angle * error, power.standard_error));
}
