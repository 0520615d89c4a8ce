// A frame of sky alone, for tests of the atmosphere and of the final image: constants, passes, images read back.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "engine/camera.h"
#include "passes/sky/atmosphere.h"
#include "passes/sky/composite.h"
#include "shared/air.h"
#include "shared/light.h"
#include "shared/types.h"
#include "shared/world.h"
#include "tests/support/test_device.h"

namespace nephele::test {

struct SkyView {
  double altitude_m = 1500, yaw_deg = 0, pitch_deg = 0, fov_deg = 60;
  double sun_azimuth_deg = 90, sun_elevation_deg = 40;
  std::uint32_t width = 64, height = 48;
  bool atmosphere = true, ground = true;
};

inline CameraState sky_camera(const SkyView& view) {
  const double rad = M_PI / 180;
  return {.position_m = {1000, 2000, view.altitude_m},
          .yaw_rad = view.yaw_deg * rad,
          .pitch_rad = view.pitch_deg * rad,
          .roll_rad = 0,
          .vertical_fov_rad = view.fov_deg * rad};
}

inline shared::FrameConstants sky_constants(const SkyView& view) {
  const CameraState camera = sky_camera(view);
  const CameraMatrices matrices = camera_matrices(camera, double(view.width) / view.height);
  const shared::GridPlace place = shared::grid_place(camera.position_m);
  const glm::dvec3 sun = direction_from_angles(view.sun_azimuth_deg * M_PI / 180, view.sun_elevation_deg * M_PI / 180);
  shared::FrameConstants frame{};
  frame.clip_from_render = matrices.clip_from_render;
  frame.render_from_clip = matrices.render_from_clip;
  frame.camera_grid_m = place.grid_m;
  frame.sun_direction = sun;
  frame.sun_angular_radius_rad = shared::kSunRadiusRad;
  frame.sun_irradiance = glm::vec3(1.0f);
  frame.exposure = 1.0f;
  frame.ground_albedo = {0.12f, 0.14f, 0.10f};
  frame.atmosphere_enabled = view.atmosphere;
  frame.ground_enabled = view.ground;
  frame.image_size_px = frame.layer_size_px = {view.width, view.height};
  frame.scale = 1;
  frame.view_distance_m = 80000;
  frame.clouds_top_m = 1e30f;
  frame.light_from_render = shared::make_light_from_render(sun);
  return frame;
}

struct CloudLayerPixels {
  std::vector<glm::vec4> color;  // premultiplied radiance, transmittance
  std::vector<float> depth_m;
};

struct SkyPicture {
  std::uint32_t width, height;
  std::vector<glm::vec4> hdr;
  std::vector<glm::u8vec4> display;
  const glm::vec4& at(std::uint32_t x, std::uint32_t y) const { return hdr[y * width + x]; }
};

// Kept between pictures, as a renderer does.
class SkyFrame {
 public:
  explicit SkyFrame(Device& device)
      : device_(device), make_(test_kernels()), atmosphere_(make_), composite_(make_, 1024, 1024), executor_(device) {}

  SkyPicture render(const shared::FrameConstants& constants, const glm::dvec3& camera_m,
                    const CloudLayerPixels* clouds = nullptr, const Image* shadow = nullptr) {
    const std::uint32_t width = constants.image_size_px.x, height = constants.image_size_px.y;
    Buffer buffer(device_, "constants", sizeof constants);
    buffer.write(std::as_bytes(std::span(&constants, 1)));
    const Image hdr(device_, "hdr", {VK_FORMAT_R32G32B32A32_SFLOAT, width, height});
    const Image display(device_, "display", {VK_FORMAT_R8G8B8A8_UNORM, width, height});
    Image color, depth;
    const Image no_host(device_, "no_host", {VK_FORMAT_R32_SFLOAT});
    CompositeInputs inputs{
        .frame_constants = &buffer, .host_distance = &no_host, .host_radiance = &no_host, .cloud_shadow = shadow};
    if (clouds) {
      color = Image(device_, "cloud_color", {VK_FORMAT_R32G32B32A32_SFLOAT, width, height});
      depth = Image(device_, "cloud_depth", {VK_FORMAT_R32_SFLOAT, width, height});
      color.write(std::as_bytes(std::span(clouds->color)));
      depth.write(std::as_bytes(std::span(clouds->depth_m)));
      inputs.layer_color = &color;
      inputs.layer_depth = &depth;
    }
    FrameBuilder frame(device_);
    if (constants.atmosphere_enabled)
      inputs.atmosphere =
          &atmosphere_.add(frame, constants, buffer,
                           {.ground_albedo = constants.ground_albedo, .aerial_perspective = clouds != nullptr});
    composite_.add(frame, inputs, camera_m, hdr, display);
    executor_.run(frame);
    SkyPicture picture{width, height, std::vector<glm::vec4>(width * height), std::vector<glm::u8vec4>(width * height)};
    hdr.read(std::as_writable_bytes(std::span(picture.hdr)));
    display.read(std::as_writable_bytes(std::span(picture.display)));
    return picture;
  }
  SkyPicture render(const SkyView& view, const CloudLayerPixels* clouds = nullptr, const Image* shadow = nullptr) {
    return render(sky_constants(view), sky_camera(view).position_m, clouds, shadow);
  }

  AtmospherePass& atmosphere() { return atmosphere_; }
  std::vector<PassTime> times() { return executor_.pass_times(); }

 private:
  Device& device_;
  Workshop make_;
  AtmospherePass atmosphere_;
  CompositePass composite_;
  FrameExecutor executor_;
};

inline float luminance(const glm::vec4& v) { return glm::dot(glm::vec3(v), glm::vec3(0.2126f, 0.7152f, 0.0722f)); }

}  // namespace nephele::test
