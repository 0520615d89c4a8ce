// The rays that nephele probe reads: CSV with a header line that names the columns, in any order.
#pragma once

#include <string>
#include <vector>

#include "engine/result.h"
#include "shared/prelude.h"

namespace nephele::tools {

// As probe.comp reads it.
struct ProbeRay {
  shared::vec3 entry, direction, light;
  float optical_radius = 0;
};
static_assert(sizeof(ProbeRay) == 40);

struct ProbeRays {
  std::string header;              // as typed, without the line's end
  std::vector<std::string> lines;  // one a ray, likewise; blank lines are left out
  std::vector<ProbeRay> rays;      // vectors normalised
};

// Columns beyond the ten known ones are carried along. The first fault is an error that names file, line and column.
Result<ProbeRays> read_probe_rays(const std::string& path, double max_optical_radius);

}  // namespace nephele::tools
