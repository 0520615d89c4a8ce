// The lighting model's parts against their definitions in double precision, and the identities they must keep.
#include "shared/cloud_light.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

using namespace nephele::shared;

TEST_CASE("a slab sends back, lets through diffusely or lets through straight all the light it gets") {
  for (const float g : {-0.8f, 0.0f, 0.5f, 0.85f})
    for (const float total : {0.0f, 0.01f, 0.3f, 5.0f, 80.0f, 1e5f}) {
      CAPTURE(g);
      CAPTURE(total);
      // Marshak: the flux that leaves through a side is half of slab_light there.
      const float back = 0.5f * slab_light(0.0f, total, g), through = 0.5f * slab_light(total, total, g);
      CHECK(back + through + std::exp(-(1.0f - g) * total) == doctest::Approx(1.0f).epsilon(1e-5));
    }
  CHECK(slab_light(0.0f, 1e6f, 0.85f) == doctest::Approx(2.0f).epsilon(1e-4));
  CHECK(slab_light(60.0f, 1e6f, 0.85f) == doctest::Approx(5.0f).epsilon(1e-3));
}

TEST_CASE("a slab's light solves the diffusion equation") {
  // J'' = -3 exp(-t) in scaled depth t, in units of irradiance over 4 pi; so has the second difference a closed form.
  const double g = 0.85, total = 40, step = 0.25;
  for (double t = 0.3; t < 5.5; t += 0.3) {
    const auto j = [&](double scaled) { return double(slab_light(float(scaled / (1 - g)), float(total), float(g))); };
    CHECK(std::abs(j(t - step) - 2 * j(t) + j(t + step) + 3 * std::exp(-t) * (2 * std::cosh(step) - 2)) < 2e-6);
  }
}

TEST_CASE("light from around: none without cloud, less behind other clouds, finite and positive at every setting") {
  for (const float g : {-0.9f, 0.0f, 0.5f, 0.85f, 0.95f})
    for (const float mu : {-1.0f, 0.0f, 0.6f, 1.0f}) {
      CHECK(light_from_around(mu, g, 0.0f, 0.0f, 0.0f) == 0.0f);
      for (const float beam : {0.1f, 5.0f, 200.0f})
        for (const float total : {0.0f, 1.0f, 400.0f}) {
          const float near = std::min(beam, 0.5f * total), light = light_from_around(mu, g, beam, near, total);
          CHECK(std::isfinite(light));
          CHECK(light >= 0.0f);
          if (total > 0.0f && beam > 6.0f) CHECK(light_from_around(mu, g, beam + 50.0f, near, total) < light);
        }
    }
  // A thin cloud sends light on, a thick one back.
  CHECK(light_from_around(0.9f, 0.85f, 1.0f, 1.0f, 2.0f) > 8.0f * light_from_around(-0.9f, 0.85f, 1.0f, 1.0f, 2.0f));
  CHECK(light_from_around(-0.9f, 0.85f, 0.0f, 0.0f, 60.0f) > 4.0f * light_from_around(-0.9f, 0.85f, 0.0f, 0.0f, 2.0f));
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
