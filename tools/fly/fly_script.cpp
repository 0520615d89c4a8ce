#include "tools/fly/fly_script.h"

#include "engine/json_reader.h"
#include "passes/settings.h"

namespace nephele::fly {
namespace {

constexpr std::size_t kMostSteps = 100000;
constexpr std::uint32_t kMostFrames = 1000000, kMostSidePx = 16384;
constexpr Range kDeflection{-1, 1}, kPixels{-1e5, 1e5};

constexpr std::pair<const char*, Action> kActionNames[] = {
    {"level_out", Action::level_out}, {"brighter", Action::brighter},
    {"darker", Action::darker},       {"help", Action::help},
    {"panel", Action::panel},         {"picture", Action::picture},
    {"record", Action::record},       {"truth", Action::truth},
    {"pause", Action::pause},         {"quit", Action::quit}};

void read_actions(JsonObject& json, std::vector<Action>& actions) {
  const nlohmann::json* list = json.value("actions");
  if (!list) return;
  std::string names;
  for (const auto& [name, action] : kActionNames) names += std::string(names.empty() ? "" : ", ") + '"' + name + '"';
  if (!list->is_array()) return json.complain(*list, json.path_of("actions"), "an array of " + names);
  for (const nlohmann::json& entry : *list) {
    bool known = false;
    for (const auto& [name, action] : kActionNames) {
      if (entry != name) continue;
      actions.push_back(action);
      known = true;
    }
    if (!known) return json.complain(entry, json.path_of("actions"), "some of " + names);
  }
}

void read_settings(JsonObject& json, std::vector<std::pair<std::string, std::string>>& settings) {
  const nlohmann::json* object = json.value("settings");
  if (!object) return;
  if (!object->is_object()) return json.complain(*object, json.path_of("settings"), "an object");
  for (const auto& [key, value] : object->items()) {
    bool known = false;
    for (const Setting& setting : all_settings()) known = known || key == setting.key;
    if (!known) return json.fail("settings", "has the unknown setting \"" + key + '"');
    const std::string text = value.is_string()    ? value.get<std::string>()
                             : value.is_boolean() ? (value.get<bool>() ? "on" : "off")
                                                  : value.dump();
    settings.emplace_back(key, text);
  }
}

void read_step(JsonObject& json, ScriptStep& step) {
  json.integer("frames", step.frames, 1, kMostFrames);
  json.vector("move", step.input.move, {kDeflection});
  json.number("roll", step.input.roll, kDeflection);
  json.vector("look_px", step.input.look_px, {kPixels});
  json.vector("look_rate", step.input.look_rate, {kDeflection});
  json.vector("sun_px", step.input.sun_px, {kPixels});
  json.number("wheel", step.input.wheel, {-100, 100});
  json.boolean("faster", step.input.faster);
  json.boolean("slower", step.input.slower);
  read_actions(json, step.input.actions);
  std::uint32_t view = 0;
  json.integer("view", view, 1, 64);
  if (view > 0) step.input.views.push_back(view - 1);
  if (const nlohmann::json* scene = json.value("scene")) {
    if (!scene->is_object()) return json.complain(*scene, json.path_of("scene"), "an object of key paths");
    for (const auto& [key, value] : scene->items()) step.scene.emplace_back(key, value);
  }
  read_settings(json, step.settings);
  std::optional<glm::dvec2> size;
  json.vector("size", size, {Range{1, kMostSidePx}});
  if (size) step.size_px = glm::uvec2(*size);
  json.choice("window", step.window,
              {{"minimise", WindowChange::minimise},
               {"restore", WindowChange::restore},
               {"full_screen", WindowChange::full_screen}});
  json.string("picture", step.picture);
  json.string("save", step.save);
}

}  // namespace

Result<FlyScript> parse_fly_script(std::string_view json_text, const std::string& name_for_errors) {
  const Result<nlohmann::json> document = parse_json(json_text, name_for_errors);
  if (!document) return document.error();
  JsonReader reader(name_for_errors);
  JsonObject root = reader.root(*document);
  FlyScript script;
  root.number("frame_s", script.frame_s, {1e-4, 1});
  root.require("steps");
  root.objects("steps", kMostSteps, [&](JsonObject& child) { read_step(child, script.steps.emplace_back()); });
  root.finish();
  if (reader.error()) return *reader.error();
  return script;
}

Result<FlyScript> load_fly_script(const std::string& path) {
  const Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  return parse_fly_script(*text, path);
}

}  // namespace nephele::fly
