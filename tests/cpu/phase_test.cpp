// Phase functions against their defining integrals.
#include <doctest/doctest.h>

#include <cmath>

#include "lut/quadrature.h"
#include "shared/phase.h"

using namespace nephele;

namespace {

// 2 pi times the integral of f(mu) p(mu) over mu, in panels that shrink towards both peaks.
template <class F>
double integrate(std::uint32_t function, float g, F&& f) {
  static const QuadratureRule rule = gauss_legendre(16);
  double sum = 0;
  for (const double side : {-1.0, 1.0}) {
    // mu = side (1 - x), x = 2^-k panels of [0, 1].
    for (int k = 0; k < 24; ++k) {
      const double high = std::ldexp(1.0, -k), low = k == 23 ? 0.0 : std::ldexp(1.0, -k - 1);
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double mu = side * (1 - (low + (high - low) * rule.nodes[i]));
        sum += (high - low) * rule.weights[i] * f(mu) * shared::phase_per_sr(function, static_cast<float>(mu), g);
      }
    }
  }
  return sum * 2 * std::acos(-1.0);
}

}  // namespace

TEST_CASE("phase functions integrate to one and have the mean cosine they claim") {
  for (const std::uint32_t function : {shared::kPhaseHenyeyGreenstein, shared::kPhaseCornetteShanks}) {
    for (const float g : {-0.95f, -0.5f, 0.0f, 0.3f, 0.85f, 0.95f}) {
      CAPTURE(function);
      CAPTURE(g);
      // Single precision of p near its peak: (1 - |g|)^-3 amplifies nothing, so a few float roundings.
      CHECK(integrate(function, g, [](double) { return 1.0; }) == doctest::Approx(1.0).epsilon(2e-5));
      CHECK(integrate(function, g, [](double mu) { return mu; }) ==
            doctest::Approx(shared::phase_mean_cosine(function, g)).epsilon(2e-5).scale(1));
    }
  }
}

TEST_CASE("isotropic and Rayleigh limits") {
  const double pi = std::acos(-1.0);
  CHECK(shared::phase_henyey_greenstein(0.3f, 0.0f) == doctest::Approx(1 / (4 * pi)));
  CHECK(shared::phase_cornette_shanks(0.5f, 0.0f) == doctest::Approx(3 / (16 * pi) * 1.25));
}

TEST_CASE("the peak is exact for every g, and a cosine past 1 is harmless") {
  for (const float g : {0.5f, 0.95f, 0.999f, -0.95f}) {
    const double a = std::abs(static_cast<double>(g));
    const double peak = (1 + a) / (4 * std::acos(-1.0) * (1 - a) * (1 - a));
    CHECK(shared::phase_henyey_greenstein(g < 0 ? -1.0f : 1.0f, g) == doctest::Approx(peak).epsilon(1e-4));
    CHECK(std::isfinite(shared::phase_henyey_greenstein(g < 0 ? -1.0000002f : 1.0000002f, g)));
  }
}
