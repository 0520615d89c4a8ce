// A scene seen from one of its views.
#pragma once

#include <string>

#include "engine/result.h"
#include "engine/scene.h"

namespace nephele::tools {

// The scene's camera becomes that of the view, chosen by its name or, where no view has that name, by its number from 1
// on. Another one is an error that lists the views of the scene.
Result<void> look_from_view(Scene& scene, const std::string& name_or_number);

}  // namespace nephele::tools
