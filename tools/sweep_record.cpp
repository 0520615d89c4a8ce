#include "tools/sweep_record.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "engine/check.h"
#include "engine/json_reader.h"

namespace nephele::tools {
namespace {

using nlohmann::ordered_json;

ordered_json to_json(const SweepMeasurement& m) {
  ordered_json line{
      {"variant", m.variant}, {"repetition", m.repetition}, {"frame_ms", m.frame_ms}, {"cpu_ms", m.cpu_ms}};
  line["passes_ms"] = ordered_json::object();  // stays empty where frames have nothing to do again
  for (const auto& [name, ms] : m.passes_ms) line["passes_ms"][name] = ms;
  for (const auto& [name, count] : m.work) line["work"][name] = count;
  if (m.errors) line["errors"] = {{"rmse", m.errors->rmse}, {"relmse", m.errors->relmse}, {"bias", m.errors->bias}};
  return line;
}

SweepMeasurement from_json(const ordered_json& line) {
  SweepMeasurement m{.variant = line.at("variant"),
                     .repetition = line.at("repetition"),
                     .frame_ms = line.at("frame_ms"),
                     .cpu_ms = line.at("cpu_ms")};
  for (const auto& [name, ms] : line.at("passes_ms").items())
    m.passes_ms.emplace_back(name, ms.get<std::vector<double>>());
  for (const auto& [name, count] : line.at("work").items()) m.work.emplace_back(name, count.get<std::uint64_t>());
  if (line.contains("errors")) {
    const ordered_json& errors = line["errors"];
    m.errors = SweepErrors{errors.at("rmse"), errors.at("relmse"), errors.at("bias")};
  }
  return m;
}

Error failed(const std::string& path, const char* what) {
  return Error{path + ": can't be " + what + ": " + std::strerror(errno)};
}

}  // namespace

Result<SweepRecord> SweepRecord::open(const std::string& path, const ordered_json& identity) {
  std::string text;
  if (std::filesystem::exists(path)) {
    Result<std::string> found = read_text_file(path);
    if (!found) return found.error();
    text = std::move(*found);
  }
  const std::size_t complete = text.find_last_of('\n') + 1;  // 0: no line at all

  SweepRecord record(path, ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666));
  if (record.descriptor_ < 0) return failed(path, "written");
  std::size_t line_number = 0;
  for (std::size_t start = 0; start < complete;) {
    const std::size_t end = text.find('\n', start);
    ++line_number;
    const std::string_view written = std::string_view(text).substr(start, end - start);
    if (auto ok = check_json_text(written, concat(path, ": line ", line_number)); !ok) return ok.error();
    try {
      const ordered_json line = ordered_json::parse(written);
      if (line_number > 1)
        record.measurements_.push_back(from_json(line));
      else if (line != identity)
        return Error{concat(path, ": holds the measurements of another sweep, program or device (", line.dump(),
                            "); this is ", identity.dump(), "; give another --out or remove it")};
    } catch (const ordered_json::exception&) {
      return Error{concat(path, ": line ", line_number, " is not a measurement; give another --out or remove it")};
    }
    start = end + 1;
  }
  // Refused records are left as they were; only now is a torn line cut off.
  if (complete < text.size() && ::ftruncate(record.descriptor_, static_cast<off_t>(complete)) != 0)
    return failed(path, "shortened");
  if (complete == 0)
    if (auto begun = record.append(identity); !begun) return begun.error();
  return record;
}

SweepRecord::SweepRecord(SweepRecord&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      measurements_(std::move(other.measurements_)) {}

SweepRecord::~SweepRecord() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool SweepRecord::has(const std::string& variant, std::uint32_t repetition) const {
  return std::any_of(measurements_.begin(), measurements_.end(),
                     [&](const SweepMeasurement& m) { return m.variant == variant && m.repetition == repetition; });
}

Result<void> SweepRecord::add(SweepMeasurement measurement) {
  if (auto appended = append(to_json(measurement)); !appended) return appended;
  measurements_.push_back(std::move(measurement));
  return {};
}

Result<void> SweepRecord::append(const ordered_json& line) {
  const std::string text = line.dump() + '\n';
  for (std::size_t written = 0; written < text.size();) {
    const ssize_t count = ::write(descriptor_, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failed(path_, "written");
    written += static_cast<std::size_t>(count);
  }
  if (::fdatasync(descriptor_) != 0) return failed(path_, "written");
  return {};
}

}  // namespace nephele::tools
