#include "tools/fly/panel.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "engine/check.h"
#include "tools/fly/window.h"

namespace nephele::fly {
namespace {

// Where a slider moves; other values of the accepted range can be typed (Ctrl and a click).
struct SliderRange {
  const char* key;
  double from, to;
  bool logarithmic = false;
};
constexpr SliderRange kSliderRanges[] = {
    {"sun.azimuth_deg", 0, 360},
    {"sun.elevation_deg", -10, 90},
    {"sun.irradiance", 0, 4},
    {"exposure_ev", -6, 6},
    {"clouds.base_m", 100, 5000},
    {"clouds.thickness_m", 100, 8000, true},
    {"clouds.extinction_per_m", 0.001, 0.5, true},
    {"clouds.wind_m_per_s", -40, 40},
    {"clouds.growth_period_s", 0, 3600},
    {"clouds.view_distance_m", 5000, 200000, true},
};

// Their change needs other tables, compiled kernels or all light anew: the picture pauses meanwhile.
constexpr const char* kSlowPrefixes[] = {"phase."};
constexpr const char* kSlowSettings[] = {"quality",
                                         "backend",
                                         "method",
                                         "light",
                                         "detail",
                                         "ring_size_cells",
                                         "layers",
                                         "crown_factor",
                                         "light_cell_m",
                                         "light_side_cells",
                                         "light_height_cells",
                                         "light_sweeps",
                                         "culling",
                                         "full_layer",
                                         "blend"};

SliderRange slider_range(const JsonKey& key, std::size_t index) {
  for (const SliderRange& range : kSliderRanges)
    if (key.path == range.key) return range;
  return {key.path.c_str(), key.ranges[index].minimum, key.ranges[index].maximum};
}

// Light in the clouds is solved anew for another sun or other clouds: a longer frame on a device without a GPU.
constexpr const char* kRelights[] = {"clouds.", "sun.", "atmosphere.", "ground."};

std::string label_of(const std::string& path) {
  const std::size_t dot = path.rfind('.');
  std::string name = dot == std::string::npos ? path : path.substr(dot + 1);
  for (const char* prefix : kSlowPrefixes)
    if (path.starts_with(prefix)) name += " (pauses)";
  for (const char* prefix : kRelights)
    if (path.starts_with(prefix)) name += " *";
  return name + "##" + path;
}

void tooltip(const std::string& text) {
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", text.c_str());
}

const char* format_of(double from, double to) {
  const double span = to - from;
  return span <= 1.0 ? "%.3f" : span <= 20.0 ? "%.2f" : span <= 1000.0 ? "%.1f" : "%.0f";
}

bool slide(const char* label, double* values, int count, const SliderRange& range) {
  const ImGuiSliderFlags flags = range.logarithmic ? ImGuiSliderFlags_Logarithmic : 0;
  return ImGui::SliderScalarN(label, ImGuiDataType_Double, values, count, &range.from, &range.to,
                              format_of(range.from, range.to), flags);
}

}  // namespace

Panel::Panel() {
  for (JsonKey& key : scene_keys())
    if (is_editable(key.path) && !key.path.starts_with("camera.") && key.path != "world_origin_m")
      keys_.push_back(std::move(key));
}

bool Panel::section(const char* name, bool open_at_first) const {
  if (all_open) ImGui::SetNextItemOpen(true);
  return ImGui::CollapsingHeader(name, open_at_first ? ImGuiTreeNodeFlags_DefaultOpen : 0);
}

void Panel::report(const Result<void>& done) { error_ = done ? "" : done.error().message; }

void Panel::draw_key(Viewer& viewer, const JsonKey& key) {
  const Result<SceneValue> present = value_of(viewer.scene(), key.path);
  if (!present) return;  // clouds.* of a scene without clouds
  SceneValue value = *present;
  const std::string label = label_of(key.path);
  bool changed = false;
  if (auto* on = std::get_if<bool>(&value)) {
    changed = ImGui::Checkbox(label.c_str(), on);
  } else if (auto* number = std::get_if<double>(&value)) {
    if (key.kind == JsonKind::whole_number) {
      int whole = static_cast<int>(std::min(*number, 2147483647.0));
      changed = ImGui::InputInt(label.c_str(), &whole);
      *number = whole;
    } else {
      changed = slide(label.c_str(), number, 1, slider_range(key, 0));
    }
  } else if (auto* vector = std::get_if<std::vector<double>>(&value)) {
    changed = slide(label.c_str(), vector->data(), static_cast<int>(vector->size()), slider_range(key, 0));
  } else if (auto* text = std::get_if<std::string>(&value)) {
    if (ImGui::BeginCombo(label.c_str(), text->c_str())) {
      for (const std::string& choice : key.choices)
        if (ImGui::Selectable(choice.c_str(), choice == *text)) {
          *text = choice;
          changed = true;
        }
      ImGui::EndCombo();
    }
  }
  tooltip(key.path + ": " + key.accepted);
  if (!changed) return;
  report(viewer.edit(key.path, value));
}

void Panel::draw_scene(Viewer& viewer) {
  std::string group;
  bool open = true;
  for (const JsonKey& key : keys_) {
    const std::size_t dot = key.path.find('.');
    const std::string of = dot == std::string::npos ? "scene" : key.path.substr(0, dot);
    if (of != group) {
      group = of;
      open = section(of.c_str(), of == "sun" || of == "clouds");
      if (open && of == "sun") draw_sun(viewer);
    }
    if (open) draw_key(viewer, key);
  }
}

void Panel::draw_sun(Viewer& viewer) {
  SunClock clock = viewer.sun_clock();
  bool changed = ImGui::Checkbox("by date and place", &clock.enabled);
  tooltip(
      "The sun's place by the Astronomical Almanac's low-precision formulas (Michalsky 1988): within 0.01 degrees "
      "from 1950 to 2050, without refraction");
  if (clock.enabled) {
    int date[3] = {clock.year, clock.month, clock.day};
    if (ImGui::InputInt3("year, month, day", date)) {
      clock.year = std::clamp(date[0], 1950, 2050);
      clock.month = std::clamp(date[1], 1, 12);
      clock.day = std::clamp(date[2], 1, 31);
      changed = true;
    }
    changed |= slide("UTC hour at 0 s", &clock.utc_hours, 1, {"", 0, 24});
    double place[2] = {clock.latitude_deg, clock.longitude_deg};
    if (ImGui::InputScalarN("lat., long.", ImGuiDataType_Double, place, 2, nullptr, nullptr, "%.4f")) {
      clock.latitude_deg = std::clamp(place[0], -90.0, 90.0);
      clock.longitude_deg = std::clamp(place[1], -180.0, 180.0);
      changed = true;
    }
  }
  if (changed) viewer.set_sun_clock(clock);
}

void Panel::draw_setting(Viewer& viewer, const Setting& setting) {
  const std::string key = setting.key;
  if (key == "resolution") return;  // the window's
  const Value value = setting.get(viewer.settings());
  std::string text = value_text(value);
  std::string label = key;
  for (const char* slow : kSlowSettings)
    if (key == slow) label += " (pauses)";
  if (*setting.unit) label += std::string(" / ") + setting.unit;
  bool changed = false;
  std::visit(
      [&](const auto& accepted) {
        using Kind = std::decay_t<decltype(accepted)>;
        if constexpr (std::is_same_v<Kind, Toggle>) {
          bool on = std::get<bool>(value);
          changed = ImGui::Checkbox(label.c_str(), &on);
          text = value_text(Value(on));
        } else if constexpr (std::is_same_v<Kind, OneOfNames> || std::is_same_v<Kind, OneOfNumbers>) {
          std::vector<std::string> choices;
          if constexpr (std::is_same_v<Kind, OneOfNames>)
            choices = accepted.names;
          else
            for (const std::uint64_t number : accepted.numbers) choices.push_back(value_text(Value(number)));
          if (!ImGui::BeginCombo(label.c_str(), text.c_str())) return;
          for (const std::string& choice : choices)
            if (ImGui::Selectable(choice.c_str(), choice == text)) {
              text = choice;
              changed = true;
            }
          ImGui::EndCombo();
        } else {  // numbers: taken at Enter, since a number half typed is another
          changed = ImGui::InputText(label.c_str(), &text,
                                     ImGuiInputTextFlags_CharsDecimal | ImGuiInputTextFlags_EnterReturnsTrue);
        }
      },
      setting.accepted);
  tooltip(std::string(setting.help) + ": " + accepted_words(setting.accepted));
  if (changed) report(viewer.set(setting, text));
}

void Panel::draw_settings(Viewer& viewer) {
  if (!section("rendering", false)) return;
  ImGui::PushID("rendering");
  for (const Setting& setting : all_settings()) draw_setting(viewer, setting);
  ImGui::PopID();
}

void Panel::draw_costs(const PanelFacts& facts, Viewer& viewer) {
  if (!section("cost", true)) return;
  const std::vector<float> times(facts.frame_ms.begin(), facts.frame_ms.end());
  if (!times.empty()) {
    const std::string now = concat(static_cast<int>(std::lround(times.back())), " ms a frame");
    ImGui::PlotLines("##frames", times.data(), static_cast<int>(times.size()), 0, now.c_str(), 0.0f, FLT_MAX,
                     ImVec2(-1, 60));
  }
  double target = viewer.frame_target_ms;
  if (slide("target ms", &target, 1, {"", 0, 200})) viewer.frame_target_ms = target;
  tooltip("Held with a coarser cloud layer and a smaller image; 0: always full size, as while a flight is recorded");
  ImGui::Text("drawn at %ux%u, layer 1/%u", facts.drawn.width, facts.drawn.height, facts.drawn.scale);
  ImGui::Text("panel %.2f ms", facts.panel_ms);
  if (!facts.stats) return;
  const FrameStats& stats = *facts.stats;
  ImGui::Text("%u particles, %u in view, %.0f MiB", stats.particles_generated, stats.particles_visible,
              static_cast<double>(stats.gpu_memory_bytes) / (1024.0 * 1024.0));
  if (stats.pairs_shaded) ImGui::Text("%llu pairs shaded", static_cast<unsigned long long>(stats.pairs_shaded));
  for (const auto& [buffer, lost] : stats.overflow)
    if (lost > 0)
      ImGui::TextColored(ImVec4(1.0f, 0.4f, 0.3f, 1.0f), "%llu items found no room in \"%s\"",
                         static_cast<unsigned long long>(lost), buffer.c_str());
  double all = 0, most = 1e-6;
  for (const PassTime& pass : stats.passes) all += pass.gpu_ms, most = std::max(most, pass.gpu_ms);
  ImGui::Text("passes, %.1f ms in all", all);
  for (const PassTime& pass : stats.passes) {
    const std::string text = concat(pass.name, "  ", number_text(std::round(100 * pass.gpu_ms) / 100));
    ImGui::ProgressBar(static_cast<float>(pass.gpu_ms / most), ImVec2(-1, 0), text.c_str());
  }
}

void Panel::draw_truth(const PanelFacts& facts, Requests& requests) {
  if (!section("truth", false)) return;
  requests.truth = ImGui::Button("trace this view");
  ImGui::SameLine();
  requests.truth_end = ImGui::Button("end");
  int look = static_cast<int>(truth_look);
  ImGui::RadioButton("truth", &look, static_cast<int>(TruthLook::truth));
  ImGui::SameLine();
  ImGui::RadioButton("error", &look, static_cast<int>(TruthLook::error));
  tooltip("Blue: drawn too dark, red: too bright, full colour at 50 %");
  ImGui::SameLine();
  ImGui::Checkbox("over half the picture", &truth_split);
  truth_look = static_cast<TruthLook>(look);
  if (!facts.truth_state.empty()) ImGui::TextUnformatted(facts.truth_state.c_str());
  if (!facts.truth) return;
  ImGui::Text("%u samples a pixel, noise %.1f %%", facts.truth->samples, 100 * facts.truth->mean_relative_error);
  if (!facts.truth->tile_error) return ImGui::TextUnformatted("no opaque tiles of 4 x 4 pixels in this view");
  ImGui::Text("opaque tiles: error %.1f %%, 95th percentile %.1f %%", 100 * *facts.truth->tile_error,
              100 * facts.truth->tile_error_p95.value_or(NAN));
  if (facts.truth->thick_bias) ImGui::Text("bias %+.1f %%", 100 * *facts.truth->thick_bias);
}

Panel::Requests Panel::draw(Viewer& viewer, const PanelFacts& facts) {
  Requests requests;
  ImGui::SetNextWindowPos(ImVec2(10, 10), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize(
      ImVec2(340 * ImGui::GetIO().FontGlobalScale, std::max(200.0f, ImGui::GetIO().DisplaySize.y - 20)),
      ImGuiCond_FirstUseEver);
  if (ImGui::Begin("Nephele (F1)", &viewer.panel)) {
    ImGui::PushItemWidth(-160 * ImGui::GetIO().FontGlobalScale);
    ImGui::InputText("scene file", &file_);
    if (ImGui::Button("load")) report(viewer.load(file_));
    ImGui::SameLine();
    if (ImGui::Button("save")) report(viewer.save(file_));
    requests.picture = ImGui::Button("picture");
    ImGui::SameLine();
    requests.copy_view = ImGui::Button("copy view");
    ImGui::SameLine();
    requests.save_copy = ImGui::Button("copy command");
    tooltip("Saves the scene beside and copies the render command that draws this picture");
    if (!error_.empty()) {
      ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(1.0f, 0.4f, 0.3f, 1.0f));
      ImGui::TextWrapped("%s", error_.c_str());
      ImGui::PopStyleColor();
    }
    for (std::size_t i = 0; i < viewer.scene().views.size(); ++i) {
      if (i > 0 && i % 3 != 0) ImGui::SameLine();
      if (ImGui::Button(concat(i + 1, ' ', viewer.scene().views[i].name).c_str())) viewer.go_to_view(i);
    }
    ImGui::Checkbox("hold the clock", &viewer.paused);
    slide("seconds a second", &viewer.time_factor, 1, {"", -600, 600});
    ImGui::Text("time %.1f s    * solves the light anew", viewer.time_s());
    draw_scene(viewer);
    draw_settings(viewer);
    draw_costs(facts, viewer);
    draw_truth(facts, requests);
    ImGui::PopItemWidth();
  }
  ImGui::End();
  return requests;
}

void draw_overlay(const Viewer& viewer, const PanelFacts& facts) {
  const ImGuiIO& io = ImGui::GetIO();
  const ImGuiWindowFlags flags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                 ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing |
                                 ImGuiWindowFlags_NoNav;
  const std::vector<std::string> messages = viewer.messages();
  if (viewer.help || viewer.panel || viewer.recording() || !messages.empty()) {
    ImGui::SetNextWindowPos(ImVec2(io.DisplaySize.x - 10, 10), ImGuiCond_Always, ImVec2(1, 0));
    ImGui::SetNextWindowBgAlpha(0.5f);
    if (ImGui::Begin("##state", nullptr, flags)) {
      const CameraState& camera = viewer.camera();
      const double heading_deg = std::fmod(camera.yaw_rad / kRadiansPerDegree + 360.0, 360.0);
      ImGui::Text("altitude %.0f m  heading %.0f  speed %.0f m/s  frame %.0f ms", camera.position_m.z, heading_deg,
                  viewer.speed_m_per_s(), facts.frame_ms.empty() ? 0.0 : static_cast<double>(facts.frame_ms.back()));
      if (viewer.recording())
        ImGui::TextColored(ImVec4(1, 0.3f, 0.2f, 1), "recording, %zu frames", viewer.recorded_frames());
      for (const std::string& line : messages) ImGui::TextUnformatted(line.c_str());
      if (viewer.help) ImGui::TextUnformatted(key_help());
    }
    ImGui::End();
  }
}

void draw_loading(const std::string& stage, double fraction) {
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos(ImVec2(0.5f * io.DisplaySize.x, 0.5f * io.DisplaySize.y), ImGuiCond_Always,
                          ImVec2(0.5f, 0.5f));
  ImGui::SetNextWindowSize(ImVec2(std::min(420.0f * io.FontGlobalScale, io.DisplaySize.x - 20), 0));
  if (ImGui::Begin("##loading", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs)) {
    ImGui::TextUnformatted(stage.c_str());
    ImGui::ProgressBar(static_cast<float>(std::clamp(fraction, 0.0, 1.0)), ImVec2(-1, 0));
  }
  ImGui::End();
}

}  // namespace nephele::fly
