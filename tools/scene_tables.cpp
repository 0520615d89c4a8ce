#include "tools/scene_tables.h"

#include "shared/phase.h"
#include "tools/progress.h"

namespace nephele::tools {

TableParameters table_parameters(const Scene& scene) {
  TableParameters parameters;
  parameters.phase_function = scene.phase.function == PhaseFunction::cornette_shanks ? shared::kPhaseCornetteShanks
                                                                                     : shared::kPhaseHenyeyGreenstein;
  parameters.g_single = scene.phase.g;
  parameters.g_multiple = scene.phase.g;
  return parameters;
}

Result<Tables> tables_for_scene(const Scene& scene, bool quiet) {
  Progress progress(quiet);
  return load_or_bake(table_parameters(scene), default_cache_dir(),
                      [&](const std::string& stage, double fraction) { progress.show(stage, fraction); });
}

}  // namespace nephele::tools
