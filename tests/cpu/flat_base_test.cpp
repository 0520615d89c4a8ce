// The fade above a flat base against its closed form, and the base that stands for none.
#include "shared/flat_base.h"

#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>

#include "shared/light.h"

using namespace nephele::shared;

TEST_CASE("the fade above a flat base: nothing at the base and below, a cubic over 50 m, all above") {
  for (double above_m = -60; above_m < 120; above_m += 0.25) {
    const double x = above_m / 50;  // 3 x^2 - 2 x^3 has no slope at 0 and at 1
    const double expected = above_m <= 0 ? 0 : above_m >= 50 ? 1 : x * x * (3 - 2 * x);
    CAPTURE(above_m);
    CHECK(std::abs(double(base_fade(float(above_m))) - expected) < 1e-6);  // a few units in a float's last place
  }
}

TEST_CASE("every altitude is a base, and no base stays none with an altitude added to it") {
  for (const float base_m : {-500.0f, 0.0f, 1300.0f, 20000.0f, -1e7f}) CHECK(has_base(base_m));
  CHECK_FALSE(has_base(kNoBaseM));
  for (const float altitude_m : {-500.0f, 1300.0f, 4e8f}) {
    CHECK_FALSE(has_base(kNoBaseM - altitude_m));
    CHECK(base_fade(altitude_m - kNoBaseM) == 1.0f);
  }
  // An occluder keeps its base as a height over its centre.
  Particle particle{};
  particle.center_m = {3000, -200, 900};
  particle.shape.diagonal_m = {200, 150, 80};
  LightBounds bounds;
  for (const float base_m : {kNoBaseM, 1900.0f}) {
    particle.base_m = base_m;
    const Occluder occluder = make_occluder(particle, mat3(1.0f), 1000.0f, bounds);
    CHECK(has_base(occluder.base_m) == has_base(base_m));
  }
}
