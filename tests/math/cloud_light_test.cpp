// The lighting model's parts against their definitions in double precision, and the identities they must keep.
#include "shared/cloud_light.h"

#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>

using namespace nephele::shared;

TEST_CASE("octaves halve depth and asymmetry and weigh 0.62 of the one before") {
  for (const double g : {-0.8, 0.0, 0.5, 0.85})
    for (const double mu : {-1.0, -0.3, 0.0, 0.7, 1.0})
      for (const double tau : {0.0, 0.3, 5.0, 80.0}) {
        double sum = 0;
        for (int k = 1; k <= 5; ++k) {
          const double gk = g * std::pow(0.5, k);
          const double phase = (1 - gk * gk) / (4 * 3.14159265358979 * std::pow(1 + gk * gk - 2 * gk * mu, 1.5));
          sum += std::pow(0.62, k) * phase * std::exp(-tau * std::pow(0.5, k));
        }
        CAPTURE(g);
        CAPTURE(mu);
        CAPTURE(tau);
        // Squaring an exponential four times multiplies its rounding by sixteen.
        CHECK(diffuse_octaves(float(mu), float(g), float(tau)) == doctest::Approx(sum).epsilon(2e-5));
      }
}

TEST_CASE("diffuse light: all of it without cloud, none through endless cloud, never more with more") {
  CHECK(diffuse_transmission(0.0f, 0.85f) == 1.0f);
  CHECK(diffuse_transmission(1e6f, 0.85f) < 1e-4f);
  float before = 1.0f;
  for (float tau = 0.5f; tau < 100.0f; tau *= 1.5f) {
    const float now = diffuse_transmission(tau, 0.85f);
    CHECK(now < before);
    before = now;
  }
}

TEST_CASE("ambient shares stay within 0..1 and are even when as much cloud lies above as below") {
  for (const float above : {0.0f, 1.0f, 30.0f, 1e5f}) {
    CHECK(ambient_share_above(above, above, 0.85f) == doctest::Approx(0.5f));
    for (const float below : {0.0f, 2.0f, 1e5f}) {
      const float share = ambient_share_above(above, below, 0.85f);
      CHECK(share >= 0.0f);
      CHECK(share <= 1.0f);
    }
  }
  CHECK(ambient_share_above(0.0f, 1e6f, 0.85f) > 0.99f);
}
