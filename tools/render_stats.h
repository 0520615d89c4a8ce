// What `render --stats` reports: the frames' times and work, as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/device.h"
#include "passes/nephele.h"

namespace nephele::tools {

// A toggle as a boolean, a size as "1280x720".
nlohmann::ordered_json json_of(const Value& value);

// Times over all timed frames (median, for passes and cpu_ms); overflow is the worst frame's, other counts the last
// one's.
std::string render_stats_json(const DeviceInfo& device, const RenderSettings& settings,
                              const std::vector<FrameStats>& frames);

}  // namespace nephele::tools
