// nephele probe: what shading would read from the tables, for rays given in a file.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "engine/atomic_file.h"
#include "engine/check.h"
#include "engine/frame.h"
#include "engine/phase_function.h"
#include "lut/gpu_tables.h"
#include "nephele_tool_shaders.h"
#include "tools/checked_options.h"
#include "tools/command.h"
#include "tools/probe_rays.h"
#include "tools/progress.h"

namespace nephele::tools {
namespace {

// As probe.comp counts them.
enum class Quantity : std::uint32_t { single, multiple, optical_depth, near_beam };

constexpr const char* kQuantityNames[] = {"single", "multiple", "optical_depth", "near_beam"};

// As typed; what isn't given is the default preset's.
struct ProbeOptions {
  std::string table, rays, out, phase, tables, device;
  std::optional<double> g;
  bool quiet = false;
};

constexpr std::size_t kBatchRays = 1u << 17;

// Beyond it dim rays of the multiple scattering table are off by tens of percent (docs/tables.md, "Hard cases").
constexpr double kMaxMultipleOpticalRadius = 200;
constexpr double kMaxOpticalRadius = 1e4;

Quantity parse_quantity(const std::string& name) {
  for (std::uint32_t i = 0; i < std::size(kQuantityNames); ++i)
    if (name == kQuantityNames[i]) return Quantity{i};
  return Quantity::single;
}

// "": the default.
std::uint32_t parse_phase(const std::string& name) {
  return static_cast<std::uint32_t>(phase_function_named(name).value_or(PhaseFunction{}));
}

TableParameters wanted_parameters(const ProbeOptions& options) {
  TableParameters wanted;
  wanted.phase_function = parse_phase(options.phase);
  wanted.g_single = wanted.g_multiple = options.g.value_or(wanted.g_multiple);
  return wanted;
}

Result<Tables> tables_in(const ProbeOptions& options) {
  Result<Tables> tables = load_tables(options.tables);
  if (!tables) return tables;
  const TableParameters& made = tables->parameters;
  if (options.g && *options.g != made.g_multiple)
    return Error{concat("--g is ", number_text(*options.g), "; accepted: ", number_text(made.g_multiple), ", which ",
                        options.tables, " was baked for")};
  if (!options.phase.empty() && parse_phase(options.phase) != made.phase_function)
    return Error{concat("--phase is \"", options.phase, "\"; ", options.tables, " was baked for the other one")};
  return tables;
}

// With the phase function to evaluate in their parameters. Only multiple scattering and the light near the beam depend
// on it: the others do with the tables of the default preset.
Result<Tables> tables_for(const ProbeOptions& options, Quantity quantity) {
  const TableParameters wanted = wanted_parameters(options);
  if (!options.tables.empty()) return tables_in(options);
  Progress progress(options.quiet);
  Result<Tables> tables = load_or_bake(
      quantity == Quantity::multiple || quantity == Quantity::near_beam ? wanted : TableParameters{},
      default_cache_dir(), [&](const std::string& stage, double fraction) { progress.show(stage, fraction); });
  if (tables) tables->parameters = wanted;
  return tables;
}

std::vector<shared::vec2> evaluate(Device& device, const Tables& tables, Quantity quantity,
                                   const std::vector<ProbeRay>& rays, bool quiet) {
  const GpuTables textures(device, tables);
  const ComputeKernel kernel(device, shaders::probe_comp);
  const std::size_t capacity = std::max<std::size_t>(1, std::min(rays.size(), kBatchRays));
  Buffer in(device, "probe rays", capacity * sizeof(ProbeRay));
  Buffer out(device, "probe values", capacity * sizeof(shared::vec2));
  FrameExecutor executor(device);
  Progress progress(quiet);
  std::vector<shared::vec2> values;
  while (values.size() < rays.size()) {
    const std::size_t count = std::min(rays.size() - values.size(), kBatchRays);
    const auto groups = static_cast<std::uint32_t>((count + 63) / 64);
    in.write(std::as_bytes(std::span(rays).subspan(values.size(), count)));
    const struct {
      std::uint32_t count, quantity, phase_function;
      float g;
    } push{static_cast<std::uint32_t>(count), static_cast<std::uint32_t>(quantity), tables.parameters.phase_function,
           static_cast<float>(tables.parameters.g_multiple)};
    FrameBuilder frame(device);
    frame.compute({.name = "probe",
                   .kernel = &kernel,
                   .bindings = {{0, in, Access::storage_read},
                                {1, out, Access::storage_write},
                                {2, textures.optical_depth(), Access::sampled},
                                {3, textures.multiple_scattering(), Access::sampled},
                                {4, textures.near_beam(), Access::sampled}},
                   .push = as_push(push),
                   .groups = {groups, 1, 1},
                   .indirect = {}});
    executor.run(frame);
    const std::vector<shared::vec2> batch = out.read_vector<shared::vec2>(count);
    values.insert(values.end(), batch.begin(), batch.end());
    progress.show("probing", static_cast<double>(values.size()) / static_cast<double>(rays.size()));
  }
  return values;
}

// The input's lines with one or two more columns. Nine digits give every float back.
std::string table_text(const ProbeRays& rays, const std::vector<shared::vec2>& values, bool two_columns) {
  std::string text = rays.header + (two_columns ? ",value,first_matter\n" : ",value\n");
  char number[32];
  for (std::size_t i = 0; i < values.size(); ++i) {
    text += rays.lines[i];
    for (int k = 0; k < (two_columns ? 2 : 1); ++k) {
      std::snprintf(number, sizeof number, ",%.9g", static_cast<double>(values[i][k]));
      text += number;
    }
    text += '\n';
  }
  return text;
}

Result<void> run_probe(const ProbeOptions& options) {
  const Quantity quantity = parse_quantity(options.table);
  const Result<ProbeRays> rays =
      read_probe_rays(options.rays, quantity == Quantity::multiple ? kMaxMultipleOpticalRadius : kMaxOpticalRadius);
  if (!rays) return rays.error();
  if (auto writable = check_writable(options.out); !writable) return writable;
  const Result<std::unique_ptr<Device>> device = Device::create(DeviceOptions::from_environment(options.device));
  if (!device) return device.error();
  const Result<Tables> tables = tables_for(options, quantity);
  if (!tables) return tables.error();
  if (auto fit = check_tables_fit((*device)->info(), *tables); !fit) return fit;
  const std::vector<shared::vec2> values = evaluate(**device, *tables, quantity, rays->rays, options.quiet);
  return write_file_atomically(options.out, table_text(*rays, values, quantity == Quantity::optical_depth));
}

}  // namespace

Command add_probe_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("probe", "Evaluate the tables for rays given in a CSV, as shading does");
  const auto options = std::make_shared<ProbeOptions>();
  add_checked_option(*app, "--table", options->table, "What to evaluate", OneOfNames(kQuantityNames))->required();
  app->add_option("--rays", options->rays,
                  "Columns entry_x,entry_y,entry_z,dir_x,dir_y,dir_z,light_x,light_y,light_z,optical_radius")
      ->type_name("IN.csv")
      ->required();
  app->add_option("--out", options->out, "The rays with a column value (and first_matter)")
      ->type_name("OUT.csv")
      ->required();
  add_checked_option(*app, "--phase", options->phase,
                     "Phase function: Henyey-Greenstein (hg, the default) or Cornette-Shanks (cs)",
                     OneOfNames(kPhaseFunctionNames));
  add_checked_option(*app, "--g", options->g, "Asymmetry; without it, the default preset's",
                     RealNumber{-kMaxAsymmetry, kMaxAsymmetry});
  app->add_option("--tables", options->tables, "Directory that nephele bake --out filled; without it, the cache")
      ->type_name("DIR");
  app->add_option("--device", options->device, "Vulkan device: index or part of its name (see nephele devices)")
      ->type_name("NAME_OR_INDEX");
  app->add_flag("--quiet", options->quiet, "No progress bar");
  return {app, [options] { return run_probe(*options); }};
}

}  // namespace nephele::tools
