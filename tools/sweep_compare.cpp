#include "tools/sweep_compare.h"

#include <algorithm>
#include <sstream>

#include "engine/check.h"

namespace nephele::tools {
namespace {

using nlohmann::json;

MedianInterval interval_of(const json& value) { return {value.at("median"), value.at("low"), value.at("high")}; }

struct OldRow {
  json settings;
  MedianInterval ms, ratio;
};

std::vector<OldRow> old_rows(const json& results) {
  std::vector<OldRow> rows;
  for (const json& variant : results.at("variants"))
    rows.push_back({variant.at("settings").get_ref<const json::object_t&>(), interval_of(variant.at("ms")),
                    interval_of(variant.at("ratio"))});
  return rows;
}

// Results written before a setting was there have it at its default.
bool same_picture(const json& old, const json& now) {
  static const json defaults = describe(SweepPicture{}, json::object());
  json completed = defaults;
  completed.update(old);
  return completed == now;
}

}  // namespace

Result<SweepComparison> compare_sweeps(const std::vector<SweepRow>& rows, const json& old_results,
                                       const std::string& old_name, double slowdown) {
  std::vector<OldRow> old;
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
    const auto found = std::find_if(old.begin(), old.end(), [&](const OldRow& candidate) {
      return same_picture(candidate.settings, row.variant->picture.description);
    });
    if (found == old.end()) continue;
    const OldRow& before = *found;
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
