// Holds a frame's time near a target by drawing fewer pixels: first a coarser cloud layer, then a smaller image.
//
// It goes down a level when the median of the last kWindow frames is kTooSlow times the target, and up when what the
// next level is expected to take (by the pixels, or as it was when last tried) is below kRoomy of the target. After
// every change it waits kWindow frames; a level that proved too slow is not tried again for kFirstWaitS, and twice as
// long each time that this happens, up to kLongestWaitS. So it can't swing between two levels: between equal loads the
// waits only grow.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>

#include "passes/settings.h"

namespace nephele::fly {

class ResolutionControl {
 public:
  static constexpr std::size_t kLevels = 6, kWindow = 8;
  static constexpr double kTooSlow = 1.15, kRoomy = 0.8, kFirstWaitS = 2.0, kLongestWaitS = 64.0;

  // Takes the time of a frame that was drawn at the present level. target_ms: 0 switches it off (level 0). True if the
  // level has changed.
  bool frame_took(double frame_ms, double target_ms, double now_s);
  // Other settings, another scene: the times so far say nothing.
  void forget_times();
  void reset();

  std::size_t level() const { return level_; }
  // What to draw with instead of the settings that the user has chosen.
  RenderSettings apply(const RenderSettings& chosen) const;
  static RenderSettings apply(const RenderSettings& chosen, std::size_t level);

 private:
  double median_ms() const;
  void go_to(std::size_t level);

  std::size_t level_ = 0;
  std::deque<double> times_ms_;
  std::array<double, kLevels> wait_s_{}, barred_until_s_{};
};

}  // namespace nephele::fly
