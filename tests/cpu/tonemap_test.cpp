// From radiance to code values: the curve's shape, the encoding, the dither.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "shared/tonemap.h"

using namespace nephele::shared;

TEST_CASE("the film curve rises from 0 to 1 with a continuous slope") {
  CHECK(film_curve(0.0f) == 0.0f);
  double previous = 0, slope_before = 0;
  for (int i = 1; i <= 4000; ++i) {
    const double x = i * 1e-3, y = double{film_curve(float(x))};
    const double slope = (y - previous) / 1e-3;
    CHECK(y > previous);
    CHECK(y < 1.0);
    if (i > 2) CHECK(std::abs(slope - slope_before) < 0.05);  // it rises from 0 as x^0.25
    previous = y;
    slope_before = slope;
  }
  CHECK(film_curve(1e6f) == doctest::Approx(1.0));
  const float sunlit = 0.25f * kBaseExposure;  // the brightest clouds, at 0 EV: nearly white, with room for brighter
  CHECK(film_curve(sunlit) > 0.84f);
  CHECK(film_curve(sunlit) < 0.95f);
  // A flank at half the radiance of a sunlit one is seen to be darker.
  CHECK(film_curve(0.075f * kBaseExposure) < 0.6f * film_curve(0.15f * kBaseExposure));
}

TEST_CASE("sRGB encoding against IEC 61966-2-1") {
  CHECK(srgb_from_linear(0.0f) == 0.0f);
  CHECK(srgb_from_linear(1.0f) == doctest::Approx(1.0));
  CHECK(srgb_from_linear(0.0031308f) == doctest::Approx(0.0404499).epsilon(1e-4));
  CHECK(srgb_from_linear(0.2140411f) == doctest::Approx(0.5).epsilon(1e-4));  // ((0.5 + 0.055) / 1.055)^2.4
}

TEST_CASE("grey stays grey, white stays white and colours keep their order") {
  for (const float x : {0.01f, 0.2f, 1.0f, 5.0f}) {
    const vec3 grey = tone_map(vec3(x));
    CHECK(grey.x == doctest::Approx(grey.z));
    CHECK(grey.x == doctest::Approx(film_curve(x)).epsilon(1e-4));
    const vec3 blue = tone_map(vec3(0.4f * x, 0.7f * x, x));
    CHECK(blue.x < blue.y);
    CHECK(blue.y < blue.z);
  }
  const vec3 light = tone_map(vec3(400.0f, 300.0f, 100.0f));  // bright enough to bleach
  CHECK(light.z > 0.98f);
  for (const vec3 hue : {vec3(1.0f, 0.45f, 0.1f), vec3(0.2f, 0.45f, 1.0f), vec3(0.1f, 1.0f, 0.1f)}) {
    vec3 previous(-1.0f);  // more light is never darker, in any channel
    for (float x = 1e-3f; x < 1e4f; x *= 1.05f) {
      const vec3 now = tone_map(hue * x);
      for (int c = 0; c < 3; ++c) CHECK(now[c] >= previous[c] - 1e-6f);
      CHECK(std::max({now.x, now.y, now.z}) <= 1.0f);
      previous = now;
    }
  }
}

TEST_CASE("the dither has mean zero, spans two steps and leaves black black") {
  double sum = 0, largest = 0;
  const float code = srgb_from_linear(film_curve(0.2f * kBaseExposure));
  for (std::uint32_t y = 0; y < 256; ++y) {
    for (std::uint32_t x = 0; x < 256; ++x) {
      const double offset = double{display_color(vec3(0.2f), 1.0f, uvec2(x, y)).y} - double{code};
      sum += offset;
      largest = std::max(largest, std::abs(offset));
      REQUIRE(display_color(vec3(0.0f), 1.0f, uvec2(x, y)) == vec3(0.0f));
    }
  }
  CHECK(std::abs(sum / 65536) < 0.01 / 255);
  CHECK(largest < 1.0 / 255);
  CHECK(largest > 0.9 / 255);
}
