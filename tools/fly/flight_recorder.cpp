#include "tools/fly/flight_recorder.h"

#include "engine/accepted.h"
#include "engine/check.h"
#include "tools/fly/decimal_angles.h"

namespace nephele::fly {

void FlightRecorder::add(const CameraState& camera) {
  NEPHELE_CHECK(cameras_.size() < kMostRecordedFrames);
  cameras_.push_back(camera);
}

std::string FlightRecorder::text() const {
  std::string text = concat("{\"fps\": ", number_text(frames_per_s_), ", \"keys\": [");
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const CameraState& camera = cameras_[i];
    text +=
        concat(i ? ",\n" : "\n", "  {\"time_s\": ", number_text(static_cast<double>(i) / frames_per_s_),
               ", \"position_m\": [", number_text(camera.position_m.x), ", ", number_text(camera.position_m.y), ", ",
               number_text(camera.position_m.z), "], \"yaw_deg\": ", number_text(decimal_degrees(camera.yaw_rad)),
               ", \"pitch_deg\": ", number_text(decimal_degrees(camera.pitch_rad)),
               ", \"roll_deg\": ", number_text(decimal_degrees(camera.roll_rad)), '}');
  }
  return text + "\n]}\n";
}

}  // namespace nephele::fly
