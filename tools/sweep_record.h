// The finished measurements of a sweep, one line of JSON each, appended as they are made: what makes a sweep resumable.
// A line is complete or, after a kill, dropped with whatever follows it.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/result.h"

namespace nephele::tools {

struct SweepErrors {
  double rmse = 0, relmse = 0, bias = 0;  // engine/image_compare.h, over R G B of the linear image
};

// One variant in one repetition: a renderer made for it, warmed up, and some frames.
struct SweepMeasurement {
  std::string variant;  // its picture's key
  std::uint32_t repetition = 0;
  std::vector<double> frame_ms, cpu_ms;                                // one a frame
  std::vector<std::pair<std::string, std::vector<double>>> passes_ms;  // in frame order; one a frame
  std::vector<std::pair<std::string, std::uint64_t>> work;             // counters and bytes of the last frame
  std::optional<SweepErrors> errors;
};

class SweepRecord {
 public:
  // Opens or begins the record. `identity` says what was measured where: a record of another one is an error.
  static Result<SweepRecord> open(const std::string& path, const nlohmann::ordered_json& identity);
  ~SweepRecord();
  SweepRecord(SweepRecord&& other) noexcept;
  SweepRecord& operator=(SweepRecord&&) = delete;

  const std::vector<SweepMeasurement>& measurements() const { return measurements_; }
  bool has(const std::string& variant, std::uint32_t repetition) const;
  // On disk when it returns.
  Result<void> add(SweepMeasurement measurement);

 private:
  SweepRecord(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}
  Result<void> append(const nlohmann::ordered_json& line);

  std::string path_;
  int descriptor_ = -1;
  std::vector<SweepMeasurement> measurements_;
};

}  // namespace nephele::tools
