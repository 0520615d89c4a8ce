// A flight as a camera path file, a key for each frame, so that `render --path` draws the same frames bit for bit.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "engine/scene.h"

namespace nephele::fly {

inline constexpr std::size_t kMostRecordedFrames = 100000;  // that a camera path holds

class FlightRecorder {
 public:
  explicit FlightRecorder(double frames_per_s) : frames_per_s_(frames_per_s) {}

  // The next frame's camera, with angles as with_decimal_angles makes them.
  void add(const CameraState& camera);
  // Seconds after the first frame of the one that add() will add next.
  double next_time_s() const { return static_cast<double>(cameras_.size()) / frames_per_s_; }
  std::size_t frames() const { return cameras_.size(); }

  std::string text() const;  // the path file

 private:
  double frames_per_s_;
  std::vector<CameraState> cameras_;
};

}  // namespace nephele::fly
