// nephele sweep: time, work, memory and error of many settings in one interleaved, resumable run.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <thread>

#include "commit.h"
#include "engine/atomic_file.h"
#include "engine/check.h"
#include "engine/device.h"
#include "engine/json_reader.h"
#include "tools/checked_options.h"
#include "tools/command.h"
#include "tools/render_stats.h"
#include "tools/sweep_compare.h"
#include "tools/sweep_config.h"
#include "tools/sweep_plots.h"
#include "tools/sweep_record.h"
#include "tools/sweep_report.h"
#include "tools/sweep_run.h"

namespace nephele::tools {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

struct SweepOptions {
  std::string config, out, compare, device, tuning;
  TypedSettings typed{.settings = kSweepSettings, .given = {}};
  double slowdown = 1.1;
  bool quiet = false;
};

Result<json> load_results(const std::string& path) {
  const Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  return parse_json(*text, path);
}

Result<void> write_results(const std::string& out, const ordered_json& identity, const Sweep& sweep,
                           const std::vector<SweepRow>& rows) {
  const std::pair<const char*, std::string> files[] = {
      {"results.json", sweep_json(identity, sweep, rows).dump(2) + '\n'},
      {"results.csv", sweep_csv(rows)},
      {"results.md", sweep_markdown(identity, sweep, rows)}};
  for (const auto& [name, text] : files)
    if (auto written = write_file_atomically(out + '/' + name, text); !written) return written;
  return write_sweep_plots(out, rows);
}

Result<void> run(const SweepOptions& options) {
  json typed = json::object();
  for (const Setting* setting : options.typed.given)
    typed[setting->key] = json_of(setting->get(options.typed.settings));
  const Result<Sweep> sweep = load_sweep(options.config, typed);
  if (!sweep) return sweep.error();
  // Read before the directory is written, which may be the one compared with.
  Result<json> old = json();
  if (!options.compare.empty()) old = load_results(options.compare);
  if (!old) return old.error();

  const Result<std::unique_ptr<Device>> device =
      Device::create(DeviceOptions::from_environment(options.device, options.tuning));
  if (!device) return device.error();
  std::error_code failure;
  std::filesystem::create_directories(options.out, failure);
  if (failure) return Error{options.out + ": can't be created: " + failure.message()};
  const ordered_json identity{{"sweep", sweep->hash},
                              {"commit", kCommit},
                              {"device", (*device)->info().name},
                              {"driver", (*device)->info().driver},
                              {"tuning", tuning_kind_name((*device)->tuning().kind)},
                              {"processors", std::thread::hardware_concurrency()}};
  Result<SweepRecord> record = SweepRecord::open(options.out + "/measurements.jsonl", identity);
  if (!record) return record.error();
  if (auto measured = run_sweep(*sweep, **device, *record, options.quiet); !measured) return measured;

  const std::vector<SweepRow> rows = sweep_rows(*sweep, record->measurements());
  if (auto written = write_results(options.out, identity, *sweep, rows); !written) return written;
  if (options.compare.empty()) return {};
  const Result<SweepComparison> comparison = compare_sweeps(rows, *old, options.compare, options.slowdown);
  if (!comparison) return comparison.error();
  std::fputs(comparison->text.c_str(), stdout);
  if (comparison->slower > 0)
    return Error{concat(comparison->slower, " of ", comparison->compared, " variants are slower than ",
                        options.slowdown, " times those of ", options.compare)};
  return {};
}

}  // namespace

Command add_sweep_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("sweep", "Measure time, work and error of many settings in one run");
  const auto options = std::make_shared<SweepOptions>();
  app->add_option("--config", options->config, "Scenes, series of settings, their axes (JSON; see tools/sweeps)")
      ->type_name("FILE")
      ->required();
  app->add_option("--out", options->out,
                  "Directory for results.json, .csv, .md and plots; a sweep cut short goes on there")
      ->type_name("DIR")
      ->required();
  app->add_option("--compare", options->compare,
                  "results.json of an earlier run: prints the ratios; fails where one is slower")
      ->type_name("FILE");
  add_checked_option(*app, "--slowdown", options->slowdown,
                     "How many times slower a variant must surely be to fail --compare", RealNumber{1, 100});
  app->add_option("--tuning", options->tuning, "Kernels for this kind of device: auto, cpu or gpu (NEPHELE_TUNING)");
  app->add_option("--device", options->device, "Vulkan device: index or part of its name (see nephele devices)")
      ->type_name("NAME_OR_INDEX");
  app->add_flag("--quiet", options->quiet, "No progress bar");
  // In place of the configuration's top-level "settings"; its series and axes still have theirs.
  add_setting_options(*app, options->typed);
  return {app, [options] { return run(*options); }};
}

}  // namespace nephele::tools
