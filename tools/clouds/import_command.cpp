// nephele import: a volume as a particle set.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "engine/atomic_file.h"
#include "engine/check.h"
#include "engine/device.h"
#include "engine/json_reader.h"
#include "tools/checked_options.h"
#include "tools/clouds/device_nodes.h"
#include "tools/clouds/open_volume.h"
#include "tools/clouds/volume_fit.h"
#include "tools/clouds/volume_verify.h"
#include "tools/command.h"
#include "tools/options.h"
#include "tools/progress.h"
#include "tools/volume_arguments.h"

namespace nephele::tools {
namespace {

using Json = nlohmann::ordered_json;

// What --verify, --error hold in memory: four bytes a voxel.
constexpr std::size_t kMostVerifiedVoxels = std::size_t{1} << 29;
constexpr double kVerticalPart = 0.75;  // of --spacing, where --vertical-spacing is not given
// Spacings that --error tries, the coarsest first.
constexpr double kTriedSpacings[] = {16, 12, 10, 8, 7, 6, 5, 4, 3.5, 3, 2.5, 2, 1.75, 1.5, 1.25, 1};

// As typed.
struct ImportOptions {
  std::string volume, out, stats, device = "cpu", time = "0";
  VolumeArguments arguments;
  clouds::VolumeOptions open;  // what the arguments mean
  std::optional<double> spacing, vertical_spacing, error;
  std::optional<std::uint64_t> count;
  double soft_edge = 0.7, drop = 0.004, detail = 0.5;
  bool verify = false, quiet = false;
};

clouds::FitOptions fit_options(const ImportOptions& options, std::optional<double> spacing = {}) {
  clouds::FitOptions fit;
  if (!spacing) spacing = options.spacing;
  if (spacing) {
    fit.spacing_voxels = *spacing;
    fit.vertical_spacing_voxels = kVerticalPart * *spacing;
  }
  if (options.vertical_spacing) fit.vertical_spacing_voxels = *options.vertical_spacing;
  fit.soft_edge = options.soft_edge;
  fit.drop = options.drop;
  fit.detail = static_cast<float>(options.detail);
  return fit;
}

// One step of time, fitted.
struct Imported {
  clouds::VolumeFit fit;
  clouds::FitOptions used;
  std::optional<clouds::VolumeTruth> truth;
  std::vector<std::string> assumptions;
  std::size_t steps = 0;  // of time, in the file; 0: it has none
  double time_s = 0.0;
  double seconds = 0.0;
};

Result<clouds::VolumeFit> fit_to_error(clouds::VolumeReader& reader, const ImportOptions& options,
                                       const clouds::VolumeTruth& truth, clouds::FitOptions& used) {
  double best = INFINITY;
  for (const double spacing : kTriedSpacings) {
    used = fit_options(options, spacing);
    Result<clouds::VolumeFit> fit = clouds::fit_volume(reader, used);
    if (!fit) return fit;
    const double error = truth.errors_of(fit->set).rms_transmittance;
    if (error < *options.error) return fit;
    best = std::min(best, error);
  }
  return Error{
      concat("--error is ", *options.error, "; no spacing of a voxel or more reaches it, the best has ", best)};
}

Result<clouds::VolumeFit> fit_to_count(clouds::VolumeReader& reader, const ImportOptions& options,
                                       clouds::FitOptions& used) {
  // The number falls with the spacing, if not always evenly: halve the range in which it passes the limit.
  double fine = 1.0, coarse = 32.0;
  const auto count_at = [&](double spacing) -> Result<std::size_t> {
    const clouds::FitOptions tried = fit_options(options, spacing);
    const Result<clouds::NodeLattice> lattice = clouds::gather_nodes(reader, tried);
    if (!lattice) return lattice.error();
    const Result<ParticleSet> set = clouds::particles_of_nodes(*lattice, tried);
    if (!set) return set.error();
    return set->particles.size();
  };
  const Result<std::size_t> fewest = count_at(coarse);
  if (!fewest) return fewest.error();
  if (*fewest > *options.count)
    return Error{concat("--count is ", *options.count, "; a spacing of ", coarse, " voxels still makes ", *fewest,
                        " particles")};
  for (int step = 0; step < 9; ++step) {
    const double middle = std::sqrt(fine * coarse);
    const Result<std::size_t> count = count_at(middle);
    if (!count) return count.error();
    (*count <= *options.count ? coarse : fine) = middle;
  }
  used = fit_options(options, coarse);
  return clouds::fit_volume(reader, used);
}

// device: that gathers the nodes; none: the CPU.
Result<Imported> import_step(const ImportOptions& options, std::size_t time, Device* device, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  clouds::VolumeOptions open = options.open;
  open.time = time;
  Result<std::unique_ptr<clouds::VolumeReader>> reader = clouds::open_volume(options.volume, open);
  if (!reader) return reader.error();
  const auto named = [&](const Error& error) {
    return error.message.starts_with("--") || error.message.starts_with(options.volume)
               ? error
               : Error{options.volume + ": " + error.message};
  };
  Imported result;
  const std::vector<double> times_s = (*reader)->times_s();
  result.steps = times_s.size();
  if (time < times_s.size()) result.time_s = times_s[time];
  if (options.verify || options.error) {
    progress.show("loading the volume", 0.0);
    const Result<clouds::MemoryVolume> volume = clouds::load_volume(**reader, kMostVerifiedVoxels);
    if (!volume) return named(volume.error());
    result.truth.emplace(*volume);
  }
  Result<clouds::VolumeFit> fit = Error{};
  if (options.error) {
    fit = fit_to_error(**reader, options, *result.truth, result.used);
  } else if (options.count) {
    fit = fit_to_count(**reader, options, result.used);
  } else if (device) {
    result.used = fit_options(options);
    clouds::FitStats stats;
    Result<clouds::NodeLattice> nodes = clouds::gather_nodes_on(*device, **reader, result.used, &stats);
    if (!nodes) return named(nodes.error());
    fit = clouds::fit_of_nodes(std::move(*nodes), stats, result.used);
  } else {
    result.used = fit_options(options);
    fit = clouds::fit_volume(**reader, result.used,
                             [&](double fraction) { progress.show("fitting particles", fraction); });
  }
  if (!fit) return named(fit.error());
  result.fit = std::move(*fit);
  result.assumptions = (*reader)->assumptions();
  const glm::dvec3 spacing_m = result.fit.lattice.spacing_m;
  const Json parameters{{"file", std::filesystem::path(options.volume).filename().string()},
                        {"spacing_m", {spacing_m.x, spacing_m.y, spacing_m.z}},
                        {"soft_edge", options.soft_edge},
                        {"drop", options.drop}};
  const auto describe = [&](ParticleSet& set) {
    set.source = "import";
    set.parameters = parameters.dump();
  };
  describe(result.fit.set);
  for (ParticleSet& level : result.fit.set.coarser) describe(level);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

Json errors_json(const ParticleSet& set, const clouds::VolumeTruth& truth) {
  const clouds::SetErrors errors = truth.errors_of(set);
  return {{"particles", set.particles.size()},
          {"rays", errors.rays},
          {"rms_transmittance", errors.rms_transmittance},
          {"rms_log_depth", errors.rms_log_depth},
          {"outline_m", errors.outline_m},
          {"mass_ratio", errors.mass_ratio}};
}

Json verified_json(const Imported& imported) {
  Json json = errors_json(imported.fit.set, *imported.truth);
  json["coarser"] = Json::array();
  for (const ParticleSet& level : imported.fit.set.coarser)
    json["coarser"].push_back(errors_json(level, *imported.truth));
  return json;
}

Json stats_json(const Imported& imported) {
  const clouds::FitStats& stats = imported.fit.stats;
  const glm::dvec3 spacing_m = imported.fit.lattice.spacing_m;
  Json coarser = Json::array();
  for (const ParticleSet& level : imported.fit.set.coarser) coarser.push_back(level.particles.size());
  return {{"particles", imported.fit.set.particles.size()},
          {"coarser", coarser},
          {"voxels", stats.voxels},
          {"occupied_voxels", stats.occupied_voxels},
          {"negative_voxels", stats.negative_voxels},
          {"mass_m2", stats.mass_m2},
          {"peak_per_m", stats.peak_per_m},
          {"base_m", imported.fit.set.base_m},
          {"top_m", imported.fit.set.top_m},
          {"spacing_m", {spacing_m.x, spacing_m.y, spacing_m.z}},
          {"spacing_voxels", {imported.used.spacing_voxels, imported.used.vertical_spacing_voxels}},
          {"soft_edge", imported.used.soft_edge},
          {"assumed", imported.assumptions},
          {"seconds", imported.seconds},
          {"fit_bytes", stats.memory_bytes}};
}

Result<void> check(const ImportOptions& options) {
  if (options.out.empty()) return Error{"import has nowhere to write; give --out"};
  if (!has_extension(options.out, ".json"))
    return Error{"--out is \"" + options.out + "\"; accepted: a name ending in .json (the array goes beside it)"};
  if ((options.spacing ? 1 : 0) + (options.error ? 1 : 0) + (options.count ? 1 : 0) > 1)
    return Error{"--spacing, --error, --count: accepted one at a time"};
  const std::string array = std::filesystem::path(options.out).replace_extension(".npy").string();
  if (auto different = check_different(
          {{"VOLUME", options.volume}, {"--out", options.out}, {"--out's array", array}, {"--stats", options.stats}},
          1);
      !different)
    return different;
  for (const std::string& name : {options.out, array, options.stats})
    if (!name.empty())
      if (auto writable = check_writable(name); !writable) return writable;
  return {};
}

// All steps of time as sets of their own, and a list of them.
Result<void> save_sequence(const std::string& out, const std::vector<Imported>& steps) {
  Json sets = Json::array();
  const std::filesystem::path list(out);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    char number[32];
    std::snprintf(number, sizeof number, "_%04zu.json", i);
    const std::string name = list.stem().string() + number;
    if (auto ok = save_particle_set(list.parent_path() / name, steps[i].fit.set); !ok) return ok;
    sets.push_back({{"time_s", steps[i].time_s}, {"file", name}});
  }
  const Json sequence{{"format", "nephele particle sequence"}, {"version", 1}, {"sets", sets}};
  return write_file_atomically(out, sequence.dump(2) + '\n');
}

Result<void> run_import(const ImportOptions& typed) {
  ImportOptions options = typed;
  if (auto ok = check(options); !ok) return ok;
  const Result<clouds::VolumeOptions> open = volume_options(options.arguments);
  if (!open) return open.error();
  options.open = *open;
  const bool all = options.time == "all";
  std::size_t time = 0;
  if (!all) {
    const WholeNumber step{0, 999999};
    const auto value = read_value(step, options.time);
    if (!value || !accepts(step, *value))
      return Error{"--time is " + shown_text(options.time) + "; accepted: " + accepted_words(step) + ", or all"};
    time = static_cast<std::size_t>(std::get<std::uint64_t>(*value));
  }
  std::unique_ptr<Device> device;
  if (options.device != "cpu") {
    if (options.error || options.count)
      return Error{"--device stands beside --error or --count; accepted: one of them"};
    Result<std::unique_ptr<Device>> created = Device::create(DeviceOptions::from_environment(options.device));
    if (!created) return created.error();
    device = std::move(*created);
  }
  Progress progress(options.quiet);
  std::vector<Imported> steps;
  for (std::size_t i = 0, count = 1; i < count; ++i) {
    Result<Imported> imported = import_step(options, all ? i : time, device.get(), progress);
    if (!imported) return imported.error();
    if (all) {
      if (imported->steps == 0) return Error{options.volume + ": --time is all; the volume has no steps of time"};
      count = imported->steps;
      if (count > 10000) return Error{concat(options.volume, ": ", count, " steps of time; accepted: at most 10000")};
      progress.show("importing steps of time", static_cast<double>(i + 1) / static_cast<double>(count));
    }
    steps.push_back(std::move(*imported));
  }
  if (auto ok = all ? save_sequence(options.out, steps) : save_particle_set(options.out, steps.front().fit.set); !ok)
    return ok;
  Json verified = Json::array(), stats = Json::array();
  for (const Imported& step : steps) {
    stats.push_back(stats_json(step));
    if (!options.verify) continue;
    verified.push_back(verified_json(step));
    stats.back()["verify"] = verified.back();
  }
  if (options.verify) std::puts((all ? verified : verified.front()).dump(2).c_str());
  if (options.stats.empty()) return {};
  Json whole = all ? Json{{"sets", stats}} : stats.front();
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  whole["peak_memory_bytes"] = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024u;
  return write_file_atomically(options.stats, whole.dump(2) + '\n');
}

}  // namespace

Command add_import_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("import", "A volume as a particle set, with coarser levels for far away");
  const auto options = std::make_shared<ImportOptions>();
  app->add_option("volume", options->volume,
                  "By its ending: .vdb, .nc, .npy (indexed [x][y][z] = east, north, up; the set's origin is the outer "
                  "corner of the first voxel), or a directory of PNG slices, one a level, from below by name")
      ->type_name("VOLUME")
      ->required();
  app->add_option("--out", options->out, "The set: NAME.json, its array NAME.npy beside it")->type_name("NAME.json");
  add_volume_options(*app, options->arguments);
  app->add_option("--time", options->time, "Of a .nc: the step, counted from 0, or all, which makes a sequence")
      ->type_name("N|all")
      ->capture_default_str();
  app->add_option(
         "--device", options->device,
         "Where the volume's moments are added up: cpu, or a Vulkan device by index or part of its name, which "
         "must hold the volume as a whole")
      ->type_name("cpu|NAME_OR_INDEX")
      ->capture_default_str();
  add_checked_option(*app, "--spacing", options->spacing,
                     "Voxels between particles, horizontally; vertically three quarters of it. Default 4 and 3",
                     RealNumber{1, 64});
  add_checked_option(*app, "--vertical-spacing", options->vertical_spacing, "Voxels between particles, vertically",
                     RealNumber{1, 64});
  add_checked_option(*app, "--error", options->error,
                     "In place of --spacing: the widest whose RMS error of transmittance is below this",
                     RealNumber{1e-4, 1});
  add_checked_option(*app, "--count", options->count,
                     "In place of --spacing: the closest with at most so many particles",
                     WholeNumber{1, kMaxSetParticles});
  add_checked_option(*app, "--soft-edge", options->soft_edge, "Overlap of neighbouring windows: 0 none, 1 all",
                     RealNumber{0, 1});
  add_checked_option(*app, "--drop", options->drop,
                     "Particles with less than this part of the mean one's mass are left out, their mass given to the "
                     "others",
                     RealNumber{0, 0.5});
  add_checked_option(*app, "--detail", options->detail,
                     "How strongly the air's structure thickens and thins the particles", RealNumber{0, 1});
  app->add_flag("--verify", options->verify,
                "Print errors against the volume as JSON, for each level: transmittance along 1500 random rays, depth, "
                "outline, mass");
  app->add_option("--stats", options->stats, "Counts, mass, spacing, what was assumed, seconds, memory: .json")
      ->type_name("FILE");
  app->add_flag("--quiet", options->quiet, "No progress bar");
  app->footer(
      "Memory: at most 16 MiB of voxels (one plane, if larger), about 110 bytes for each node that holds cloud, and "
      "the "
      "process that reads a .vdb or a .nc; --verify and --error hold the volume, 4 bytes a voxel.");
  return {app, [options] { return run_import(*options); }};
}

}  // namespace nephele::tools
