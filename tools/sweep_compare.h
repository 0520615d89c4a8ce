// A sweep against an earlier one: how each variant's time changed, and whether the ratios between variants held.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/result.h"
#include "tools/sweep_report.h"

namespace nephele::tools {

struct SweepComparison {
  std::string text;  // a table for people
  std::size_t slower = 0, compared = 0;
};

// Variants are matched by their settings and scene. One is slower when the whole interval of new / old lies above
// `slowdown`; that of the ratio goes from the new low over the old high to the new high over the old low.
Result<SweepComparison> compare_sweeps(const std::vector<SweepRow>& rows, const nlohmann::json& old_results,
                                       const std::string& old_name, double slowdown);

}  // namespace nephele::tools
