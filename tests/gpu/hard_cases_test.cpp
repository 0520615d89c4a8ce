// Rays where table look-ups go wrong first, against the oracles: the table in docs/tables.md.
//   test_gpu --no-skip --test-case="hard cases study"
#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>

#include "lut/cpu_fetch.h"
#include "lut/oracles.h"
#include "shared/phase.h"
#include "shared/scattering.h"
#include "tests/support/test_tables.h"

using namespace nephele;

TEST_CASE("hard cases study" * doctest::skip()) {
  const FloatTexture table(test::test_tables().multiple_scattering);
  const float g = static_cast<float>(test::test_tables().parameters.g_multiple);
  struct Case {
    const char* name;
    SphereRay ray;
  };
  const double r = std::sqrt(0.5);
  for (const Case& at :
       {Case{"light with the view ray, through the middle", {1, 1, 1}},
        Case{"light against the view ray, through the middle", {-1, 1, -1}},
        Case{"light with the view ray, h = 0.5", {0.5, 0.5, 1}},
        Case{"light against the view ray, h = 0.5", {-0.5, 0.5, -1}},
        Case{"entry facing the light, slanting", {-1, r, -r}}, Case{"entry at the dark pole, slanting", {1, r, r}},
        Case{"entry on the terminator", {0, r, 0.5}}, Case{"chord of 2e-4 radii, lit", {-0.5, 1e-4, 0.3}}}) {
    for (const double sigma : {1e-6, 1.0, 1e4}) {
      CAPTURE(at.name);
      CAPTURE(sigma);
      const auto c = static_cast<float>(at.ray.c), h = static_cast<float>(at.ray.h), mu = static_cast<float>(at.ray.mu);
      const float single = shared::single_scattering(c, h, mu, static_cast<float>(sigma)),
                  multiple = fetch_multiple(table, c, h, mu, static_cast<float>(sigma), g);
      const double exact = exact_single_scattering(at.ray, sigma);
      const Estimate truth =
          monte_carlo_multiple({shared::kPhaseHenyeyGreenstein, double{g}, sigma}, at.ray, sigma > 1 ? 500 : 20000, 3);
      CHECK((std::isfinite(single) && std::isfinite(multiple) && single >= 0 && multiple >= 0));
      std::printf("| %s | %g | %.3g | %.3g | %.3g | %.3g ± %.1g |\n", at.name, sigma, double{single}, exact,
                  double{multiple}, truth.mean, truth.standard_error);
    }
  }
}
