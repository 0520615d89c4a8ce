// Water in the final image: the sun's glint where the mirror stands, and darkness elsewhere.
#include <doctest/doctest.h>

#include <cmath>

#include "shared/atmosphere_tables.h"
#include "shared/ground.h"
#include "shared/water.h"
#include "tests/support/sky_frame.h"

using namespace nephele;
using nephele::test::luminance;
using nephele::test::SkyFrame;
using nephele::test::SkyPicture;
using nephele::test::SkyView;

namespace {

float water_at(const glm::dvec2& world_m, float footprint_m) {
  const shared::GridPlace place = shared::grid_place(glm::dvec3(world_m, 0));
  return shared::ground_cover(glm::vec2(place.grid_m), place.origin_index, {1, 0}, footprint_m, footprint_m).water;
}

// The middle of a lake that is at least 240 m wide in all directions.
glm::dvec2 lake_m() {
  for (double ring_m = 0; ring_m < 300e3; ring_m += 150)
    for (double along_m = -ring_m; along_m <= ring_m; along_m += 150)
      for (const glm::dvec2& p : {glm::dvec2(along_m, ring_m), glm::dvec2(ring_m, along_m)}) {
        if (water_at(p, 20) < 1) continue;
        bool wide = true;
        for (int i = 0; i < 12 && wide; ++i)
          for (const double r_m : {60.0, 120.0})
            wide = wide && water_at(p + r_m * glm::dvec2(std::cos(i * M_PI / 6), std::sin(i * M_PI / 6)), 20) == 1;
        if (wide) return p;
      }
  FAIL("no lake within 300 km");
  return {};
}

// A camera that looks at a place from 200 m up, along yaw and 50 degrees down.
struct Look {
  SkyView view;
  glm::dvec3 camera_m;
};

Look look_at(const glm::dvec2& place_m, double sun_azimuth_deg) {
  const SkyView view{.altitude_m = 200,
                     .yaw_deg = 90,
                     .pitch_deg = -50,
                     .fov_deg = 4,
                     .sun_azimuth_deg = sun_azimuth_deg,
                     .sun_elevation_deg = 50,
                     .width = 48,
                     .height = 48,
                     .atmosphere = false};
  const double back_m = 200 / std::tan(50 * M_PI / 180);
  return {view, glm::dvec3(place_m.x - back_m, place_m.y, 200)};
}

SkyPicture picture(SkyFrame& sky, const Look& look) {
  shared::FrameConstants constants = test::sky_constants(look.view);
  constants.camera_grid_m = glm::vec3(shared::grid_place(look.camera_m).grid_m);
  return sky.render(constants, look.camera_m);
}

}  // namespace

TEST_CASE("the sun glints on water in the mirror's direction, as bright as its waves say, and not beside it") {
  SkyFrame sky(test::test_device());
  const glm::dvec2 lake = lake_m();
  const double sine = std::sin(50 * M_PI / 180), variance = 0.018;
  // In a vacuum, so that the sun is all there is. Oracle: Fresnel of water at an incidence of 40 degrees is 0.0244
  // (Schlick's form: 0.0208), facets are level.
  const double mirror = 0.0208 / (M_PI * variance) / (4 * sine * sine) * sine;
  const double below = 0.024 / M_PI * sine;
  const SkyPicture glint = picture(sky, look_at(lake, 90));
  const double seen = glint.at(24, 24).y;
  CHECK(std::abs(seen - (mirror + 0.979 * below)) < 0.03 * mirror);  // green; waves hide 1 % from each other
  // Away from the mirror the water is dark: what comes from below its surface.
  for (const double azimuth_deg : {180.0, 270.0, 0.0}) {
    const double dark = picture(sky, look_at(lake, azimuth_deg)).at(24, 24).y;
    CAPTURE(azimuth_deg);
    CHECK(dark < 1.05 * below);
    CHECK(dark > 0.9 * below);
  }
  // Its width: turned by 10 degrees of azimuth the facet leans by atan(sin(5 deg) / tan(50 deg)).
  const double lean = std::sin(5 * M_PI / 180) / std::tan(50 * M_PI / 180) / std::cos(5 * M_PI / 180);
  const double turned = picture(sky, look_at(lake, 100)).at(24, 24).y - 0.979 * below;
  CHECK(std::abs(turned / mirror - std::exp(-lean * lean / variance)) < 0.06);
}

TEST_CASE("dry land does not glint") {
  SkyFrame sky(test::test_device());
  glm::dvec2 dry(0);
  while (water_at(dry, 60) > 0) dry.x += 500;
  const float towards = luminance(picture(sky, look_at(dry, 90)).at(24, 24));
  const float away = luminance(picture(sky, look_at(dry, 270)).at(24, 24));
  CHECK(std::abs(towards / away - 1.0f) < 0.001f);  // a Lambert surface; the planet's curvature turns it by 30 urad
}

TEST_CASE("water mirrors the sky: at a low angle it is brighter than from above") {
  SkyFrame sky(test::test_device());
  const glm::dvec2 lake = lake_m();
  const auto seen = [&](double pitch_deg, double altitude_m) {
    Look look = look_at(lake, 270);  // the sun behind the eye
    look.view.atmosphere = true;
    look.view.pitch_deg = pitch_deg;
    look.view.altitude_m = altitude_m;
    look.camera_m = glm::dvec3(lake.x - altitude_m / std::tan(-pitch_deg * M_PI / 180), lake.y, altitude_m);
    return luminance(picture(sky, look).at(24, 24));
  };
  const float above = seen(-80, 100), low = seen(-8, 20);
  CHECK(low > 3.0f * above);  // Fresnel: 0.02 and, over waves, about 0.3
}
