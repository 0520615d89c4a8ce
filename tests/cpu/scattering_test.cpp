// The four-point formula of single scattering against quadrature.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "lut/oracles.h"
#include "shared/phase.h"
#include "shared/scattering.h"

using namespace nephele;

namespace {

float formula(const SphereRay& ray, double sigma) {
  return shared::single_scattering(float(ray.c), float(ray.h), float(ray.mu), float(sigma));
}

}  // namespace

TEST_CASE("single scattering is within 1 % of quadrature up to optical radius 100, per decade") {
  UniformNumbers uniform(4);
  for (const double decade : {0.01, 0.1, 1.0, 10.0, 100.0}) {
    for (const double g : {0.0, 0.85}) {
      CAPTURE(decade);
      CAPTURE(g);
      std::vector<double> errors;
      double error2 = 0, value2 = 0;
      for (int i = 0; i < 20000; ++i) {
        const double sigma = decade * std::pow(10.0, uniform());
        const SphereRay ray = random_sphere_ray(uniform);
        const double phase = shared::phase_henyey_greenstein(float(ray.mu), float(g));
        const double truth = phase * exact_single_scattering(ray, sigma);
        errors.push_back(std::abs(phase * formula(ray, sigma) - truth));
        error2 += errors.back() * errors.back();
        value2 += truth * truth;
      }
      std::sort(errors.begin(), errors.end());
      // Two million rays give 0.6 % in every decade from 1 on. Beyond 100 single rays that graze the terminator, light
      // ahead, carry most of the square: 20 000 of them give 0.4 to 2 %.
      CHECK(std::sqrt(error2 / value2) < (decade < 100 ? 0.01 : 0.03));
      CHECK(errors[errors.size() * 99 / 100] < 0.03 * std::sqrt(value2 / errors.size()));
    }
  }
}

TEST_CASE("closed forms: thin sphere, light along the view ray, light from behind") {
  // Thin: sigma times the chord.
  CHECK(shared::single_scattering(-0.3f, 0.8f, -0.2f, 1e-4f) == doctest::Approx(1.6e-4).epsilon(1e-3));
  // Forward (light towards the eye, c = h, mu = 1): u + d = chord.
  for (const float sigma : {0.1f, 1.0f, 5.0f})
    CHECK(shared::single_scattering(0.7f, 0.7f, 1.0f, sigma) ==
          doctest::Approx(1.4 * sigma * std::exp(-1.4 * sigma)).epsilon(2e-3));
  // Backward (light from behind the eye, c = -h, mu = -1): d = u.
  for (const float sigma : {0.1f, 1.0f, 100.0f})
    CHECK(shared::single_scattering(-0.7f, 0.7f, -1.0f, sigma) ==
          doctest::Approx((1 - std::exp(-2.8 * sigma)) / 2).epsilon(2e-3));
}

TEST_CASE("single scattering is finite, non-negative and at most the bound everywhere") {
  for (const float sigma : {0.0f, 1e-6f, 1e-3f, 1.0f, 300.0f, 1e4f}) {
    for (int i = 0; i <= 40; ++i) {
      for (int j = 0; j <= 20; ++j) {
        for (int k = 0; k <= 10; ++k) {
          const float c = -1 + 0.05f * i, h = 0.05f * j, x = -1 + 0.2f * k;
          const float mu = c * h + std::sqrt(std::max(0.0f, (1 - c * c) * (1 - h * h))) * x;
          const float s = shared::single_scattering(c, h, mu, sigma);
          CHECK_MESSAGE((s >= 0.0f && s <= 1.002f), s, " at c ", c, " h ", h, " mu ", mu, " sigma ", sigma);
        }
      }
    }
  }
  CHECK(shared::single_scattering(-0.5f, 0.0f, 0.1f, 10.0f) == 0.0f);
  CHECK(shared::single_scattering(-0.5f, 1e-7f, 0.1f, 10.0f) < 1e-5f);
}
