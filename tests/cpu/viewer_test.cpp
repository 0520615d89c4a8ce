// The viewer without its window: recording, pictures that can be drawn again, held frame times, scripts, the panel.
#include "tools/fly/viewer.h"

#include <doctest/doctest.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "engine/camera_path.h"
#include "engine/json_reader.h"
#include "engine/scene_edit.h"
#include "engine/scene_writer.h"
#include "tests/support/support.h"
#include "tools/fly/decimal_angles.h"
#include "tools/fly/fly_script.h"
#include "tools/fly/panel.h"
#include "tools/fly/resolution_control.h"
#include "tools/fly/truth_run.h"

using namespace nephele;
using namespace nephele::fly;

namespace {

FlyInput random_input(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  FlyInput input;
  input.move = {unit(random), unit(random), unit(random)};
  input.look_px = {50 * unit(random), 50 * unit(random)};
  input.look_rate = {unit(random), unit(random)};
  input.roll = unit(random);
  input.wheel = std::round(2 * unit(random));
  return input;
}

FlyInput pressed(Action action) {
  FlyInput input;
  input.actions = {action};
  return input;
}

Viewer::Start start_of(Scene scene = {}) { return {.scene = std::move(scene), .scene_file = {}, .settings = {}}; }

// The lists of levels that a device with these costs goes through, and how often the level changes.
struct Held {
  int changes = 0;
  double last_ms = 0;
  std::size_t level = 0;
};
Held hold(double full_ms, double target_ms, double noise, double seconds) {
  constexpr double kCost[ResolutionControl::kLevels] = {1.0, 0.6, 0.4, 0.25, 0.15, 0.1};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  ResolutionControl control;
  Held held;
  for (double now_s = 0; now_s < seconds;) {
    held.last_ms = full_ms * kCost[control.level()] * (1 + noise * unit(random));
    now_s += held.last_ms * 1e-3;
    held.changes += control.frame_took(held.last_ms, target_ms, now_s);
  }
  held.level = control.level();
  return held;
}

}  // namespace

TEST_CASE("viewer: a recorded flight read back from its file is what was shown, bit for bit") {
  Viewer viewer(start_of());
  std::mt19937 random(5);
  for (int i = 0; i < 20; ++i) viewer.step(random_input(random), 0.031);
  viewer.step(pressed(Action::record), 0.031);
  CHECK(viewer.recording());
  std::vector<CameraState> shown{viewer.camera()};
  std::vector<double> times_s{viewer.time_s()};
  for (int i = 0; i < 100; ++i) {
    viewer.step(random_input(random), 0.5);
    shown.push_back(viewer.camera());
    times_s.push_back(viewer.time_s());
  }
  viewer.step(pressed(Action::record), 0.031);
  CHECK_FALSE(viewer.recording());
  const Viewer::Requests requests = viewer.take_requests();
  REQUIRE(requests.recording);
  const auto path = parse_camera_path(requests.recording->path_text, "flight");
  REQUIRE(path);
  CHECK(path->frame_count() == shown.size());
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const double time_s = static_cast<double>(i) / path->frames_per_s;  // as render counts
    const CameraState there = path->at(time_s, requests.recording->scene.camera);
    CHECK(there == shown[i]);
    CHECK(requests.recording->start_time_s + time_s == times_s[i]);
  }
}

TEST_CASE("viewer: the scene it shows, saved and read again, is the same scene") {
  const test::TempDirectory directory;
  Viewer viewer(start_of());
  std::mt19937 random(9);
  for (int i = 0; i < 30; ++i) {
    FlyInput input = random_input(random);
    input.sun_px = {10.0 * i, 3.0};
    viewer.step(input, 0.03);
    REQUIRE(viewer.save(directory / "scene.json"));
    const auto again = load_scene(directory / "scene.json");
    REQUIRE(again);
    REQUIRE(*again == viewer.scene_with_camera());
  }
  viewer.step(pressed(Action::brighter), 0.03);
  SunClock clock;
  clock.enabled = true;
  viewer.set_sun_clock(clock);
  viewer.step({}, 0.03);
  REQUIRE(viewer.save(directory / "scene.json"));
  CHECK(*load_scene(directory / "scene.json") == viewer.scene_with_camera());
}

