// The final image: continuity at the horizon, the cloud layer between near and far, shadows, and the extremes of
// altitude and sun.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "shared/atmosphere_tables.h"
#include "shared/tonemap.h"
#include "tests/support/sky_frame.h"

using namespace nephele;
using nephele::test::CloudLayerPixels;
using nephele::test::luminance;
using nephele::test::SkyFrame;
using nephele::test::SkyPicture;
using nephele::test::SkyView;

namespace {

CloudLayerPixels uniform_layer(const SkyView& view, const glm::vec4& color, float depth_m) {
  const std::size_t pixels = std::size_t{view.width} * view.height;
  return {std::vector<glm::vec4>(pixels, color), std::vector<float>(pixels, depth_m)};
}

bool sane(const SkyPicture& picture) {
  return std::all_of(picture.hdr.begin(), picture.hdr.end(), [](const glm::vec4& v) {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < 1e6f && v.y < 1e6f && v.z < 1e6f && v.w == 1;
  });
}

float largest_difference(const SkyPicture& a, const SkyPicture& b) {
  float worst = 0;
  for (std::size_t i = 0; i < a.hdr.size(); ++i)
    for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(a.hdr[i][c] - b.hdr[i][c]));
  return worst;
}

}  // namespace

TEST_CASE("every altitude and sun gives a finite picture, dark at night and bright by day") {
  SkyFrame sky(test::test_device());
  for (const double altitude_m : {0.0, 2.0, 11000.0, 40000.0, 400000.0}) {
    for (const double sun_deg : {-90.0, -18.0, -4.0, 0.0, 0.5, 45.0, 90.0}) {
      CAPTURE(altitude_m);
      CAPTURE(sun_deg);
      for (const double pitch_deg : {-90.0, 0.0}) {
        const SkyView view{.altitude_m = altitude_m,
                           .yaw_deg = 80,
                           .pitch_deg = pitch_deg,
                           .sun_elevation_deg = sun_deg,
                           .width = 32,
                           .height = 24};
        const CloudLayerPixels layer = uniform_layer(view, {0.1f, 0.1f, 0.1f, 0.5f}, 30000.0f);
        const SkyPicture clear = sky.render(view), cloudy = sky.render(view, &layer);
        REQUIRE(sane(clear));
        REQUIRE(sane(cloudy));
        if (sun_deg == 45.0 && pitch_deg == 0.0 && altitude_m < 40000.0) CHECK(luminance(clear.at(16, 12)) > 0.02f);
        if (sun_deg <= -18.0 && altitude_m < 40000.0) CHECK(luminance(clear.at(16, 12)) < 1e-5f);
      }
    }
  }
}

TEST_CASE("two runs give the same bytes") {
  SkyFrame first(test::test_device()), second(test::test_device());
  const SkyView view{.yaw_deg = 70, .pitch_deg = 10, .sun_elevation_deg = 20};
  const SkyPicture a = first.render(view), b = second.render(view), c = first.render(view);
  CHECK(a.hdr == b.hdr);
  CHECK(a.display == b.display);
  CHECK(a.hdr == c.hdr);
}

TEST_CASE("from the air the horizon is neither a line nor a step") {
  SkyFrame sky(test::test_device());
  for (const double altitude_m : {1500.0, 11000.0}) {
    for (const double yaw_deg : {0.0, 90.0, 270.0}) {
      const double dip_deg = std::acos(6360e3 / (6360e3 + altitude_m)) * 180 / M_PI;
      const SkyView view{
          .altitude_m = altitude_m, .yaw_deg = yaw_deg, .pitch_deg = -dip_deg, .fov_deg = 8, .width = 8, .height = 160};
      const SkyPicture picture = sky.render(view);
      CAPTURE(altitude_m);
      CAPTURE(yaw_deg);
      // Rows are 0.05 degrees high; no row differs from the mean of its neighbours by more than a shade.
      for (std::uint32_t y = 60; y < 100; ++y) {
        const float here = luminance(picture.at(4, y)),
                    around = 0.5f * (luminance(picture.at(4, y - 1)) + luminance(picture.at(4, y + 1)));
        CHECK(std::abs(here / around - 1.0f) < 0.012f);
        CHECK(std::abs(luminance(picture.at(4, y + 1)) / here - 1.0f) < 0.03f);
      }
    }
  }
}

