// Light near the beam (lut/near_beam.h) against random walks, closed forms and its own table.
#include "lut/near_beam.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "lut/cpu_fetch.h"
#include "lut/quadrature.h"
#include "lut/tables.h"
#include "shared/near_beam_axes.h"
#include "shared/phase.h"

using namespace nephele;

namespace {

constexpr std::uint32_t kFunctions[] = {shared::kPhaseHenyeyGreenstein, shared::kPhaseCornetteShanks};

double phase(std::uint32_t function, double mu, double g) {
  return double(shared::phase_per_sr(function, float(mu), float(g)));
}

// Mean of P_l over the phase function by quadrature.
double moment_by_quadrature(std::uint32_t function, int l, double g) {
  const int n = 20000;
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    const double mu = -1.0 + (2.0 * i + 1.0) / n;
    double before = 1.0, here = mu;
    for (int k = 2; k <= l; ++k) {
      const double next = ((2 * k - 1) * mu * here - (k - 1) * before) / k;
      before = here;
      here = next;
    }
    sum += 2.0 * std::numbers::pi * phase(function, mu, g) * (l == 0 ? 1.0 : here) * 2.0 / n;
  }
  return sum;
}

}  // namespace

TEST_CASE("a phase function's moments are the means of Legendre polynomials over it") {
  for (const std::uint32_t function : kFunctions)
    for (const double g : {0.0, 0.3, 0.85}) {
      CAPTURE(function);
      CAPTURE(g);
      for (const int l : {0, 1, 2, 3, 7})
        CHECK(double(shared::phase_moment(function, l, float(g))) ==
              doctest::Approx(moment_by_quadrature(function, l, g)).epsilon(2e-4));
    }
  CHECK(double(shared::phase_moment(shared::kPhaseCornetteShanks, 1, 0.6f)) ==
        doctest::Approx(double(shared::cornette_shanks_mean_cosine(0.6f))).epsilon(1e-5));
}

TEST_CASE("light near the beam: none at the cloud's skin, none deep inside") {
  for (const std::uint32_t function : kFunctions)
    for (const double mu : {-1.0, -0.2, 0.5, 0.99}) {
      CHECK(near_beam_per_sr(function, 0.85, 0.0, mu) == doctest::Approx(0.0).epsilon(1e-12));
      CHECK(std::abs(near_beam_per_sr(function, 0.85, 200.0, mu)) < 1e-12);
    }
}

TEST_CASE("a beam that only widens, by random walks") {
  // Goudsmit and Saunderson: directions after a number of scatterings that is Poisson distributed with mean tau, and
  // one scattering more towards the eye. With all moments: what is scattered twice or more in a beam of one direction
  // of travel; K takes degrees 0 and 1 from the scaled beam instead, so those are put back before the comparison.
  const double g = 0.6, tau = 2.5;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::poisson_distribution<int> scatterings(tau);
  const int kBins = 10, kWalks = 4000000;
  std::vector<double> seen(kBins, 0.0);
  for (int walk = 0; walk < kWalks; ++walk) {
    const int n = scatterings(random);
    if (n == 0) continue;
    double mu = 1.0;
    for (int i = 0; i < n + 1; ++i) {
      const double s = (1 - g * g) / (1 - g + 2 * g * unit(random));
      const double turn = (1 + g * g - s * s) / (2 * g), azimuth = 2 * std::numbers::pi * unit(random);
      mu = mu * turn + std::sqrt((1 - mu * mu) * (1 - turn * turn)) * std::cos(azimuth);
    }
    seen[std::min(kBins - 1, int((mu + 1) / 2 * kBins))] += 1.0 / kWalks;
  }
  const double whole0 = 1.0 - std::exp(-tau), whole1 = g * (std::exp(-(1 - g) * tau) - std::exp(-tau));
  const double scaled = std::exp(-(1 - g * g) * tau) - std::exp(-tau);
  for (int bin = 0; bin < kBins; ++bin) {
    // Mean over the bin of the density per steradian, times its solid angle.
    double expected = 0.0;
    const int n = 200;
    for (int i = 0; i < n; ++i) {
      const double mu = -1 + 2.0 * (bin + (i + 0.5) / n) / kBins;
      const double low = (whole0 + 3 * whole1 * mu - scaled * (1 + 3 * g * mu)) / (4 * std::numbers::pi);
      expected +=
          (near_beam_per_sr(shared::kPhaseHenyeyGreenstein, g, tau, mu) + low) * 2 * std::numbers::pi * 2.0 / kBins / n;
    }
    CAPTURE(bin);
    CHECK(seen[bin] == doctest::Approx(expected).epsilon(0.01));
  }
}

TEST_CASE("the near-beam table gives the series back") {
  for (const std::uint32_t function : kFunctions)
    for (const double g : {-0.3, 0.0, 0.5, 0.85, 0.95}) {
      TableParameters parameters;
      parameters.phase_function = function;
      parameters.g_multiple = g;
      const Table table = bake_near_beam(parameters);
      const FloatTexture texture(table);
      double worst = 0.0, most = 0.0;
      for (int i = 0; i < 97; ++i)
        for (int j = 0; j < 97; ++j) {
          const float tau = shared::near_beam_depth(float(i + 0.37) / 97),
                      mu = shared::near_beam_cosine(float(j + 0.61) / 97);
          const double exact = near_beam_per_sr(function, g, double(tau), double(mu));
          worst = std::max(worst, std::abs(double(fetch_near_beam(texture, tau, mu)) - exact));
          most = std::max(most, std::abs(exact));
        }
      CAPTURE(g);
      CHECK(worst <= 0.01 * most);
    }
}