TEST_CASE("viewer: the command line names what differs from render's own settings, and the time") {
  Viewer viewer(start_of());
  REQUIRE(viewer.set(*std::find_if(all_settings().begin(), all_settings().end(),
                                   [](const Setting& s) { return std::string(s.key) == "quality"; }),
                     "low"));
  viewer.step({}, 0.125);
  const std::string line = viewer.command_line("a b.json", viewer.time_s());
  CHECK(line.find("nephele render --scene 'a b.json' --time 0.125") == 0);
  CHECK(line.find(" --quality low") != std::string::npos);
  CHECK(line.find("--reuse") == std::string::npos);
  CHECK(line.find("--backend") == std::string::npos);
}

TEST_CASE("viewer: bad values change nothing and say what is accepted") {
  Viewer viewer(start_of());
  const std::uint64_t version = viewer.version();
  const Setting& steps = *std::find_if(all_settings().begin(), all_settings().end(),
                                       [](const Setting& s) { return std::string(s.key) == "steps"; });
  const auto refused = viewer.set(steps, "3");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().message.find("from 4 to 4096") != std::string::npos);
  CHECK_FALSE(viewer.load("no such file.json"));
  CHECK(viewer.version() == version);
  CHECK(viewer.settings().march_steps == RenderSettings{}.march_steps);
}

TEST_CASE("viewer: settings that the device refuses go back to those before, and it says why") {
  Viewer viewer(start_of());
  const RenderSettings before = viewer.settings();
  REQUIRE(viewer.set(all_settings()[1], "high"));
  const std::uint64_t version = viewer.version();
  viewer.take_back(before, "refused");
  CHECK(viewer.settings().quality == before.quality);
  CHECK(viewer.version() > version);
  CHECK(viewer.messages() == std::vector<std::string>{"refused"});
}

TEST_CASE("viewer: what must stay during a recording stays") {
  Viewer viewer(start_of());
  viewer.step(pressed(Action::record), 0.03);
  const std::uint64_t version = viewer.version();
  CHECK_FALSE(viewer.set_scene(Scene{}));
  CHECK_FALSE(viewer.set(all_settings()[1], "low"));
  viewer.set_image_size(640, 360);
  FlyInput drag;
  drag.sun_px = {20, 20};
  viewer.step(drag, 0.03);
  for (int i = 0; i < 40; ++i) viewer.frame_took(1000.0);
  CHECK(viewer.version() == version);
  CHECK(viewer.drawn_settings().width == RenderSettings{}.width);
}

TEST_CASE("viewer: keys, views and messages") {
  Scene scene;
  scene.views = {{"far", CameraState{.position_m = {1000, 2000, 3000}, .yaw_rad = 0.5}}};
  Viewer viewer(start_of(scene));
  viewer.step(pressed(Action::panel), 0.03);
  CHECK(viewer.panel);
  FlyInput view;
  view.views = {0};
  viewer.step(view, 0.0);
  CHECK(viewer.camera().position_m == glm::dvec3(1000, 2000, 3000));
  CHECK(viewer.messages() == std::vector<std::string>{"far"});
  view.views = {3};
  viewer.step(view, 0.0);
  CHECK(viewer.messages().size() == 2);
  viewer.step({}, kMessageS + 1);
  CHECK(viewer.messages().empty());
  const float ev = viewer.scene().exposure_ev;
  viewer.step(pressed(Action::brighter), 0.0);
  viewer.step(pressed(Action::brighter), 0.0);
  viewer.step(pressed(Action::darker), 0.0);
  CHECK(std::abs(viewer.scene().exposure_ev - ev - 1.0f / 3.0f) < 1e-6f);
  const double time_s = viewer.time_s();
  viewer.step(pressed(Action::pause), 0.1);
  viewer.step({}, 0.1);
  CHECK(viewer.time_s() == time_s);
}

TEST_CASE("viewer: by date and place the sun moves with the scene's time") {
  Viewer viewer(start_of());
  SunClock clock;
  clock.enabled = true;
  clock.utc_hours = 11.5;  // near noon at 9 degrees east
  viewer.set_sun_clock(clock);
  viewer.step({}, 0.01);
  const double noon = viewer.scene().sun.elevation_rad;
  CHECK(std::abs(noon * 180 / std::numbers::pi - (90 - 48 + 23.44)) < 0.3);  // midsummer
  viewer.time_factor = 3600 * 4;
  for (int i = 0; i < 4; ++i) viewer.step({}, 0.25);  // four hours on
  CHECK(viewer.scene().sun.elevation_rad < noon - 0.4);
  CHECK(viewer.scene().sun.azimuth_rad > 4.0);  // west of south
  FlyInput drag;
  drag.sun_px = {10, 0};
  viewer.step(drag, 0.01);
  CHECK_FALSE(viewer.sun_clock().enabled);
}

