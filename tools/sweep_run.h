// Measures the variants of a sweep. A repetition takes every variant in turn, so that a machine that drifts hurts all
// alike. Each has a renderer of its own; those that find no room in memory are made anew in every repetition.
#pragma once

#include "engine/device.h"
#include "tools/sweep_config.h"
#include "tools/sweep_record.h"

namespace nephele::tools {

// Adds to the record whatever the sweep still lacks in it.
Result<void> run_sweep(const Sweep& sweep, Device& device, SweepRecord& record, bool quiet);

}  // namespace nephele::tools
