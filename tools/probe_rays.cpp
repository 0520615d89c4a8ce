#include "tools/probe_rays.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "engine/check.h"
#include "engine/npy.h"

namespace nephele::tools {
namespace {

constexpr std::array kColumns{"entry_x", "entry_y", "entry_z", "dir_x",   "dir_y",
                              "dir_z",   "light_x", "light_y", "light_z", "optical_radius"};
constexpr std::size_t kOpticalRadius = kColumns.size() - 1;
constexpr double kLengthTolerance = 1e-3;  // what three decimals do to a unit vector
constexpr std::size_t kMaxFileBytes = std::size_t{1} << 30;

using Fields = std::vector<std::string_view>;

Fields split(std::string_view line) {
  Fields fields;
  for (std::size_t at = 0;;) {
    const std::size_t comma = std::min(line.find(',', at), line.size());
    std::string_view field = line.substr(at, comma - at);
    while (!field.empty() && field.front() == ' ') field.remove_prefix(1);
    while (!field.empty() && field.back() == ' ') field.remove_suffix(1);
    fields.push_back(field);
    if (comma == line.size()) return fields;
    at = comma + 1;
  }
}

// Where each of kColumns stands in a line.
Result<std::array<std::size_t, kColumns.size()>> find_columns(const std::string& place, const Fields& names) {
  std::array<std::size_t, kColumns.size()> columns{};
  for (std::size_t k = 0; k < kColumns.size(); ++k) {
    const auto found = std::find(names.begin(), names.end(), kColumns[k]);
    if (found == names.end()) {
      std::string accepted;
      for (const char* column : kColumns) accepted.append(accepted.empty() ? "" : ",").append(column);
      return Error{concat(place, "column ", kColumns[k], " is missing; accepted: a header with ", accepted)};
    }
    if (std::find(found + 1, names.end(), kColumns[k]) != names.end())
      return Error{concat(place, "column ", kColumns[k], " appears twice; accepted: once")};
    columns[k] = static_cast<std::size_t>(found - names.begin());
  }
  return columns;
}

Result<double> parse_number(const std::string& place, const char* column, std::string_view text, double low,
                            double high) {
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || end != text.data() + text.size() || !(value >= low && value <= high))
    return Error{concat(place, column, " is \"", text, "\"; accepted: a number from ", low, " to ", high)};
  return value;
}

Result<ProbeRay> parse_ray(const std::string& place, const std::array<std::size_t, kColumns.size()>& columns,
                           const Fields& fields, double max_optical_radius) {
  std::array<double, kColumns.size()> values{};
  for (std::size_t k = 0; k < kColumns.size(); ++k) {
    const bool radius = k == kOpticalRadius;
    const Result<double> value = parse_number(place, kColumns[k], fields[columns[k]], radius ? 0.0 : -1.001,
                                              radius ? max_optical_radius : 1.001);
    if (!value) return value.error();
    values[k] = *value;
  }
  std::array<glm::dvec3, 3> vectors{};
  for (std::size_t v = 0; v < vectors.size(); ++v) {
    vectors[v] = {values[3 * v], values[3 * v + 1], values[3 * v + 2]};
    const double span = length(vectors[v]);
    if (!(std::abs(span - 1) <= kLengthTolerance))
      return Error{concat(place, kColumns[3 * v], ", ", kColumns[3 * v + 1], ", ", kColumns[3 * v + 2],
                          " make a vector of length ", span, "; accepted: from ", 1 - kLengthTolerance, " to ",
                          1 + kLengthTolerance)};
    vectors[v] /= span;
  }
  const double outwards = dot(vectors[0], vectors[1]);
  if (outwards > kLengthTolerance)
    return Error{concat(place, "dir_x, dir_y, dir_z lead out of the sphere: dot product with entry ", outwards,
                        "; accepted: from -1 to ", kLengthTolerance)};
  return ProbeRay{shared::vec3(vectors[0]), shared::vec3(vectors[1]), shared::vec3(vectors[2]),
                  static_cast<float>(values[kOpticalRadius])};
}

}  // namespace

Result<ProbeRays> read_probe_rays(const std::string& path, double max_optical_radius) {
  const Result<std::vector<std::byte>> file = read_file(path, kMaxFileBytes);
  if (!file) return file.error();
  std::string_view text(reinterpret_cast<const char*>(file->data()), file->size());
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // of UTF-8, as spreadsheets write it
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());

  ProbeRays result;
  std::array<std::size_t, kColumns.size()> columns{};
  std::size_t column_count = 0, line_number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = text.substr(at, end - at);
    at = end + 1;
    ++line_number;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty()) continue;

    const std::string place = concat(path, ": line ", line_number, ": ");
    const Fields fields = split(line);
    if (column_count == 0) {
      const auto found = find_columns(place, fields);
      if (!found) return found.error();
      columns = *found;
      column_count = fields.size();
      result.header = line;
      continue;
    }
    if (fields.size() != column_count)
      return Error{concat(place, fields.size(), " values; accepted: ", column_count, ", one for each column")};
    const Result<ProbeRay> ray = parse_ray(place, columns, fields, max_optical_radius);
    if (!ray) return ray.error();
    result.lines.emplace_back(line);
    result.rays.push_back(*ray);
  }
  if (column_count == 0) return find_columns(path + ": line 1: ", {}).error();
  return result;
}

}  // namespace nephele::tools