TEST_CASE("the horizon has no steps: a pixel's share of sky varies smoothly along it") {
  SkyFrame sky(test::test_device());
  const SkyView view{.altitude_m = 2, .pitch_deg = 0.02, .fov_deg = 10, .width = 64, .height = 64};
  CameraState camera = test::sky_camera(view);
  camera.roll_rad = 0.03;
  shared::FrameConstants constants = test::sky_constants(view);
  const CameraMatrices matrices = camera_matrices(camera, 1.0);
  constants.clip_from_render = matrices.clip_from_render;
  constants.render_from_clip = matrices.render_from_clip;
  const SkyPicture picture = sky.render(constants, camera.position_m);
  // Summed down the columns, brightness follows the slant horizon without jumps of a whole pixel.
  const auto column = [&](std::uint32_t x) {
    float sum = 0;
    for (std::uint32_t y = 20; y < 44; ++y) sum += luminance(picture.at(x, y));
    return sum;
  };
  const float step = (column(62) - column(1)) / 61.0f;
  for (std::uint32_t x = 1; x < 62; ++x) CHECK(std::abs(column(x + 1) - column(x) - step) < 0.004f);
}

TEST_CASE("a vacuum shows the cloud layer and nothing else") {
  SkyFrame sky(test::test_device());
  SkyView view{.yaw_deg = 90, .pitch_deg = 32, .sun_elevation_deg = 35, .atmosphere = false};
  const SkyPicture empty = sky.render(view);
  CHECK(std::all_of(empty.hdr.begin(), empty.hdr.end(), [](const glm::vec4& v) { return v == glm::vec4(0, 0, 0, 1); }));
  CHECK(empty.display[0] == glm::u8vec4(0, 0, 0, 255));

  CloudLayerPixels layer = uniform_layer(view, {0.2f, 0.3f, 0.4f, 0.25f}, 5000.0f);
  layer.color[7] = {0, 0, 0, 1};
  layer.depth_m[7] = INFINITY;
  view.ground = false;
  const SkyPicture clouds = sky.render(view, &layer);
  CHECK(clouds.hdr[6] == glm::vec4(0.2f, 0.3f, 0.4f, 1.0f));
  CHECK(clouds.hdr[7] == glm::vec4(0, 0, 0, 1));
}

TEST_CASE("ground in a vacuum is a Lambert surface of the scene's albedo") {
  SkyFrame sky(test::test_device());
  // From far up the pattern is averaged away.
  const SkyPicture picture = sky.render({.altitude_m = 60000,
                                         .pitch_deg = -90,
                                         .fov_deg = 90,
                                         .sun_elevation_deg = 90,
                                         .width = 64,
                                         .height = 64,
                                         .atmosphere = false});
  glm::dvec3 mean(0);
  for (const glm::vec4& v : picture.hdr) mean += glm::dvec3(v) / double(picture.hdr.size());
  for (int c = 0; c < 3; ++c) CHECK(mean[c] == doctest::Approx(glm::vec3(0.12f, 0.14f, 0.10f)[c] / M_PI).epsilon(0.05));
}

TEST_CASE("without a ground the sky goes on below the horizon") {
  SkyFrame sky(test::test_device());
  const SkyView view{.altitude_m = 2, .yaw_deg = 30, .fov_deg = 40, .width = 16, .height = 81, .ground = false};
  const SkyPicture picture = sky.render(view);
  REQUIRE(sane(picture));
  CHECK(luminance(picture.at(8, 41)) == doctest::Approx(luminance(picture.at(8, 39))).epsilon(0.03));
  CHECK(luminance(picture.at(8, 75)) == doctest::Approx(luminance(picture.at(8, 5))).epsilon(0.1));
}

