// The panel: every setting of the table and every editable key of the scene file as a control, with what a frame costs.
// It draws with Dear ImGui into whatever context is current and knows no window.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "engine/json_reader.h"
#include "tools/fly/truth_run.h"
#include "tools/fly/viewer.h"

namespace nephele::fly {

// What the panel and the lines over the picture show; the viewer's host fills it.
struct PanelFacts {
  const FrameStats* stats = nullptr;  // of the last finished frame; null before the first
  std::deque<float> frame_ms;         // wall times, oldest first
  double gpu_ms = 0;                  // of the last frame that drew anything
  double panel_ms = 0;                // that the panel itself took on the CPU
  RenderSettings drawn;
  std::optional<TruthRun::Progress> truth;
  std::string truth_state;  // "" without a run
};

class Panel {
 public:
  static constexpr std::size_t kFrames = 120;  // in the graph

  Panel();

  // What was asked for that neither the viewer nor the panel can do.
  struct Requests {
    bool truth = false, truth_end = false, picture = false;
    bool save_copy = false;  // of the scene, with a line that renders it, which goes to the clipboard
    bool copy_view = false;  // the camera as JSON, to the clipboard
  };
  Requests draw(Viewer& viewer, const PanelFacts& facts);

  bool all_open = false;  // every section, whatever was clicked
  TruthLook truth_look = TruthLook::truth;
  bool truth_split = false;  // over the right half of the picture instead of beside it

 private:
  bool section(const char* name, bool open_at_first) const;
  void draw_scene(Viewer& viewer);
  void draw_sun(Viewer& viewer);
  void draw_key(Viewer& viewer, const JsonKey& key);
  void draw_settings(Viewer& viewer);
  void draw_setting(Viewer& viewer, const Setting& setting);
  void draw_costs(const PanelFacts& facts, Viewer& viewer);
  void draw_truth(const PanelFacts& facts, Requests& requests);
  void report(const Result<void>& done);

  std::vector<JsonKey> keys_;  // the editable ones
  std::string file_;           // as typed
  std::string error_;          // of the last change
};

// Lines over the picture: speed, altitude, messages, the keys.
void draw_overlay(const Viewer& viewer, const PanelFacts& facts);

// A bar and what is being done, before there is a picture.
void draw_loading(const std::string& stage, double fraction);

}  // namespace nephele::fly
