#include "engine/image_compare.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace nephele;

namespace {

ImageF gray(std::uint32_t width, std::uint32_t height, std::vector<float> values) {
  return {width, height, {"Y"}, std::move(values)};
}

ImageErrors errors_of(const ImageF& test, const ImageF& reference, std::vector<std::string> channels = {"Y"}) {
  const Result<ImageErrors> errors = compare_images(test, "test", reference, "reference", channels);
  if (!errors) FAIL(errors.error().message);
  return *errors;
}

std::string refusal(const ImageF& test, const ImageF& reference, std::vector<std::string> channels = {"Y"}) {
  const Result<ImageErrors> errors = compare_images(test, "test", reference, "reference", channels);
  REQUIRE_FALSE(errors);
  return errors.error().message;
}

}  // namespace

TEST_CASE("compare: four values by hand") {
  const ImageErrors e = errors_of(gray(2, 2, {2, 1, 3, 4}), gray(2, 2, {1, 1, 3, 5}));
  // Errors 1, 0, 0, -1. Squares of the reference 1, 1, 9, 25: mean 9, so 0.09 is added to each.
  CHECK(e.rmse == doctest::Approx(std::sqrt(0.5)).epsilon(1e-12));
  CHECK(e.relmse == doctest::Approx((1 / 1.09 + 1 / 25.09) / 4).epsilon(1e-12));
  CHECK(e.bias == 0.0);
  CHECK(e.max_abs == 1.0);
  CHECK(e.p99_abs == 1.0);
  // The 99.9th percentile of 1, 1, 3, 5 lies at place 2.997 of 0 to 3: 3 + 0.997 * 2.
  CHECK(e.psnr_db == doctest::Approx(20 * std::log10(4.994 / std::sqrt(0.5))).epsilon(1e-12));
  CHECK(e.pixels == 4);
}

TEST_CASE("compare: bias has the sign of the image minus the reference") {
  CHECK(errors_of(gray(2, 1, {1.5f, 3}), gray(2, 1, {1, 3})).bias == doctest::Approx(0.125));
  CHECK(errors_of(gray(2, 1, {1, 3}), gray(2, 1, {1.5f, 3})).bias == doctest::Approx(-0.5 / 4.5));
}

TEST_CASE("compare: percentiles of a ramp") {
  std::vector<float> ramp, zero(101, 0.0f);
  for (int i = 0; i <= 100; ++i) ramp.push_back(static_cast<float>((37 * i) % 101));  // 0 .. 100, out of order
  const ImageErrors e = errors_of(gray(101, 1, ramp), gray(101, 1, zero));
  CHECK(e.p99_abs == 99.0);
  CHECK(e.max_abs == 100.0);
  CHECK(e.rmse == doctest::Approx(std::sqrt(3350.0)));  // the sum of squares is 100 * 101 * 201 / 6
  CHECK(std::isinf(e.relmse));                          // there is nothing to relate to
  CHECK(std::isinf(e.bias));
}

TEST_CASE("compare: channels are found by name, and all of them share one mean") {
  const ImageF test{1, 1, {"T", "R"}, {1, 4}}, reference{1, 1, {"R", "T"}, {2, 1}};
  CHECK(errors_of(test, reference, {"T"}).rmse == 0.0);
  CHECK(errors_of(test, reference, {"R"}).rmse == 2.0);
  const ImageErrors both = errors_of(test, reference, {"R", "T"});
  CHECK(both.rmse == doctest::Approx(std::sqrt(2.0)));
  CHECK(both.bias == doctest::Approx(2.0 / 3));
  CHECK(both.relmse == doctest::Approx(0.5 * 4 / (4 + 0.01 * 2.5)));
  CHECK(both.pixels == 1);
}

TEST_CASE("compare: equal images have no error, black ones neither") {
  for (const float value : {0.0f, 1.0f, -2.0f}) {
    const ImageErrors e = errors_of(gray(2, 1, {value, value}), gray(2, 1, {value, value}));
    CHECK(e.rmse == 0.0);
    CHECK(e.relmse == 0.0);
    CHECK(e.bias == 0.0);
    CHECK(e.psnr_db == std::numeric_limits<double>::infinity());
  }
}

TEST_CASE("compare: refuses what it can't compare, and says where") {
  CHECK(refusal(gray(2, 1, {1, 2}), gray(1, 2, {1, 2})) ==
        "test is 2x1 and reference is 1x2; accepted: two images of one size");
  CHECK(refusal(gray(2, 1, {1, 2}), {2, 1, {"X", "Z"}, {1, 2, 3, 4}}) ==
        "reference: has no channel \"Y\"; it has X, Z");
  CHECK(refusal(gray(1, 1, {1}), gray(1, 1, {1}), {"Y", "Y"}) == "channel \"Y\" is named twice");
  CHECK(refusal(gray(1, 1, {1}), gray(1, 1, {1}), {}) == "no channel to compare");
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  CHECK(refusal(gray(2, 2, {1, 2, 3, nan}), gray(2, 2, {1, 2, 3, 4})) ==
        "test: channel \"Y\" is nan at pixel 1, 1; accepted: finite values");
  CHECK(refusal(gray(2, 1, {1, 2}), gray(2, 1, {-infinity, 2})) ==
        "reference: channel \"Y\" is -inf at pixel 0, 0; accepted: finite values");
}

TEST_CASE("compare: a layer's errors by opacity, by hand") {
  // Two tiles of 4 x 4: the left one opaque (r 2, t 2.2), the right one thin (opacity .5: r 1, t .7), and a column
  // between .97 and .995 that neither band counts.
  ImageF test{9, 4, {"R", "G", "B", "T"}, {}}, reference = test;
  ImageF noise{9, 4, {"SE"}, {}};
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 9; ++x) {
      const bool thick = x < 4, thin = x >= 4 && x < 8;
      const float r = thick ? 2.0f : 1.0f, t = thick ? 2.2f : thin ? 0.7f : 9.0f;
      const float through = thick ? 0.001f : thin ? 0.5f : 0.02f;
      for (const float value : {r, r, r, through}) reference.data.push_back(value);
      for (const float value : {t, t, t, 0.0f}) test.data.push_back(value);
      noise.data.push_back(x == 8 ? 0.3f : 0.0f);
    }
  const Result<LayerErrors> e = compare_layers(test, "test", reference, "reference", &noise, "noise");
  REQUIRE(e);
  CHECK(e->thin_bias.value() == doctest::Approx(-0.3));
  CHECK(e->thick_bias.value() == doctest::Approx(0.1));
  CHECK(e->tile_error.value() == doctest::Approx(0.1));
  CHECK(e->tile_error_p95.value() == doctest::Approx(0.1));
  // Luminance 2 in four columns, 1 in five: mean square 21 / 9.
  CHECK(e->noise_relmse.value() == doctest::Approx(0.09 / (1 + 0.01 * 21 / 9) / 9));

  ImageF clear = reference;
  for (std::size_t i = 3; i < clear.data.size(); i += 4) clear.data[i] = 1.0f;
  const Result<LayerErrors> none = compare_layers(test, "test", clear, "reference", nullptr, "");
  REQUIRE(none);
  CHECK_FALSE(none->thin_bias);
  CHECK_FALSE(none->thick_bias);
  CHECK_FALSE(none->tile_error);
  CHECK_FALSE(none->noise_relmse);
  const Result<LayerErrors> refused = compare_layers(test, "test", reference, "reference", &reference, "noise");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().message.find("\"SE\"") != std::string::npos);
}
