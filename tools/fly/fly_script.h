// Input from a file instead of a person: for demonstrations, measurements and tests. One step after the other, each for
// a number of frames; what happens once (actions, edits, resizing) happens in a step's first frame.
//
//   {"frame_s": 0.0333, "steps": [{"frames": 30, "move": [0, 1, 0], "actions": ["panel"]},
//                                 {"scene": {"clouds.coverage": 0.6}, "settings": {"quality": "low"}},
//                                 {"window": "minimise", "frames": 5}, {"size": [640, 360], "picture": "end.png"}]}
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/result.h"
#include "tools/fly/fly_input.h"

namespace nephele::fly {

enum class WindowChange : std::uint8_t { none, minimise, restore, full_screen };

struct ScriptStep {
  std::uint32_t frames = 1;
  FlyInput input;                                             // its actions, views and wheel in the first frame alone
  std::vector<std::pair<std::string, nlohmann::json>> scene;  // key paths and their values
  std::vector<std::pair<std::string, std::string>> settings;  // keys of the table and their values
  std::optional<glm::uvec2> size_px;                          // of the window
  WindowChange window = WindowChange::none;
  std::optional<bool> sun_clock;
  std::string picture;  // file for the step's first frame, a PNG or an EXR, at full size
  std::string save;     // file for the scene as that frame has it
};

struct FlyScript {
  std::optional<double> frame_s;  // none: frames last as long as they take
  std::vector<ScriptStep> steps;
};

Result<FlyScript> load_fly_script(const std::string& path);
Result<FlyScript> parse_fly_script(std::string_view json_text, const std::string& name_for_errors);

}  // namespace nephele::fly
