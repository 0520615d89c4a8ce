#include "engine/camera_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "engine/json_reader.h"

namespace nephele {
namespace {

constexpr std::size_t kMaxKeys = 100000;

double mix_angle(double from_rad, double to_rad, double t) {
  return from_rad + t * std::remainder(to_rad - from_rad, 2.0 * std::numbers::pi);
}

void read_key(JsonObject& json, CameraKey& key) {
  json.require("time_s");
  json.require("position_m");
  json.number("time_s", key.time_s, {0, 1e6});
  json.vector("position_m", key.position_m, {Range{-1e9, 1e9}, Range{-1e9, 1e9}, Range{0, 1e6}});
  json.number("yaw_deg", key.yaw_rad, {-3600, 3600}, kRadiansPerDegree);
  json.number("pitch_deg", key.pitch_rad, {-90, 90}, kRadiansPerDegree);
  json.number("roll_deg", key.roll_rad, {-3600, 3600}, kRadiansPerDegree);
}

}  // namespace

CameraState CameraPath::at(double time_s, const CameraState& camera) const {
  NEPHELE_CHECK(!keys.empty());
  const auto next =
      std::upper_bound(keys.begin(), keys.end(), time_s, [](double t, const CameraKey& key) { return t < key.time_s; });
  const CameraKey& a = next == keys.begin() ? keys.front() : *(next - 1);
  const CameraKey& b = next == keys.end() ? keys.back() : *next;
  const double t = b.time_s > a.time_s ? (time_s - a.time_s) / (b.time_s - a.time_s) : 0.0;
  return {.position_m = glm::mix(a.position_m, b.position_m, t),
          .yaw_rad = mix_angle(a.yaw_rad, b.yaw_rad, t),
          .pitch_rad = mix_angle(a.pitch_rad, b.pitch_rad, t),
          .roll_rad = mix_angle(a.roll_rad, b.roll_rad, t),
          .vertical_fov_rad = camera.vertical_fov_rad};
}

std::uint64_t CameraPath::frame_count() const {
  // 1e-6 of a frame: the last key's decimal time need not be a multiple of 1 / fps in binary.
  return static_cast<std::uint64_t>(std::floor(keys.back().time_s * frames_per_s + 1e-6)) + 1;
}

Result<CameraPath> parse_camera_path(std::string_view json_text, const std::string& name_for_errors) {
  const Result<nlohmann::json> document = parse_json(json_text, name_for_errors);
  if (!document) return document.error();
  JsonReader reader(name_for_errors);
  JsonObject root = reader.root(*document);
  CameraPath path;
  root.require("keys");
  root.number("fps", path.frames_per_s, {0.001, 1000});
  root.objects("keys", kMaxKeys, [&](JsonObject& child) {
    CameraKey key;
    read_key(child, key);
    if (!path.keys.empty() && key.time_s <= path.keys.back().time_s)
      reader.fail(child.path_of("time_s") +
                  concat(" is ", key.time_s, "; accepted: more than the previous key's ", path.keys.back().time_s));
    path.keys.push_back(key);
  });
  root.finish();
  if (!reader.error() && path.keys.empty()) reader.fail("keys is []; accepted: an array of at least 1 object");
  if (reader.error()) return *reader.error();
  return path;
}

Result<CameraPath> load_camera_path(const std::string& path) {
  const Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  return parse_camera_path(*text, path);
}

}  // namespace nephele
