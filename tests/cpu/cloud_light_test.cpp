// The lighting model's parts against their definitions in double precision, and the identities they must keep.
#include "shared/cloud_light.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <random>

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
    for (const float mu : {-1.0f, 0.0f, 0.6f, 1.0f})
      for (const float outward : {0.0f, 0.4f, 1.0f, 1.6f}) {
        CHECK(light_from_around(mu, g, 0.0f, 0.0f, 0.0f, outward) == 0.0f);
        for (const float beam : {0.1f, 5.0f, 200.0f})
          for (const float total : {0.0f, 1.0f, 400.0f}) {
            const float near = std::min(beam, 0.5f * total),
                        light = light_from_around(mu, g, beam, near, total, outward);
            CHECK(std::isfinite(light));
            CHECK(light >= 0.0f);
            if (total > 0.0f && beam > 6.0f && outward > 0.0f)
              CHECK(light_from_around(mu, g, beam + 50.0f, near, total, outward) < light);
          }
      }
  // A thin cloud sends light on, a thick one back.
  CHECK(light_from_around(0.9f, 0.85f, 1.0f, 1.0f, 2.0f, 1.0f) >
        5.0f * light_from_around(-0.9f, 0.85f, 1.0f, 1.0f, 2.0f, 1.0f));
  CHECK(light_from_around(-0.9f, 0.85f, 0.0f, 0.0f, 60.0f, 1.0f) >
        4.0f * light_from_around(-0.9f, 0.85f, 0.0f, 0.0f, 2.0f, 1.0f));
}