TEST_CASE("clouds: clear ones change nothing, near ones are themselves, far ones dissolve in the haze") {
  SkyFrame sky(test::test_device());
  const SkyView view{.altitude_m = 1500, .yaw_deg = 20, .pitch_deg = 3, .fov_deg = 20, .sun_elevation_deg = 40};
  const SkyPicture clear = sky.render(view);
  const CloudLayerPixels none = uniform_layer(view, {0, 0, 0, 1}, INFINITY);
  const CloudLayerPixels transparent = uniform_layer(view, {0, 0, 0, 1}, 20000.0f);
  CHECK(largest_difference(sky.render(view, &none), clear) == 0.0f);
  CHECK(largest_difference(sky.render(view, &transparent), clear) == 0.0f);

  const glm::vec4 white(0.25f, 0.25f, 0.25f, 0.0f);
  const CloudLayerPixels near = uniform_layer(view, white, 10.0f);
  for (const glm::vec4& v : sky.render(view, &near).hdr) CHECK(luminance(v) == doctest::Approx(0.25).epsilon(0.002));

  // A black wall ever farther away takes on the sky's colour, monotonically.
  float previous = 1.0f;
  for (const float distance_m : {1e3f, 1e4f, 3e4f, 1e5f, 2.5e5f}) {
    const CloudLayerPixels wall = uniform_layer(view, {0, 0, 0, 0}, distance_m);
    const SkyPicture picture = sky.render(view, &wall);
    const float contrast = 1.0f - luminance(picture.at(32, 24)) / luminance(clear.at(32, 24));
    CAPTURE(distance_m);
    CHECK(contrast < previous);
    CHECK(contrast > -0.02f);
    previous = contrast;
  }
  CHECK(previous < 0.1f);
}

TEST_CASE("near the horizon a far black wall is as bright as the sky: no bright or dark fringe") {
  SkyFrame sky(test::test_device());
  // From two metres the ground's edge is 5 km away; rays just above it must not inherit its short haze.
  const SkyView view{.altitude_m = 2, .yaw_deg = 20, .pitch_deg = 0.6, .fov_deg = 1.0, .width = 4, .height = 100};
  const SkyPicture clear = sky.render(view);
  const CloudLayerPixels wall = uniform_layer(view, {0, 0, 0, 0}, 200000.0f);
  const SkyPicture hazed = sky.render(view, &wall);
  for (std::uint32_t y = 0; y < 100; ++y) {
    CAPTURE(y);
    CHECK(luminance(hazed.at(2, y)) / luminance(clear.at(2, y)) > 0.93f);
    CHECK(luminance(hazed.at(2, y)) / luminance(clear.at(2, y)) < 1.02f);
  }
}

TEST_CASE("the sun's disc is as bright as its irradiance says, and clouds hide it") {
  SkyFrame sky(test::test_device());
  const SkyView view{.altitude_m = 2,
                     .yaw_deg = 90,
                     .pitch_deg = 40,
                     .fov_deg = 2,
                     .sun_elevation_deg = 40,
                     .width = 100,
                     .height = 100};
  const SkyPicture picture = sky.render(view);
  double sum = 0;
  const double pixel_sr = std::pow(2.0 * std::tan(M_PI / 180) / 100, 2);
  for (const glm::vec4& v : picture.hdr) sum += luminance(v) * pixel_sr;
  CHECK(sum > 0.70);  // transmittance at 40 degrees, and a percent of aureole
  CHECK(sum < 0.80);
  // The same power in a picture whose pixels are wider than the disc.
  SkyView coarse = view;
  coarse.fov_deg = 40, coarse.width = coarse.height = 41;
  const SkyPicture small = sky.render(coarse);
  double center = 0;
  for (std::uint32_t y = 19; y <= 21; ++y)
    for (std::uint32_t x = 19; x <= 21; ++x)
      center += luminance(small.at(x, y)) * std::pow(2.0 * std::tan(20 * M_PI / 180) / 41, 2);
  CHECK(center == doctest::Approx(sum).epsilon(0.15));

  const auto behind = [&](float transmittance) {
    const CloudLayerPixels cloud = uniform_layer(view, {0.1f, 0.1f, 0.1f, transmittance}, 3000.0f);
    return double(luminance(sky.render(view, &cloud).at(50, 50)));
  };
  const double disc = luminance(picture.at(50, 50)), hidden = behind(0);
  CHECK(hidden < 1);  // aureole only
  CHECK(behind(1e-2f) - hidden == doctest::Approx(1e-2 * disc).epsilon(0.01));
  // Blending may end at 1e-4: what is left there must not show a disc 1e5 times as bright as the sky.
  CHECK(behind(1e-4f) - hidden < 1e-6 * disc);
  CHECK(behind(5e-4f) - hidden > 1e-4 * disc);
  CHECK(behind(5e-4f) - hidden < 4e-4 * disc);
}