TEST_CASE("viewer: the ground that stops it is the scene's terrain") {
  Scene scene;
  scene.terrain = Terrain{.width = 3, .height = 3, .texels = std::vector<std::uint16_t>(9, 65535)};
  scene.terrain->origin_m = {-15000, -15000};
  scene.terrain->extent_m = {30000, 30000};
  scene.terrain->highest_m = 1000;
  scene.camera.position_m = {0, 0, 1500};
  Viewer viewer(start_of(scene));
  FlyInput down;
  down.move = {0, 0, -1};
  down.faster = true;
  for (int i = 0; i < 300; ++i) viewer.step(down, 0.05);
  CHECK(std::abs(viewer.camera().position_m.z - (1000 + kEyeHeightM)) < 1e-3);
  FlyInput slope = down;  // over the edge of the map and down to the plain
  slope.move = {1, 0, -1};
  slope.wheel = 10;
  viewer.step(slope, 0.05);
  slope.wheel = 0;
  double last_m = viewer.camera().position_m.z;
  for (int i = 0; i < 600; ++i) {
    viewer.step(slope, 0.05);
    CHECK(viewer.camera().position_m.z >=
          terrain_altitude_m(terrain_grid(*scene.terrain), glm::dvec2(viewer.camera().position_m)) + kEyeHeightM -
              1e-6);
    last_m = viewer.camera().position_m.z;
  }
  CHECK(std::abs(last_m - kEyeHeightM) < 1e-6);
}

TEST_CASE("held frame times: the target is reached, and levels settle under noise") {
  for (const double full_ms : {10.0, 30.0, 50.0, 90.0, 120.0, 200.0}) {
    CAPTURE(full_ms);
    const Held held = hold(full_ms, 33.0, 0.1, 300.0);
    CHECK(held.last_ms < 33.0 * ResolutionControl::kTooSlow * 1.1);
    // A level between two is tried again after 2, 4, ... 64 s: two changes each time.
    CHECK(held.changes <= 5 + 2 * (5 + 300 / 64 + 1));
  }
  CHECK(hold(10.0, 33.0, 0.1, 60.0).changes == 0);
  CHECK(hold(10.0, 33.0, 0.1, 60.0).level == 0);
  CHECK(hold(1000.0, 33.0, 0.1, 60.0).level == ResolutionControl::kLevels - 1);
  CHECK(hold(500.0, 0.0, 0.1, 60.0).level == 0);  // off
}

TEST_CASE("held frame times: every level draws fewer pixels than the one before, of any size") {
  for (const std::uint32_t side : {1u, 7u, 641u, 3840u})
    for (const std::uint32_t scale : {1u, 2u, 4u}) {
      RenderSettings chosen{.width = side, .height = side, .scale = scale};
      double last = INFINITY;
      for (std::size_t level = 0; level < ResolutionControl::kLevels; ++level) {
        const RenderSettings drawn = ResolutionControl::apply(chosen, level);
        CHECK(check_settings(drawn));
        const double cost = static_cast<double>(drawn.width) * drawn.height * (1 + 8.0 / (drawn.scale * drawn.scale));
        CHECK(cost <= last);
        last = cost;
      }
      CHECK(ResolutionControl::apply(chosen, 0).width == side);
    }
}

