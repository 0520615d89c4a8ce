// The baked tables that a scene needs.
#pragma once

#include <string>

#include "engine/result.h"
#include "engine/scene.h"
#include "lut/tables.h"

namespace nephele::tools {

// Every order of scattering has the scene's phase function: that is what the path-traced truth has, too.
TableParameters with_phase(TableParameters parameters, const Scene& scene);

// From the directory, where everything must be in order and made for the scene's phase function; without one from the
// cache, or baked into it with a progress bar.
Result<Tables> tables_for_scene(const Scene& scene, const std::string& directory, bool quiet);
// The same with progress shown by the caller.
Result<Tables> tables_for_scene(const Scene& scene, const std::string& directory, const ProgressCallback& progress);

}  // namespace nephele::tools