TEST_CASE("clouds shade the ground from the sun but not from the sky") {
  Device& device = test::test_device();
  SkyFrame sky(device);
  const SkyView view{.altitude_m = 3000, .pitch_deg = -60, .fov_deg = 30, .sun_elevation_deg = 50};
  const CloudLayerPixels none = uniform_layer(view, {0, 0, 0, 1}, INFINITY);
  // Opaque clouds everywhere, high above the ground: opacity, then the same times their warped height.
  const float height = shared::light_warp(20000.0f);
  Image shadow(device, "shadow", {VK_FORMAT_R32G32B32A32_SFLOAT, 4, 4});
  const std::vector<glm::vec4> opaque(16, glm::vec4(1, height, height, height));
  shadow.write(std::as_bytes(std::span(opaque)));
  const SkyPicture open = sky.render(view, &none), shaded = sky.render(view, &none, &shadow);
  REQUIRE(sane(shaded));
  for (std::size_t i = 0; i < open.hdr.size(); i += 97) {
    CHECK(luminance(shaded.hdr[i]) < 0.8f * luminance(open.hdr[i]));
    CHECK(luminance(shaded.hdr[i]) > 0.1f * luminance(open.hdr[i]));
    CHECK(shaded.hdr[i].z / shaded.hdr[i].x > open.hdr[i].z / open.hdr[i].x);  // what is left is sky blue
  }
}

TEST_CASE("the display image is the HDR image through the tone map") {
  SkyFrame sky(test::test_device());
  // Away from the sun, whose glare the display has alone.
  const SkyPicture picture = sky.render({.yaw_deg = 230, .pitch_deg = 5});
  for (std::uint32_t y = 0; y < picture.height; y += 7) {
    for (std::uint32_t x = 0; x < picture.width; x += 5) {
      const glm::vec3 wanted = shared::display_color(picture.at(x, y), 1.0f, {x, y});
      for (int c = 0; c < 3; ++c)
        CHECK(std::abs(float(picture.display[y * picture.width + x][c]) - wanted[c] * 255.0f) < 0.6f);
    }
  }
}

TEST_CASE("the sun's glare is in the display image alone, and not when a cloud hides the sun") {
  SkyFrame sky(test::test_device());
  const SkyView view{.altitude_m = 2, .yaw_deg = 90, .pitch_deg = 42, .fov_deg = 20, .sun_elevation_deg = 40};
  const auto glare = [&](const SkyPicture& picture, std::uint32_t x, std::uint32_t y) {
    return float(picture.display[y * picture.width + x].z) -
           shared::display_color(picture.at(x, y), 1.0f, {x, y}).z * 255.0f;
  };
  const SkyPicture clear = sky.render(view);
  CHECK(glare(clear, 32, 22) > 1.2f);          // near the sun; next to it the sky is white by itself
  CHECK(std::abs(glare(clear, 2, 2)) < 0.6f);  // far from it: rounding
  const CloudLayerPixels cloud = uniform_layer(view, {0.02f, 0.02f, 0.02f, 0.0f}, 500.0f);
  CHECK(std::abs(glare(sky.render(view, &cloud), 32, 22)) < 0.6f);
}
