#include "tools/sweep_compare.h"

#include <map>
#include <sstream>

#include "engine/check.h"

namespace nephele::tools {
namespace {

using nlohmann::json;

MedianInterval interval_of(const json& value) { return {value.at("median"), value.at("low"), value.at("high")}; }

struct OldRow {
  MedianInterval ms, ratio;
};

std::map<std::string, OldRow> old_rows(const json& results) {
  std::map<std::string, OldRow> rows;
  for (const json& variant : results.at("variants"))
    rows[variant.at("key")] = {interval_of(variant.at("ms")), interval_of(variant.at("ratio"))};
  return rows;
}

}  // namespace

Result<SweepComparison> compare_sweeps(const std::vector<SweepRow>& rows, const json& old_results,
                                       const std::string& old_name, double slowdown) {
  std::map<std::string, OldRow> old;
  try {
    old = old_rows(old_results);
  } catch (const json::exception&) {
    return Error{old_name + ": is not the results.json of a sweep"};
  }
  SweepComparison comparison;
  std::size_t agreeing = 0;
  std::ostringstream text;
  text << "variant | old ms | new ms | new / old | ratio to the scene's first, old | new | agree\n";
  for (const SweepRow& row : rows) {
    const auto found = old.find(row.variant->picture.key);
    if (found == old.end()) continue;
    const OldRow& before = found->second;
    const MedianInterval change{row.ms.median / before.ms.median, row.ms.low / before.ms.high,
                                row.ms.high / before.ms.low};
    const bool slower = change.low > slowdown, agree = overlap(row.ratio, before.ratio);
    text << row.variant->name() << " | " << shown(before.ms.median) << " | " << shown(row.ms.median) << " | "
         << shown(change) << (slower ? " SLOWER" : "") << " | " << shown(before.ratio) << " | " << shown(row.ratio)
         << " | " << (agree ? "yes" : "no") << '\n';
    ++comparison.compared;
    comparison.slower += slower;
    agreeing += agree;
  }
  if (comparison.compared == 0) return Error{old_name + ": has no variant of this sweep"};
  text << agreeing << " of " << comparison.compared << " ratios agree within their intervals; " << comparison.slower
       << " variants are slower than " << shown(slowdown) << " times\n";
  comparison.text = text.str();
  return comparison;
}

}  // namespace nephele::tools
