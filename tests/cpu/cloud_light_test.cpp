// The lighting models' parts against their definitions in double precision, and the identities they must keep.
#include "shared/cloud_light.h"

#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <random>

using namespace nephele::shared;

TEST_CASE("the share from above in a slab solves the diffusion equation with Marshak's boundaries") {
  // Linear in the depth; the inward flux through a side is J / 2 -+ J' / 3 in scaled depths: 1 / 2 above and 0 below,
  // per unit of radiance from above.
  for (const double g : {0.0, 0.85})
    for (const double total : {0.5, 20.0}) {
      const auto share = [&](double above) { return double(slab_share_above(float(above), float(total), float(g))); };
      const double slope = (share(total) - share(0)) / ((1 - g) * total);
      CHECK(share(0) / 2 - slope / 3 == doctest::Approx(0.5).epsilon(1e-5));
      CHECK(share(total) / 2 + slope / 3 == doctest::Approx(0.0).epsilon(1e-5));
      CHECK(share(0.5 * total) == doctest::Approx(0.5).epsilon(1e-5));
    }
}

TEST_CASE("light from the field is its three parts, each behind what it has to cross") {
  const vec3 sun(1.0f, 0.9f, 0.8f), carried(0.03f, 0.02f, 0.01f);
  const vec3 all = field_source_radiance(sun, 0.3f, 2.0f, 0.05f, carried);
  for (int c = 0; c < 3; ++c)
    CHECK(double(all[c]) ==
          doctest::Approx(double(sun[c]) * (0.3 * std::exp(-2.0) + 0.05) + double(carried[c])).epsilon(1e-6));
  // No sun: what the lattice carries alone. No depth: the phase function whole.
  CHECK(field_source_radiance(vec3(0.0f), 0.3f, 2.0f, 0.05f, carried) == carried);
  CHECK(field_source_radiance(sun, 0.3f, 0.0f, 0.0f, vec3(0.0f)) == 0.3f * sun);
}

TEST_CASE("light from tables is its three parts, each behind what it has to cross") {
  TableLight light;
  light.sun_irradiance = vec3(1.0f, 0.9f, 0.8f);
  light.once_per_sr = 0.1f;
  light.again_per_sr = 0.02f;
  light.tau_sun = 3.0f;
  light.ambient_radiance = vec3(0.05f, 0.06f, 0.08f);
  const vec3 all = table_source_radiance(light);
  for (int c = 0; c < 3; ++c)
    CHECK(double(all[c]) == doctest::Approx(double(light.sun_irradiance[c]) * (0.1 + 0.02 * std::exp(-0.05 * 3.0)) +
                                            double(light.ambient_radiance[c]))
                                .epsilon(1e-6));
  light.sun_irradiance = vec3(0.0f);
  CHECK(table_source_radiance(light) == light.ambient_radiance);
}

TEST_CASE("a depth that varies inside a particle stays within a tenth and four times its mean") {
  CHECK(linear_depth(2.0f, 1.0f) == 3.0f);
  CHECK(linear_depth(2.0f, -5.0f) == doctest::Approx(0.2f));
  CHECK(linear_depth(2.0f, 50.0f) == 8.0f);
  CHECK(linear_depth(0.0f, 1.0f) == 0.0f);
}
