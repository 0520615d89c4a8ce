#include "tools/sweep_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

#include "engine/check.h"

namespace nephele::tools {
namespace {

using nlohmann::ordered_json;

ordered_json to_json(const MedianInterval& interval) {
  return {{"median", interval.median}, {"low", interval.low}, {"high", interval.high}};
}

// One variant's measurements, by repetition.
SweepRow row_of(const SweepVariant& variant, const std::vector<const SweepMeasurement*>& measurements) {
  SweepRow row{.variant = &variant};
  std::vector<double> frame_ms, cpu_ms;
  std::map<std::string, std::vector<double>> passes_ms;
  for (const SweepMeasurement* m : measurements) {
    row.repetition_ms.push_back(percentiles(m->frame_ms).median);
    frame_ms.insert(frame_ms.end(), m->frame_ms.begin(), m->frame_ms.end());
    cpu_ms.insert(cpu_ms.end(), m->cpu_ms.begin(), m->cpu_ms.end());
    for (const auto& [name, ms] : m->passes_ms) passes_ms[name].insert(passes_ms[name].end(), ms.begin(), ms.end());
    if (m->errors) row.errors = m->errors;
  }
  row.frame_ms = percentiles(frame_ms);
  row.ms = median_interval(row.repetition_ms);
  row.cpu_ms = percentiles(cpu_ms).median;
  for (const auto& [name, ms] : measurements.front()->passes_ms)
    row.passes_ms.emplace_back(name, percentiles(passes_ms[name]).median);
  row.work = measurements.front()->work;
  return row;
}

MedianInterval ratio_of(const SweepRow& row, const SweepRow& baseline) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < row.repetition_ms.size(); ++i)
    ratios.push_back(row.repetition_ms[i] / baseline.repetition_ms[i]);
  return median_interval(ratios);
}

// Calls visit(first, end) for the rows of each scene.
template <class Visit>
void each_scene(const std::vector<SweepRow>& rows, Visit&& visit) {
  for (std::size_t first = 0; first < rows.size();) {
    std::size_t end = first;
    while (end < rows.size() && rows[end].variant->scene == rows[first].variant->scene) ++end;
    visit(first, end);
    first = end;
  }
}

void mark_front(std::vector<SweepRow>& rows, std::size_t first, std::size_t end) {
  std::vector<std::size_t> indices;
  std::vector<double> ms, error;
  for (std::size_t i = first; i < end; ++i) {
    if (!rows[i].errors) continue;
    indices.push_back(i);
    ms.push_back(rows[i].ms.median);
    error.push_back(rows[i].errors->relmse);
  }
  for (const std::size_t i : pareto_front(ms, error)) rows[indices[i]].on_front = true;
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

std::string exact(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

}  // namespace

std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof text, std::abs(value) >= 100 && std::abs(value) < 1e6 ? "%.0f" : "%.3g", value);
  return text;
}

std::string shown(const MedianInterval& interval) {
  return shown(interval.median) + " [" + shown(interval.low) + ", " + shown(interval.high) + ']';
}

std::uint64_t SweepRow::work_of(const std::string& name) const {
  for (const auto& [key, count] : work)
    if (key == name) return count;
  return 0;
}

std::vector<SweepRow> sweep_rows(const Sweep& sweep, const std::vector<SweepMeasurement>& measurements) {
  std::map<std::string, std::vector<const SweepMeasurement*>> by_variant;
  for (const SweepMeasurement& m : measurements) by_variant[m.variant].push_back(&m);
  std::vector<SweepRow> rows;
  for (const SweepVariant& variant : sweep.variants) {
    std::vector<const SweepMeasurement*>& own = by_variant[variant.picture.key];
    NEPHELE_CHECK(own.size() == sweep.repetitions, variant.name(), ": ", own.size());
    std::sort(own.begin(), own.end(), [](const auto* a, const auto* b) { return a->repetition < b->repetition; });
    rows.push_back(row_of(variant, own));
  }
  each_scene(rows, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) rows[i].ratio = ratio_of(rows[i], rows[first]);
    mark_front(rows, first, end);
  });
  return rows;
}