TEST_CASE("scripts: steps are read, and what is wrong is named") {
  const auto script = parse_fly_script(
      R"({"frame_s": 0.05, "steps": [{"frames": 3, "move": [0, 1, 0], "actions": ["panel"], "view": 2,
          "scene": {"sun.elevation_deg": 12}, "settings": {"quality": "low", "scale": 2, "detail": false},
          "size": [640, 360], "window": "minimise", "picture": "a.png"}]})",
      "script");
  REQUIRE(script);
  const ScriptStep& step = script->steps.at(0);
  CHECK(step.frames == 3);
  CHECK(step.input.views == std::vector<std::size_t>{1});
  CHECK(step.settings.size() == 3);
  CHECK(step.size_px == glm::uvec2(640, 360));
  CHECK(step.window == WindowChange::minimise);
  for (const auto& [text, part] : {std::pair{R"({})", "steps"},
                                   {R"({"steps": [{"frames": 0}]})", "steps[0].frames"},
                                   {R"({"steps": [{"actions": ["fly"]}]})", "steps[0].actions"},
                                   {R"({"steps": [{"settings": {"hue": 1}}]})", "hue"},
                                   {R"({"steps": [{"move": [2, 0, 0]}]})", "steps[0].move[0]"}}) {
    const auto bad = parse_fly_script(text, "script");
    REQUIRE_FALSE(bad);
    CHECK(bad.error().message.find(part) != std::string::npos);
    CHECK(bad.error().message.find("script: ") == 0);
  }
}

TEST_CASE("panel: it has a control for every setting and every editable key of a scene") {
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.DisplaySize = ImVec2(1280, 20000);  // nothing is scrolled away
  unsigned char* texels = nullptr;
  int width = 0, height = 0;
  io.Fonts->GetTexDataAsRGBA32(&texels, &width, &height);
  static std::string copied;
  io.SetClipboardTextFn = [](void*, const char* text) { copied = text; };
  Viewer viewer(start_of());
  viewer.panel = true;
  FrameStats stats;
  stats.passes = {{"composite", 3.0}};
  stats.overflow = {{"particles", 7}};
  PanelFacts facts;
  facts.stats = &stats;
  facts.frame_ms = {10.0f, 11.0f};
  Panel panel;
  panel.all_open = true;
  const std::uint64_t version = viewer.version();
  for (int frame = 0; frame < 3; ++frame) {
    io.DeltaTime = 0.03f;
    ImGui::NewFrame();
    if (frame == 2) ImGui::LogToClipboard();
    panel.draw(viewer, facts);
    if (frame == 2) ImGui::LogFinish();
    draw_overlay(viewer, facts);
    ImGui::Render();
    CHECK(ImGui::GetDrawData()->Valid);
  }
  CHECK(viewer.version() == version);  // looking changes nothing
  for (const Setting& setting : all_settings())
    if (std::string(setting.key) != "resolution") {
      CAPTURE(setting.key);
      CHECK(copied.find(setting.key) != std::string::npos);
    }
  for (const JsonKey& key : scene_keys())
    if (is_editable(key.path) && value_of(viewer.scene(), key.path) && !key.path.starts_with("camera.") &&
        key.path != "world_origin_m") {
      CAPTURE(key.path);
      CHECK(copied.find(key.path.substr(key.path.rfind('.') + 1)) != std::string::npos);
    }
  CHECK(copied.find("composite") != std::string::npos);
  CHECK(copied.find("7 items found no room") != std::string::npos);
  ImGui::DestroyContext();
}

TEST_CASE("truth beside the picture: equal pictures are white, brighter ones red, darker ones blue") {
  ImageF truth{2, 1, {"R", "G", "B", "T", "SE"}, {1, 1, 1, 0, 0, 1, 1, 1, 0, 0}};
  ImageF rendered{2, 1, {"R", "G", "B"}, {1, 1, 1, 2, 2, 2}};
  const auto picture = truth_picture(truth, rendered, TruthLook::error, 0.0f);
  CHECK(picture == std::vector<std::uint8_t>{255, 255, 255, 255, 255, 0, 0, 255});
  rendered.data = {0, 0, 0, 1, 1, 1};
  const auto dark = truth_picture(truth, rendered, TruthLook::error, 0.0f);
  CHECK(dark == std::vector<std::uint8_t>{0, 0, 255, 255, 255, 255, 255, 255});
}

TEST_CASE("truth beside the picture: averages of pixels leave out what fills no square") {
  std::vector<float> rgba;
  for (int i = 0; i < 5 * 3; ++i) rgba.insert(rgba.end(), {static_cast<float>(i), 1.0f, 0.0f, 1.0f});
  const ImageF image = averaged(rgba, 5, 3, 2);
  CHECK(image.width == 2);
  CHECK(image.height == 1);
  CHECK(image.at(0, 0, 0) == (0 + 1 + 5 + 6) / 4.0f);
  CHECK(image.at(1, 0, 0) == (2 + 3 + 7 + 8) / 4.0f);
  CHECK(image.at(1, 0, 1) == 1.0f);
}
