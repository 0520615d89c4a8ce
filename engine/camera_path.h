// A camera path: keys in time, from the JSON file of `render --path`.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/result.h"
#include "engine/scene.h"

namespace nephele {

struct CameraKey {
  double time_s = 0.0;
  glm::dvec3 position_m{0.0};
  double yaw_rad = 0.0, pitch_rad = 0.0, roll_rad = 0.0;
};

struct CameraPath {
  double frames_per_s = 30.0;
  std::vector<CameraKey> keys;  // at least one, times strictly increasing

  // Position linear between keys, angles the short way round; before the first and after the last key it rests.
  // The field of view is the given camera's.
  CameraState at(double time_s, const CameraState& camera) const;

  // Frames from time 0 at 1 / frames_per_s apart up to and including the last key.
  std::uint64_t frame_count() const;
};

// Each key needs time_s and position_m; angles default to 0.
Result<CameraPath> load_camera_path(const std::string& path);
Result<CameraPath> parse_camera_path(std::string_view json_text, const std::string& name_for_errors);

}  // namespace nephele
