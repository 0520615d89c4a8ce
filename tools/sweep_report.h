// What a sweep found: a row a variant, as JSON for programs, CSV for spreadsheets and Markdown for people.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/statistics.h"
#include "tools/sweep_config.h"
#include "tools/sweep_record.h"

namespace nephele::tools {

struct SweepRow {
  const SweepVariant* variant = nullptr;
  Percentiles frame_ms;               // over all frames
  std::vector<double> repetition_ms;  // the median frame of each repetition
  MedianInterval ms;                  // of these
  MedianInterval ratio;               // to the scene's first variant, repetition by repetition
  double cpu_ms = 0;
  std::vector<std::pair<std::string, double>> passes_ms;  // medians over all frames, in frame order
  std::vector<std::pair<std::string, std::uint64_t>> work;
  std::optional<SweepErrors> errors;
  bool on_front = false;  // no variant of the scene is both faster and nearer to the reference (relmse)

  std::uint64_t work_of(const std::string& name) const;
};

// In the sweep's order; every variant has been measured in every repetition.
std::vector<SweepRow> sweep_rows(const Sweep& sweep, const std::vector<SweepMeasurement>& measurements);

// identity: commit, device and the like, as in the record.
nlohmann::ordered_json sweep_json(const nlohmann::ordered_json& identity, const Sweep& sweep,
                                  const std::vector<SweepRow>& rows);
std::string sweep_csv(const std::vector<SweepRow>& rows);
std::string sweep_markdown(const nlohmann::ordered_json& identity, const Sweep& sweep,
                           const std::vector<SweepRow>& rows);

// "1.02 [0.98, 1.07]"
std::string shown(const MedianInterval& interval);
// Three significant digits.
std::string shown(double value);

}  // namespace nephele::tools
