// nephele fly: the interactive sky in a window.
#include <filesystem>
#include <memory>
#include <optional>

#include "engine/atomic_file.h"
#include "tools/checked_options.h"
#include "tools/command.h"
#include "tools/fly/fly_app.h"
#include "tools/options.h"
#include "tools/scene_tables.h"
#include "tools/scene_view.h"

namespace nephele::tools {
namespace {

constexpr double kMostFrameMs = 1000;

// As typed.
struct FlyOptions {
  std::string scene, view, tables, device, tuning, script, stats, out;
  TypedSettings typed{.settings = {.full_layer = false}, .given = {}};
  double time_s = 0, frame_target_ms = 33;
};

Result<void> run_fly_command(const FlyOptions& options) {
  fly::FlyJob job;
  job.start = {.scene = {},
               .scene_file = options.scene,
               .settings = options.typed.settings,
               .time_s = options.time_s,
               .frame_target_ms = options.frame_target_ms};
  if (!options.scene.empty()) {
    Result<Scene> scene = load_scene(options.scene);
    if (!scene) return scene.error();
    job.start.scene = std::move(*scene);
  }
  if (!options.view.empty())
    if (auto ok = look_from_view(job.start.scene, options.view); !ok) return ok;
  if (!options.script.empty()) {
    Result<fly::FlyScript> script = fly::load_fly_script(options.script);
    if (!script) return script.error();
    job.script = std::move(*script);
  }
  if (!options.stats.empty()) {
    if (!has_extension(options.stats, ".json"))
      return Error{"--stats is \"" + options.stats + "\"; accepted: a name ending in .json"};
    if (auto ok = check_writable(options.stats); !ok) return ok;
  }
  if (!options.out.empty() && !std::filesystem::is_directory(options.out))
    return Error{"--out is \"" + options.out + "\", which is no directory"};
  job.directory = options.out;
  job.stats = options.stats;
  job.device = DeviceOptions::from_environment(options.device, options.tuning);
  job.tables = [directory = options.tables](const Scene& scene, const ProgressCallback& progress) {
    return tables_for_scene(scene, directory, progress);
  };
  return fly::run_fly(std::move(job));
}

}  // namespace

Command add_fly_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("fly", "Fly through a scene in a window");
  const auto options = std::make_shared<FlyOptions>();
  app->add_option("--scene", options->scene, "Scene file (JSON); without it, a default sky")->type_name("FILE");
  app->add_option("--view", options->view,
                  "One of the scene's views, by its name or its number from 1 on, to start from")
      ->type_name("NAME_OR_NUMBER");
  app->add_option("--device", options->device, "Vulkan device: index or part of its name (see nephele devices)")
      ->type_name("NAME_OR_INDEX");
  app->add_option("--tuning", options->tuning, "Kernels for this kind of device: auto, cpu or gpu (NEPHELE_TUNING)");
  app->add_option("--tables", options->tables, "Directory that nephele bake --out filled; without it, the cache")
      ->type_name("DIR");
  add_checked_option(*app, "--time", options->time_s, "Seconds the wind has blown at the start", kTimeS);
  add_checked_option(*app, "--frame-ms", options->frame_target_ms,
                     "Time of a frame that is held by drawing fewer pixels; 0: always all of them",
                     RealNumber{0, kMostFrameMs});
  app->add_option("--script", options->script, "Input from this file (JSON) instead of a person; then it ends")
      ->type_name("FILE");
  app->add_option("--out", options->out, "Directory for pictures, flights and scenes; without it, the present one")
      ->type_name("DIR");
  app->add_option("--stats", options->stats, "Times of all frames at the end: .json")->type_name("FILE");
  add_setting_options(*app, options->typed);
  return {app, [options] { return run_fly_command(*options); }};
}

}  // namespace nephele::tools
