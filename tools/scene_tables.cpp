#include "tools/scene_tables.h"

#include "engine/check.h"
#include "tools/progress.h"

namespace nephele::tools {
TableParameters with_phase(TableParameters parameters, const Scene& scene) {
  parameters.phase_function = static_cast<std::uint32_t>(scene.phase.function);
  parameters.g_single = scene.phase.g;
  parameters.g_multiple = scene.phase.g;
  return parameters;
}

Result<Tables> tables_for_scene(const Scene& scene, const std::string& directory, bool quiet) {
  Progress bar(quiet);
  return tables_for_scene(scene, directory,
                          [&](const std::string& stage, double fraction) { bar.show(stage, fraction); });
}

Result<Tables> tables_for_scene(const Scene& scene, const std::string& directory, const ProgressCallback& progress) {
  const TableParameters wanted = with_phase({}, scene);
  if (directory.empty()) return load_or_bake(wanted, default_cache_dir(), progress);
  Result<Tables> tables = load_tables(directory);
  if (!tables) return tables;
  const TableParameters& made = tables->parameters;
  if (made.phase_function != wanted.phase_function || made.g_multiple != wanted.g_multiple)
    return Error{concat(directory, ": the tables are for phase function ",
                        phase_function_name(PhaseFunction{made.phase_function}), ", g ", made.g_multiple,
                        "; the scene has ", phase_function_name(scene.phase.function), ", g ", wanted.g_multiple)};
  tables->parameters.g_single = wanted.g_single;
  return tables;
}

}  // namespace nephele::tools
