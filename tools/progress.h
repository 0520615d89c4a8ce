// A progress bar on stderr, for people only: nothing unless it is a terminal and the work has taken two seconds.
#pragma once

#include <chrono>
#include <string>

namespace nephele::tools {

class Progress {
 public:
  explicit Progress(bool quiet);
  ~Progress();  // clears the line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // fraction: 0 to 1 of the work named by label.
  void show(const std::string& label, double fraction);

 private:
  using Clock = std::chrono::steady_clock;
  bool enabled_;
  bool drawn_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_draw_{};
};

}  // namespace nephele::tools
