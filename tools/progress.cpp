#include "tools/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace nephele::tools {

Progress::Progress(bool quiet) : enabled_(!quiet && ::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::show(const std::string& label, double fraction) {
  using namespace std::chrono_literals;
  const Clock::time_point now = Clock::now();
  if (!enabled_ || now - start_ < 2s || now - last_draw_ < 100ms) return;
  last_draw_ = now;
  drawn_ = true;
  constexpr int kWidth = 30;
  const double done = std::clamp(fraction, 0.0, 1.0);
  const int filled = static_cast<int>(done * kWidth);
  std::fprintf(stderr, "\r\033[K[%s%s] %3.0f %% %s", std::string(static_cast<std::size_t>(filled), '#').c_str(),
               std::string(static_cast<std::size_t>(kWidth - filled), '.').c_str(), 100.0 * done, label.c_str());
  std::fflush(stderr);
}

}  // namespace nephele::tools
