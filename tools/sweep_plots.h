// Plots of a sweep as one gnuplot script that holds its data: time against error with the Pareto front, cost by pass,
// and cost against particles, pixels and distance, as far as the sweep varies them.
#pragma once

#include <string>
#include <vector>

#include "engine/result.h"
#include "tools/sweep_report.h"

namespace nephele::tools {

// The script writes SVG files into the directory in which it runs: error_SCENE, passes_SCENE, cost_AGAINST.
std::string sweep_plot_script(const std::vector<SweepRow>& rows);

// Writes plots.gp into the directory and runs it where gnuplot is installed; else says on stderr what the plots need.
Result<void> write_sweep_plots(const std::string& directory, const std::vector<SweepRow>& rows);

}  // namespace nephele::tools
