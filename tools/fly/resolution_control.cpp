#include "tools/fly/resolution_control.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace nephele::fly {
namespace {

struct Level {
  double image;         // of the image's sides
  std::uint32_t layer;  // further divisor of the cloud layer's, up to 4 in all
  double cost;          // relative to level 0, roughly: as measured at 1280x720 on a software driver
};
constexpr Level kLevel[ResolutionControl::kLevels] = {{1.0, 1, 1.0},   {1.0, 2, 0.5},  {0.75, 2, 0.32},
                                                      {0.75, 4, 0.22}, {0.5, 4, 0.13}, {0.35, 4, 0.09}};

std::uint32_t scaled(std::uint32_t pixels, double factor) {
  return std::max(1u, static_cast<std::uint32_t>(std::lround(pixels * factor)));
}

}  // namespace

RenderSettings ResolutionControl::apply(const RenderSettings& chosen, std::size_t level) {
  RenderSettings settings = chosen;
  settings.width = scaled(chosen.width, kLevel[level].image);
  settings.height = scaled(chosen.height, kLevel[level].image);
  settings.scale = std::min(4u, chosen.scale * kLevel[level].layer);
  return settings;
}

RenderSettings ResolutionControl::apply(const RenderSettings& chosen) const { return apply(chosen, level_); }

void ResolutionControl::forget_times() { times_ms_.clear(); }

void ResolutionControl::reset() { *this = {}; }

double ResolutionControl::median_ms() const {
  std::vector<double> sorted(times_ms_.begin(), times_ms_.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

void ResolutionControl::go_to(std::size_t level) {
  level_ = level;
  forget_times();
}

bool ResolutionControl::frame_took(double frame_ms, double target_ms, double now_s) {
  if (target_ms <= 0.0) {
    const bool changed = level_ != 0;
    if (changed) reset();
    return changed;
  }
  times_ms_.push_back(frame_ms);
  if (times_ms_.size() > kWindow) times_ms_.pop_front();
  if (times_ms_.size() < kWindow) return false;
  const double median = median_ms();
  if (median > kTooSlow * target_ms && level_ + 1 < kLevels) {
    wait_s_[level_] = wait_s_[level_] > 0.0 ? std::min(2.0 * wait_s_[level_], kLongestWaitS) : kFirstWaitS;
    barred_until_s_[level_] = now_s + wait_s_[level_];
    go_to(level_ + 1);
    return true;
  }
  if (level_ == 0 || now_s < barred_until_s_[level_ - 1]) return false;
  if (median * kLevel[level_ - 1].cost / kLevel[level_].cost > kRoomy * target_ms) return false;
  go_to(level_ - 1);
  return true;
}

}  // namespace nephele::fly