ordered_json sweep_json(const ordered_json& identity, const Sweep& sweep, const std::vector<SweepRow>& rows) {
  ordered_json result{{"identity", identity},
                      {"warmup_frames", sweep.warmup_frames},
                      {"frames", sweep.frames},
                      {"repetitions", sweep.repetitions},
                      {"variants", ordered_json::array()}};
  for (const SweepRow& row : rows) {
    const SweepVariant& variant = *row.variant;
    ordered_json json{
        {"name", variant.name()},
        {"key", variant.picture.key},
        {"scene", variant.scene},
        {"series", variant.series},
        {"axes", variant.axes},
        {"settings", variant.picture.description},
        {"frame_ms", {{"median", row.frame_ms.median}, {"p95", row.frame_ms.p95}, {"min", row.frame_ms.min}}},
        {"repetition_ms", row.repetition_ms},
        {"ms", to_json(row.ms)},
        {"ratio", to_json(row.ratio)},
        {"cpu_ms", row.cpu_ms},
        {"passes", ordered_json::array()}};
    for (const auto& [name, ms] : row.passes_ms) json["passes"].push_back({{"name", name}, {"ms", ms}});
    for (const auto& [name, count] : row.work) json[name] = count;
    if (row.errors) {
      json["errors"] = {{"rmse", row.errors->rmse}, {"relmse", row.errors->relmse}, {"bias", row.errors->bias}};
      json["pareto"] = row.on_front;
    }
    result["variants"].push_back(std::move(json));
  }
  return result;
}

std::string sweep_csv(const std::vector<SweepRow>& rows) {
  std::vector<std::string> passes;  // of all rows
  for (const SweepRow& row : rows)
    for (const auto& [name, ms] : row.passes_ms)
      if (std::find(passes.begin(), passes.end(), name) == passes.end()) passes.push_back(name);

  std::ostringstream csv;
  csv << "scene,series,axes,frame_ms_median,frame_ms_p95,frame_ms_min,ratio,ratio_low,ratio_high,cpu_ms,rmse,relmse,"
         "bias,pareto";
  for (const auto& [name, count] : rows.front().work) csv << ',' << name;
  for (const std::string& pass : passes) csv << ',' << csv_field(pass + "_ms");
  csv << '\n';
  for (const SweepRow& row : rows) {
    csv << csv_field(row.variant->scene) << ',' << csv_field(row.variant->series) << ','
        << csv_field(row.variant->place);
    for (const double value : {row.frame_ms.median, row.frame_ms.p95, row.frame_ms.min, row.ratio.median, row.ratio.low,
                               row.ratio.high, row.cpu_ms})
      csv << ',' << exact(value);
    if (row.errors)
      csv << ',' << exact(row.errors->rmse) << ',' << exact(row.errors->relmse) << ',' << exact(row.errors->bias) << ','
          << row.on_front;
    else
      csv << ",,,,";
    for (const auto& [name, count] : row.work) csv << ',' << count;
    for (const std::string& pass : passes) {
      const auto found =
          std::find_if(row.passes_ms.begin(), row.passes_ms.end(), [&](const auto& own) { return own.first == pass; });
      csv << ',' << (found == row.passes_ms.end() ? "" : exact(found->second));
    }
    csv << '\n';
  }
  return csv.str();
}

std::string sweep_markdown(const ordered_json& identity, const Sweep& sweep, const std::vector<SweepRow>& rows) {
  std::ostringstream text;
  text << identity.at("device").get<std::string>() << ", " << identity.at("driver").get<std::string>() << ", "
       << identity.at("processors") << " processors, commit " << identity.at("commit").get<std::string>() << ". "
       << sweep.repetitions << " repetitions of " << sweep.frames
       << " frames, variants in turn; [ ] holds the median with 95 % confidence (the range, of fewer "
          "than six repetitions).\n";
  each_scene(rows, [&](std::size_t first, std::size_t end) {
    const bool errors =
        std::any_of(rows.begin() + static_cast<std::ptrdiff_t>(first), rows.begin() + static_cast<std::ptrdiff_t>(end),
                    [](const SweepRow& row) { return row.errors.has_value(); });
    text << "\nScene " << rows[first].variant->scene << (errors ? "; in bold what is on the Pareto front" : "")
         << ":\n\n"
         << "| series | | ms | p95 | ratio |" << (errors ? " RMSE | relMSE | bias |" : "")
         << " particles | visible | shaded | MiB |\n"
         << "|---|---|---|---|---|" << (errors ? "---|---|---|" : "") << "---|---|---|---|\n";
    for (std::size_t i = first; i < end; ++i) {
      const SweepRow& row = rows[i];
      const char* bold = row.on_front ? "**" : "";
      text << "| " << row.variant->series << " | " << row.variant->place << " | " << bold << shown(row.frame_ms.median)
           << bold << " | " << shown(row.frame_ms.p95) << " | " << shown(row.ratio) << " |";
      if (row.errors)
        text << ' ' << shown(row.errors->rmse) << " | " << bold << shown(row.errors->relmse) << bold << " | "
             << shown(row.errors->bias) << " |";
      else if (errors)
        text << " | | |";
      text << ' ' << row.work_of("particles_generated") << " | " << row.work_of("particles_visible") << " | "
           << row.work_of("fragments_shaded") + row.work_of("pairs_shaded") << " | "
           << row.work_of("gpu_memory_bytes") / 1048576 << " |\n";
    }
  });
  return text.str();
}

}  // namespace nephele::tools
