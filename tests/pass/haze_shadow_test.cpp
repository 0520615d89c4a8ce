// Haze in the clouds' shadow: nothing changes without shadow, and a world all in shadow keeps only what the air
// scatters more than once.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "passes/nephele.h"
#include "passes/sky/haze_shadow.h"
#include "shared/haze_shadow_volume.h"
#include "tests/support/sky_frame.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::shared;
using nephele::test::CloudLayerPixels;
using nephele::test::luminance;
using nephele::test::SkyFrame;
using nephele::test::SkyPicture;
using nephele::test::SkyView;

namespace {

// A shadow map of one value everywhere: clouds of that opacity, thin, at that height towards the sun.
Image uniform_shadow(Device& device, float opacity, float height_m) {
  Image shadow(device, "shadow", {VK_FORMAT_R32G32B32A32_SFLOAT, 4, 4});
  const std::vector<glm::vec4> texels(16, opacity * glm::vec4(1, glm::vec3(light_warp(height_m))));
  shadow.write(std::as_bytes(std::span(texels)));
  return shadow;
}

}  // namespace

TEST_CASE("the haze of a world in shadow lacks exactly its single scattering") {
  Device& device = test::test_device();
  FrameConstants constants = test::sky_constants(
      {.altitude_m = 1500, .yaw_deg = 60, .pitch_deg = 5, .sun_elevation_deg = 25, .ground = false});
  constants.clouds_top_m = 90000.0f;  // so that no ray ends above the clouds, and without a ground none ends there
  Buffer buffer(device, "constants", sizeof constants);
  buffer.write(std::as_bytes(std::span(&constants, 1)));
  const Image shadow = uniform_shadow(device, 1.0f, 90000.0f);  // above everything within reach
  Workshop make(test::test_kernels());
  AtmospherePass atmosphere(make);
  HazeShadow pass(make);
  FrameExecutor executor(device);
  FrameBuilder frame(device);
  const AtmosphereTables& tables = atmosphere.add(frame, constants, buffer, {.ground_albedo = constants.ground_albedo});
  const Image& volume = pass.add(frame, buffer, tables.transmittance, shadow);
  executor.run(frame);

  const auto read = [](const Image& image, std::vector<glm::vec4>& texels) {
    const VkExtent3D size = image.extent();
    texels.resize(std::size_t{size.width} * size.height * size.depth);
    image.read(std::as_writable_bytes(std::span(texels)));
    return Table3D{int(size.width), int(size.height), int(size.depth), texels.data()};
  };
  std::vector<glm::vec4> transmittance_texels, lost_texels;
  const Table2D transmittance = read(tables.transmittance, transmittance_texels);
  const Table3D lost = read(volume, lost_texels);
  const vec4 black(0.0f);
  const Table2D none{1, 1, 1, &black};

  for (const vec2 place : {vec2(0.5f, 0.5f), vec2(0.1f, 0.2f), vec2(0.8f, 0.9f), vec2(0.0f, 0.0f)}) {
    const glm::vec4 far = constants.render_from_clip * glm::vec4(place * 2.0f - 1.0f, 1.0f, 1.0f);
    const vec3 direction = normalize(vec3(far));
    const ViewRay ray{constants.camera_grid_m.z, direction.z, constants.sun_direction.z,
                      dot(direction, constants.sun_direction)};
    for (const float distance_m : {500.0f, 5000.0f, 30000.0f, 80000.0f}) {
      ViewMarch march = begin_march(ray, 0.0f);
      for (int i = 1; i <= 400; ++i)
        march_to(transmittance, none, ray, distance_m * static_cast<float>(i) / 400.0f, march);
      const vec3 wanted = march.smooth_light + march.aerosol_light * aerosol_phase(ray.sun_cos_view);
      const vec3 got = haze_shadow_lookup(lost, place, distance_m, constants.view_distance_m);
      CAPTURE(distance_m);
      for (int c = 0; c < 3; ++c) CHECK(got[c] == doctest::Approx(wanted[c]).epsilon(0.03));  // 48 steps, 25 slices
    }
  }
}

TEST_CASE("rays that end above the clouds or under the ground lose nothing") {
  Scene scene;
  scene.clouds->coverage = 0.6f;
  scene.clouds->view_distance_m = 30000.0f;
  scene.sun.elevation_rad = 0.3;
  // A listed particle may be at any height, so every ray goes on to its end. Nobody sees this one, and by tables
  // nothing else sees it either.
  Scene anywhere = scene;
  anywhere.particles.push_back(
      {.center_m = {0.0, 0.0, 60000.0}, .ellipsoid = {glm::vec3(0.01f), glm::vec3(0)}, .density = 1e-6f});
  for (const double pitch_rad : {-0.3, 0.1, 0.6}) {
    for (const double altitude_m : {300.0, 6000.0}) {
      CAPTURE(pitch_rad);
      CAPTURE(altitude_m);
      scene.camera.position_m.z = altitude_m;
      scene.camera.pitch_rad = pitch_rad;
      std::vector<float> pictures[2];
      for (const Scene* of : {&scene, &anywhere}) {
        auto renderer = Renderer::create(test::test_sky(), *of,
                                         {.width = 96, .height = 54, .quality = Quality::low, .light = Light::tables});
        REQUIRE_MESSAGE(renderer, renderer.error().message);
        (*renderer)->render(scene.camera, 0.0);
        pictures[of == &anywhere] = (*renderer)->read_hdr();
      }
      double sum = 0.0, worst = 0.0;
      for (std::size_t i = 0; i < pictures[0].size(); i += 4)
        for (std::size_t c = 0; c < 3; ++c) {
          sum += pictures[1][i + c];
          worst = std::max<double>(worst, std::abs(pictures[0][i + c] - pictures[1][i + c]));
        }
      // Pixels between a ray that sinks into the ground and one that does not.
      CHECK(worst < 0.005 * sum / (3.0 * 96 * 54));
    }
  }
}

TEST_CASE("a shadow darkens what is behind it, in proportion, and light stays positive") {
  Device& device = test::test_device();
  SkyFrame sky(device);
  for (const double sun_deg : {2.0, 40.0}) {
    const SkyView view{.altitude_m = 600, .yaw_deg = 80, .pitch_deg = 4, .fov_deg = 60, .sun_elevation_deg = sun_deg};
    const CloudLayerPixels none{std::vector<glm::vec4>(view.width * view.height, {0, 0, 0, 1}),
                                std::vector<float>(view.width * view.height, INFINITY)};
    const Image off = uniform_shadow(device, 0.0f, 0.0f), half = uniform_shadow(device, 0.5f, 90000.0f);
    const Image full = uniform_shadow(device, 1.0f, 90000.0f);
    const SkyPicture open = sky.render(view, &none), same = sky.render(view, &none, &off);
    const SkyPicture dim = sky.render(view, &none, &half), dark = sky.render(view, &none, &full);
    CHECK(same.hdr == open.hdr);
    for (std::size_t i = 0; i < open.hdr.size(); i += 41) {
      if (luminance(open.hdr[i]) > 100.0f) continue;  // the sun's disc
      CHECK(luminance(dark.hdr[i]) >= 0.0f);
      CHECK(luminance(dark.hdr[i]) < luminance(open.hdr[i]));
      CHECK(luminance(dim.hdr[i]) ==
            doctest::Approx(0.5f * (luminance(open.hdr[i]) + luminance(dark.hdr[i]))).epsilon(0.01));
    }
  }
}
