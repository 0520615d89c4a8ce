// What `render --stats` reports: the frames' times and work, as JSON.
#pragma once

#include <string>
#include <vector>

#include "engine/device.h"
#include "passes/nephele.h"

namespace nephele::tools {

const char* quality_name(Quality quality);
Quality quality_named(const std::string& name);  // medium for any other name: options are checked before

// Times over all timed frames (median, for passes and cpu_ms); overflow is the worst frame's, other counts the last
// one's.
std::string render_stats_json(const DeviceInfo& device, const RenderSettings& settings,
                              const std::vector<FrameStats>& frames);

}  // namespace nephele::tools
