// The viewer without its window: what is flown through, how it is drawn, and what the keys do to it. A window, a script
// or a test gives it input and time, draws what camera(), time_s() and drawn_settings() say, and does what it requests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/result.h"
#include "engine/scene.h"
#include "engine/scene_edit.h"
#include "engine/terrain_grid.h"
#include "passes/nephele.h"
#include "tools/fly/flight.h"
#include "tools/fly/flight_recorder.h"
#include "tools/fly/fly_input.h"
#include "tools/fly/resolution_control.h"

namespace nephele::fly {

inline constexpr double kRecordedFramesPerS = 30.0;
inline constexpr double kSlowestFrameS = 0.25;  // a longer pause counts as this much time
inline constexpr double kMessageS = 6.0;

// Where and when the sun is looked up instead of being set by azimuth and elevation.
struct SunClock {
  bool enabled = false;
  int year = 2026, month = 6, day = 21;
  double utc_hours = 12.0;  // at scene time 0; the sun moves on with the scene's time
  double latitude_deg = 48.0, longitude_deg = 9.0;
};

class Viewer {
 public:
  struct Start {
    Scene scene;
    std::string scene_file;  // "" without one
    RenderSettings settings;
    double time_s = 0.0;
    double frame_target_ms = 0.0;  // of the dynamic resolution; 0: off
  };
  explicit Viewer(Start start);

  // One frame: moves the camera and the clocks by dt_s and acts on the keys. While a flight is recorded, a frame lasts
  // 1 / kRecordedFramesPerS whatever dt_s.
  void step(const FlyInput& input, double dt_s);

  // What to draw.
  const Scene& scene() const { return scene_; }
  const CameraState& camera() const { return camera_; }
  double time_s() const { return time_s_; }
  // As chosen, or with fewer pixels where the frame's time must be held.
  RenderSettings drawn_settings() const;
  // Counts up whenever scene (its camera aside) or drawn settings change.
  std::uint64_t version() const { return version_; }
  // The GPU time of a frame that was drawn with drawn_settings(), at the viewer's own time.
  void frame_took(double frame_ms);

  // What the panel changes. An error leaves everything as it was.
  const RenderSettings& settings() const { return settings_; }
  Result<void> set(const Setting& setting, const std::string& text);
  // The device has refused the settings: those before hold again.
  void take_back(const RenderSettings& accepted, const std::string& why);
  Result<void> edit(const std::string& key_path, const SceneValue& value);
  Result<void> set_scene(Scene scene);
  Result<void> load(const std::string& file);
  Result<void> save(const std::string& file);
  const std::string& scene_file() const { return scene_file_; }
  void go_to_view(std::size_t index);
  void set_image_size(std::uint32_t width, std::uint32_t height);
  void set_sun_clock(const SunClock& clock);
  const SunClock& sun_clock() const { return sun_clock_; }
  void set_camera(const CameraState& camera);

  // The scene from where the camera is now.
  Scene scene_with_camera() const;
  // How `render` draws that scene at that time, once it is saved in the file; what it writes is left to add.
  std::string command_line(const std::string& scene_file, double time_s) const;

  bool recording() const { return recorder_.has_value(); }
  std::size_t recorded_frames() const { return recorder_ ? recorder_->frames() : 0; }
  double speed_m_per_s() const { return flight_.speed_m_per_s(); }

  // Asked for by keys and not yet done; take clears them.
  struct Requests {
    bool picture = false, truth = false, full_screen = false;
    struct Recording {
      std::string path_text;
      Scene scene;
      double start_time_s;
    };
    std::optional<Recording> recording;  // that has just ended
  };
  Requests take_requests();
  // What a person should read, the latest last; each goes after kMessageS.
  void say(std::string line);
  std::vector<std::string> messages() const;

  bool help = false, panel = false, paused = false;
  double time_factor = 1.0;  // scene seconds a second
  double frame_target_ms = 0.0;

 private:
  void act(Action action);
  void toggle_recording();
  void drag_sun(const glm::dvec2& px);
  void follow_sun_clock();
  void change() { ++version_; }
  double ground_m(const glm::dvec2& place_m) const;

  Scene scene_;
  std::optional<TerrainGrid> terrain_;  // the scene's
  std::string scene_file_;
  RenderSettings settings_;
  Flight flight_;
  CameraState camera_;
  double time_s_, now_s_ = 0.0;
  std::uint64_t version_ = 1;
  ResolutionControl resolution_;
  std::optional<FlightRecorder> recorder_;
  double record_start_s_ = 0.0;
  SunClock sun_clock_;
  Requests requests_;
  struct Message {
    std::string line;
    double until_s;
  };
  std::deque<Message> messages_;
};

// The camera as a view of a scene file has it, to paste.
std::string camera_text(const CameraState& camera);

}  // namespace nephele::fly
