// The time of one pass of a frame.
#pragma once

#include <string>

namespace nephele {

struct PassTime {
  std::string name;
  double gpu_ms = 0;
};

}  // namespace nephele
