// nephele bake: the tables, to the cache or to a directory.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>

#include "engine/atomic_file.h"
#include "engine/phase_function.h"
#include "lut/study/paper_tables.h"
#include "lut/study/verification.h"
#include "lut/tables.h"
#include "tools/checked_options.h"
#include "tools/command.h"
#include "tools/options.h"
#include "tools/progress.h"

namespace nephele::tools {
namespace {

// As typed; what isn't given is the preset's.
struct BakeOptions {
  std::string out, stats, preset = "default", phase, optical_depth_size, scattering_size;
  std::optional<double> g_single, g_multiple, residual;
  bool verify = false, quiet = false;
};

Result<TableParameters> table_parameters(const BakeOptions& options) {
  Result<TableParameters> preset = TableParameters::preset(options.preset);
  if (!preset) return preset;
  TableParameters parameters = *preset;
  if (!options.phase.empty())
    parameters.phase_function = static_cast<std::uint32_t>(*phase_function_named(options.phase));
  parameters.g_single = options.g_single.value_or(parameters.g_single);
  parameters.g_multiple = options.g_multiple.value_or(parameters.g_multiple);
  parameters.residual = options.residual.value_or(parameters.residual);
  if (!options.optical_depth_size.empty()) {
    const auto axes = parse_axes("--size-optical-depth", options.optical_depth_size, 1);
    if (!axes) return axes.error();
    parameters.optical_depth_size = (*axes)[0];
  }
  if (!options.scattering_size.empty()) {
    const auto axes = parse_axes("--size-scattering", options.scattering_size, 3);
    if (!axes) return axes.error();
    parameters.scattering_cosines = (*axes)[0];
    parameters.scattering_chords = (*axes)[1];
    parameters.scattering_densities = (*axes)[2];
  }
  if (const auto valid = parameters.validate(); !valid) return valid.error();
  return parameters;
}

nlohmann::ordered_json describe(const Table& table) {
  return {{"name", table.name},
          {"shape", table.array.shape},
          {"bytes", table.array.data.size()},
          {"metadata", nlohmann::ordered_json::parse(table.metadata)}};
}

// Whether the tables could be written there, found out before they are baked.
Result<void> prepare_directory(const std::string& directory) {
  if (directory.empty()) return {};
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  if (failure) return Error{directory + ": can't be created: " + failure.message()};
  return check_writable(std::filesystem::path(directory) / "optical_depth.json");
}

// The paper's tables are there to be compared: their factors are the published ones.
Result<PaperParameters> paper_parameters(const BakeOptions& options) {
  if (options.out.empty()) return Error{"--out is missing; --preset paper needs a directory for its tables"};
  if (options.g_single || options.g_multiple || options.residual)
    return Error{"--g-single, --g-multiple, --residual: accepted with --preset default or fast; paper has its own"};
  PaperParameters parameters;
  if (!options.phase.empty())
    parameters.phase_function = static_cast<std::uint32_t>(*phase_function_named(options.phase));
  for (const auto& [name, text, size] :
       {std::tuple{"--size-optical-depth", &options.optical_depth_size, &parameters.optical_depth_size},
        std::tuple{"--size-scattering", &options.scattering_size, &parameters.scattering_size}}) {
    if (text->empty()) continue;
    const auto axes = parse_axes(name, *text, 4);
    if (!axes) return axes.error();
    std::copy_n(axes->begin(), 4, size->begin());
  }
  if (const auto valid = parameters.validate(); !valid) return valid.error();
  return parameters;
}

Result<void> prepare_outputs(const BakeOptions& options) {
  if (!options.stats.empty())
    if (auto writable = check_writable(options.stats); !writable) return writable;
  return prepare_directory(options.out);
}

Result<void> run_paper_bake(const BakeOptions& options) {
  const Result<PaperParameters> parameters = paper_parameters(options);
  if (!parameters) return parameters.error();
  if (auto ready = prepare_outputs(options); !ready) return ready;

  const auto start = std::chrono::steady_clock::now();
  Progress progress(options.quiet);
  const auto show = [&](const std::string& stage, double fraction) { progress.show(stage, fraction); };
  PaperTables tables = bake_paper_tables(*parameters, show);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (options.verify) verify_tables(tables, show);
  if (auto saved = save_paper_tables(options.out, tables); !saved) return saved;
  if (options.stats.empty()) return {};
  const nlohmann::ordered_json stats{
      {"seconds", seconds.count()},
      {"tables",
       {describe(tables.optical_depth), describe(tables.single_scattering), describe(tables.multiple_scattering)}}};
  return write_file_atomically(options.stats, stats.dump(2) + '\n');
}

Result<void> run_bake(const BakeOptions& options) {
  if (options.preset == "paper") return run_paper_bake(options);
  const Result<TableParameters> parameters = table_parameters(options);
  if (!parameters) return parameters.error();
  if (auto ready = prepare_outputs(options); !ready) return ready;

  const auto start = std::chrono::steady_clock::now();
  Progress progress(options.quiet);
  const auto show = [&](const std::string& stage, double fraction) { progress.show(stage, fraction); };
  Result<Tables> tables = options.out.empty() ? load_or_bake(*parameters, default_cache_dir(), show)
                                              : bake_to(options.out, *parameters, show);
  if (!tables) return tables.error();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (options.verify) {
    verify_tables(*tables, show);
    for (const Table* table : {&tables->optical_depth, &tables->multiple_scattering, &tables->near_beam})
      if (auto saved = save_metadata(*table); !saved) return saved;
  }
  if (options.stats.empty()) return {};

  const nlohmann::ordered_json stats{
      {"seconds", seconds.count()},
      {"tables", {describe(tables->optical_depth), describe(tables->multiple_scattering), describe(tables->near_beam)}},
  };
  return write_file_atomically(options.stats, stats.dump(2) + '\n');
}

}  // namespace

Command add_bake_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("bake", "Bake the scattering and optical-depth tables");
  const auto options = std::make_shared<BakeOptions>();
  app->add_option("--out", options->out, "Directory for the tables; without it, the cache")->type_name("DIR");
  add_checked_option(*app, "--preset", options->preset,
                     "Sizes and accuracy to start from: default or fast; or paper, its 4D tables, to compare",
                     OneOfNames{"default", "fast", "paper"});
  add_checked_option(*app, "--phase", options->phase, "Phase function: Henyey-Greenstein (hg) or Cornette-Shanks (cs)",
                     OneOfNames(kPhaseFunctionNames));
  const RealNumber asymmetry{-kMaxAsymmetry, kMaxAsymmetry};
  add_checked_option(*app, "--g-single", options->g_single, "Asymmetry of single scattering", asymmetry);
  add_checked_option(*app, "--g-multiple", options->g_multiple, "Asymmetry of the orders from the second on",
                     asymmetry);
  add_checked_option(*app, "--residual", options->residual, "Relative residual at which a solution counts as converged",
                     RealNumber{kMinResidual, kMaxResidual});
  app->add_option("--size-optical-depth", options->optical_depth_size,
                  "Vertices along a side of each octahedral map; paper: along each axis")
      ->type_name("N");
  app->add_option("--size-scattering", options->scattering_size, "Texels along each axis")
      ->type_name("COSINESxCHORDSxDENSITIES");
  app->add_flag("--verify", options->verify,
                "Measure the tables against independent truth; errors go to their JSON files");
  app->add_option("--stats", options->stats, "Seconds, sizes and every parameter: .json")->type_name("FILE");
  app->add_flag("--quiet", options->quiet, "No progress bar");
  return {app, [options] { return run_bake(*options); }};
}

}  // namespace nephele::tools
