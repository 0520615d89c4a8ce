// One value of a scene, by the path that its key has in a scene file: for panels, options and scripts.
//
// Editable are the keys of camera, sun, atmosphere, ground, clouds and phase, exposure_ev and world_origin_m. What a
// scene lists (views, particles, sources), its terrain and the files that it names are left alone: neither read nor
// copied, so that an edit costs microseconds however much the scene holds.
#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/result.h"
#include "engine/scene.h"

namespace nephele {

// In the file's unit (degrees). A whole number is a double; a vector of N numbers has N.
using SceneValue = std::variant<bool, double, std::string, std::vector<double>>;

// Whether with_value may change what stands at the path. A key of scene_keys() (engine/json_reader.h) whose path this
// refuses belongs to a list, is a file, or is an object, whose members are edited one by one.
bool is_editable(std::string_view key_path);

// Sets the value at the key, "camera.yaw_deg", as a scene file with that key would. Errors are the reader's line, with
// `name` where it names the file, and leave the scene as it was. clouds.* in a scene without clouds, and
// clouds.weather_map.* in one without a map, are errors.
Result<void> set_value(Scene& scene, const std::string& key_path, const SceneValue& value,
                       const std::string& name = "scene");

// The same on a copy of the scene; copying is what it costs.
Result<Scene> with_value(const Scene& scene, const std::string& key_path, const SceneValue& value,
                         const std::string& name = "scene");

// The value at the key, such that set_value of it changes nothing in a scene that came from a file. An error line where
// the scene has none: unknown keys, clouds.* without clouds, camera.look_at_m, which is not kept but sets yaw and
// pitch.
Result<SceneValue> value_of(const Scene& scene, const std::string& key_path, const std::string& name = "scene");

}  // namespace nephele
