#include "tools/fly/viewer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/accepted.h"
#include "engine/check.h"
#include "engine/scene_writer.h"
#include "tools/fly/decimal_angles.h"
#include "tools/fly/solar_position.h"

namespace nephele::fly {
namespace {

constexpr double kStop = 1.0 / 3.0;  // of a press of + or -
constexpr double kSunRadiansPerPixel = 0.003;
constexpr double kLeastSunChangeRad = 1e-5;  // a hundredth of the disc's radius or so
constexpr float kMostExposureEv = 32.0f;
constexpr double kHalfTurn = std::numbers::pi;

}  // namespace

Viewer::Viewer(Start start)
    : frame_target_ms(start.frame_target_ms),
      scene_(std::move(start.scene)),
      scene_file_(std::move(start.scene_file)),
      settings_(start.settings),
      flight_(scene_.camera),
      camera_(with_decimal_angles(flight_.camera())),
      time_s_(start.time_s) {
  if (scene_.terrain) terrain_ = terrain_grid(*scene_.terrain);
}

RenderSettings Viewer::drawn_settings() const { return recording() ? settings_ : resolution_.apply(settings_); }

void Viewer::step(const FlyInput& input, double dt_s) {
  now_s_ += dt_s;
  std::erase_if(messages_, [this](const Message& message) { return message.until_s < now_s_; });
  for (const Action action : input.actions) act(action);
  for (const std::size_t view : input.views) go_to_view(view);
  const double frame_s = recording() ? 1.0 / kRecordedFramesPerS : std::clamp(dt_s, 0.0, kSlowestFrameS);
  flight_.step(input, frame_s, [this](const glm::dvec2& place_m) { return ground_m(place_m); });
  camera_ = with_decimal_angles(flight_.camera());
  if (recording()) {
    time_s_ = record_start_s_ + recorder_->next_time_s();
    recorder_->add(camera_);
    if (recorder_->frames() == kMostRecordedFrames) toggle_recording();
  } else if (!paused) {
    time_s_ += frame_s * time_factor;
  }
  if (input.sun_px != glm::dvec2(0.0)) drag_sun(input.sun_px);
  if (sun_clock_.enabled && !recording()) follow_sun_clock();
}

double Viewer::ground_m(const glm::dvec2& place_m) const {
  return terrain_ ? terrain_altitude_m(*terrain_, place_m) : 0.0;
}

void Viewer::act(Action action) {
  switch (action) {
    case Action::level_out:
      flight_.level_out();
      break;
    case Action::brighter:
    case Action::darker:
      scene_.exposure_ev =
          std::clamp(scene_.exposure_ev + static_cast<float>(action == Action::brighter ? kStop : -kStop),
                     -kMostExposureEv, kMostExposureEv);
      change();
      break;
    case Action::help:
      help = !help;
      break;
    case Action::panel:
      panel = !panel;
      break;
    case Action::pause:
      paused = !paused;
      break;
    case Action::record:
      toggle_recording();
      break;
    case Action::picture:
      requests_.picture = true;
      break;
    case Action::truth:
      requests_.truth = true;
      break;
    case Action::full_screen:
      requests_.full_screen = true;
      break;
    case Action::quit:
      break;  // the window's
  }
}

void Viewer::toggle_recording() {
  if (!recorder_) {
    recorder_.emplace(kRecordedFramesPerS);
    record_start_s_ = time_s_;
    resolution_.reset();
  } else {
    requests_.recording = {recorder_->text(), scene_with_camera(), record_start_s_};
    recorder_.reset();
  }
  change();
}

void Viewer::drag_sun(const glm::dvec2& px) {
  if (recording()) return say("The sun stays while a flight is recorded");
  sun_clock_.enabled = false;
  SunSettings& sun = scene_.sun;
  sun.azimuth_rad = decimal_angle(std::remainder(sun.azimuth_rad + px.x * kSunRadiansPerPixel, 2.0 * kHalfTurn));
  sun.elevation_rad =
      decimal_angle(std::clamp(sun.elevation_rad - px.y * kSunRadiansPerPixel, -0.5 * kHalfTurn, 0.5 * kHalfTurn));
  change();
}

void Viewer::follow_sun_clock() {
  const double hours = sun_clock_.utc_hours + time_s_ / 3600.0;
  const auto place = tools::solar_position({.year = sun_clock_.year,
                                            .month = sun_clock_.month,
                                            .day = sun_clock_.day,
                                            .hour = hours - 24.0 * std::floor(hours / 24.0)},
                                           sun_clock_.latitude_deg, sun_clock_.longitude_deg);
  if (!place) {
    sun_clock_.enabled = false;
    return say(place.error().message);
  }
  SunSettings& sun = scene_.sun;
  if (std::abs(std::remainder(place->azimuth_rad - sun.azimuth_rad, 2.0 * kHalfTurn)) < kLeastSunChangeRad &&
      std::abs(place->elevation_rad - sun.elevation_rad) < kLeastSunChangeRad)
    return;
  sun.azimuth_rad = decimal_angle(place->azimuth_rad);
  sun.elevation_rad = decimal_angle(place->elevation_rad);
  change();
}

void Viewer::frame_took(double frame_ms) {
  if (recording()) return;
  if (resolution_.frame_took(frame_ms, frame_target_ms, now_s_)) change();
}

Result<void> Viewer::set(const Setting& setting, const std::string& text) {
  if (recording()) return Error{"settings stay while a flight is recorded"};
  RenderSettings settings = settings_;
  if (auto ok = set_from_text(setting, settings, text, setting.key); !ok) return ok;
  settings_ = settings;
  resolution_.forget_times();
  change();
  return {};
}

void Viewer::take_back(const RenderSettings& accepted, const std::string& why) {
  settings_ = accepted;
  change();
  say(why);
}

Result<void> Viewer::edit(const std::string& key_path, const SceneValue& value) {
  if (recording()) return Error{"the scene stays while a flight is recorded"};
  if (auto ok = set_value(scene_, key_path, value); !ok) return ok;
  resolution_.forget_times();
  change();
  return {};
}

Result<void> Viewer::set_scene(Scene scene) {
  if (recording()) return Error{"the scene stays while a flight is recorded"};
  scene_ = std::move(scene);
  terrain_.reset();
  if (scene_.terrain) terrain_ = terrain_grid(*scene_.terrain);
  resolution_.forget_times();
  change();
  return {};
}

Result<void> Viewer::load(const std::string& file) {
  Result<Scene> scene = load_scene(file);
  if (!scene) return scene.error();
  if (auto ok = set_scene(std::move(*scene)); !ok) return ok;
  scene_file_ = file;
  set_camera(scene_.camera);
  return {};
}

Result<void> Viewer::save(const std::string& file) {
  if (auto ok = save_scene(scene_with_camera(), file); !ok) return ok;
  scene_file_ = file;
  return {};
}

Scene Viewer::scene_with_camera() const {
  Scene scene = scene_;
  scene.camera = camera_;
  return scene;
}

void Viewer::go_to_view(std::size_t index) {
  if (recording()) return say("Views stay while a flight is recorded");
  if (index >= scene_.views.size()) return say(concat("The scene has ", scene_.views.size(), " views"));
  set_camera(scene_.views[index].camera);
  say(scene_.views[index].name);
}

void Viewer::set_image_size(std::uint32_t width, std::uint32_t height) {
  if (recording() || (settings_.width == width && settings_.height == height)) return;
  settings_.width = width;
  settings_.height = height;
  resolution_.forget_times();
  change();
}

void Viewer::set_camera(const CameraState& camera) {
  flight_.jump_to(camera);
  camera_ = with_decimal_angles(flight_.camera());
}

void Viewer::set_sun_clock(const SunClock& clock) { sun_clock_ = clock; }

std::string Viewer::command_line(const std::string& scene_file, double time_s) const {
  const RenderSettings defaults;
  std::string line = "nephele render --scene '" + scene_file + "' --time " + number_text(time_s);
  for (const Setting& setting : all_settings()) {
    const std::string key = setting.key, value = value_text(setting.get(settings_));
    // What is done again and what is kept changes no pixel.
    if (key != "reuse" && key != "full_layer" && value != value_text(setting.get(defaults)))
      line += concat(' ', setting.option, ' ', value);
  }
  return line;
}

Viewer::Requests Viewer::take_requests() { return std::exchange(requests_, {}); }

void Viewer::say(std::string line) { messages_.push_back({std::move(line), now_s_ + kMessageS}); }

std::vector<std::string> Viewer::messages() const {
  std::vector<std::string> lines;
  for (const Message& message : messages_) lines.push_back(message.line);
  return lines;
}

std::string camera_text(const CameraState& camera) {
  return concat("{\"position_m\": [", number_text(camera.position_m.x), ", ", number_text(camera.position_m.y), ", ",
                number_text(camera.position_m.z), "], \"yaw_deg\": ", number_text(decimal_degrees(camera.yaw_rad)),
                ", \"pitch_deg\": ", number_text(decimal_degrees(camera.pitch_rad)),
                ", \"roll_deg\": ", number_text(decimal_degrees(camera.roll_rad)),
                ", \"vertical_fov_deg\": ", number_text(decimal_degrees(camera.vertical_fov_rad)), '}');
}

}  // namespace nephele::fly
