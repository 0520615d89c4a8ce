#include "tools/scene_view.h"

#include <cstddef>

#include "engine/accepted.h"
#include "engine/check.h"

namespace nephele::tools {

Result<void> look_from_view(Scene& scene, const std::string& name_or_number) {
  for (const SceneView& view : scene.views)
    if (view.name == name_or_number) return scene.camera = view.camera, Result<void>();
  std::string accepted;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const SceneView& view = scene.views[i];
    if (name_or_number == std::to_string(i + 1)) return scene.camera = view.camera, Result<void>();
    accepted += concat(i > 0 ? ", " : "", i + 1, " = ", shown_text(view.name));
  }
  return Error{concat("--view is ", shown_text(name_or_number),
                      "; accepted: ", accepted.empty() ? "none, since the scene has no views" : accepted)};
}

}  // namespace nephele::tools