TEST_CASE("outward flow is what scattering makes of Eddington's radiance near a boundary") {
  // Radiance 1 + 3 H/J cos(theta), scattered by Henyey and Greenstein's function into a direction: quadrature
  // over the sphere about that direction, where the azimuth averages cos(theta) to mu times its cosine.
  // Marshak: J = 2 H at the skin and J' = 3 H below it.
  const double flux = 1 / (2 + 3 * (2.0 / 3.0));
  for (const double g : {0.0, 0.5, 0.85})
    for (const double cosine : {-0.5, 0.0, 0.3, 1.0}) {
      double sum = 0;
      const int n = 200000;
      for (int i = 0; i < n; ++i) {
        const double mu = -1 + 2 * (i + 0.5) / n, d = 1 + g * g - 2 * g * mu;
        sum += 0.5 * (1 - g * g) / (d * std::sqrt(d)) * (1 + 3 * flux * mu * cosine) * 2 / n;
      }
      CHECK(double{outward_factor(float(cosine), float(g))} == doctest::Approx(std::max(sum, 0.0)).epsilon(1e-5));
    }
  CHECK(outward_factor(0.87f, -0.95f) > 0.0f);  // never negative
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

TEST_CASE("the share from above in a slab solves the diffusion equation with Marshak's boundaries") {
  for (const float g : {0.0f, 0.5f, 0.85f})
    for (const float total : {0.0f, 0.5f, 10.0f, 1e4f}) {
      CAPTURE(g);
      CAPTURE(total);
      // Linear in depth; what flows in is J - 2/3 dJ/dt: 1 at the top, 0 at the bottom.
      const float slope = slab_share_per_depth(total, g) / (1.0f - g);  // per scaled depth, growing upwards
      CHECK(slab_share_above(0.0f, total, g) + 2.0f / 3.0f * slope == doctest::Approx(1.0f).epsilon(1e-5));
      CHECK(slab_share_above(total, total, g) - 2.0f / 3.0f * slope == doctest::Approx(0.0f).epsilon(1e-5));
      CHECK(slab_share_above(0.5f * total, total, g) == doctest::Approx(0.5f));
      const float quarter = slab_share_above(0.25f * total, total, g);
      CHECK(quarter ==
            doctest::Approx(slab_share_above(0.0f, total, g) - 0.25f * total * slab_share_per_depth(total, g))
                .epsilon(1e-4));
    }
}

TEST_CASE("the share from above in a slab against random walks") {
  // Isotropic scattering: a walk from a depth ends above with the probability that light there came from above.
  // Eddington's error near a boundary is up to 0.04; 20 000 walks add 0.0035.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const double total : {1.0, 4.0})
    for (const double depth : {0.05, 0.5, 0.8}) {
      int above = 0;
      const int walks = 20000;
      for (int i = 0; i < walks; ++i) {
        double t = depth * total;
        while (t > 0.0 && t < total) t += (2.0 * uniform(random) - 1.0) * -std::log(1.0 - uniform(random));
        above += t <= 0.0;
      }
      CAPTURE(total);
      CAPTURE(depth);
      CHECK(std::abs(slab_share_above(float(depth * total), float(total), 0.0f) - double(above) / walks) < 0.05);
    }
}

TEST_CASE("the view moves the ambient share towards what lies behind, within 0..1") {
  CHECK(ambient_share_above(0.4f, 0.0f) == 0.4f);
  for (const float share : {-0.1f, 0.0f, 0.3f, 1.0f, 1.1f}) {
    float before = 0.0f;
    for (float view_z = -1.0f; view_z <= 1.0f; view_z += 0.125f) {
      const float seen = ambient_share_above(share, view_z);
      CHECK(seen >= before);
      CHECK(seen <= 1.0f);
      before = seen;
    }
  }
}

namespace {

double henyey_greenstein(double mu, double g) {
  const double d = 1 + g * g - 2 * g * mu;
  return (1 - g * g) / (4 * M_PI * d * std::sqrt(d));
}

}  // namespace

TEST_CASE("the source radiance is the sum of its terms, each behind what it has to cross") {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> u(0.0f, 1.0f);
  for (int i = 0; i < 2000; ++i) {
    const float g = -0.5f + 1.4f * u(random), mu = 2.0f * u(random) - 1.0f;
    PlaceLight light;
    light.sun_irradiance = {0.5f + u(random), u(random), 2.0f * u(random)};
    light.once_per_sr = u(random);
    light.again_per_sr = u(random);
    light.again_share = kAgainShare;
    light.tau_sun = 20.0f * u(random) * u(random);
    light.tau_self = 3.0f * u(random);
    light.tau_near = light.tau_sun * u(random);
    light.tau_cloud = light.tau_near + light.tau_self + 30.0f * u(random);
    light.outward = 2.0f * u(random);
    light.ambient_radiance = {u(random), u(random), u(random)};

    const double beam = double(light.tau_sun) + double(light.tau_self), k = 1.0 - double(g);
    const double forward = henyey_greenstein(mu, 0.5 * g) * std::max(std::exp(-k * beam) - std::exp(-beam), 0.0);
    // Eddington's slab between Marshak's boundaries, seen through what stands before the cloud.
    const double t = k * (double(light.tau_near) + double(light.tau_self)), all = k * double(light.tau_cloud);
    const double j = 5 - 3 * std::exp(-t) - (5 - std::exp(-all)) * (t + 2.0 / 3) / (all + 4.0 / 3);
    const double before = double(light.tau_sun) - double(light.tau_near);
    const double diffuse = std::max(j, 0.0) / (4 * M_PI) * double(light.outward) / (1 + 0.75 * k * before);
    const double per_irradiance = double(light.once_per_sr) +
                                  0.75 * double(light.again_per_sr) * std::exp(-k * double(light.tau_sun)) +
                                  1.15 * forward + 0.48 * diffuse;
    const vec3 radiance = source_radiance(light, mu, g);
    for (int c = 0; c < 3; ++c)
      CHECK(double(radiance[c]) ==
            doctest::Approx(double(light.sun_irradiance[c]) * per_irradiance + double(light.ambient_radiance[c]))
                .epsilon(1e-5));  // floats of some units, their last place 1e-7 of it, through a dozen operations
  }
}
