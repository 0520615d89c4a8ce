// Scenes as text: what engine/scene.h reads, written.
#pragma once

#include <string>

#include "engine/result.h"
#include "engine/scene.h"

namespace nephele {

// The scene as a scene file with every key that the scene has a value for, numbers by the fewest digits that give the
// same value again. A scene that came from a file, or was edited by engine/scene_edit.h, reads back equal in every
// member, bit for bit. Of other scenes this may differ: an angle that no number of degrees gives (one of ten that a
// program computes) comes back as the double beside it, a quaternion that is not of unit length as a normalised one,
// particles of a set as its file has them.
//
// Weather maps and sets are named by their files, relative to `directory`, in which the text is to be saved; without a
// directory from the root of the file system. Errors begin with `name` and are one line: a map or a set that no file
// made, a group of another name, a text that is not UTF-8, and whatever the reader would refuse.
Result<std::string> scene_text(const Scene& scene, const std::string& directory = "",
                               const std::string& name = "scene");

// Writes it to the file, complete or not at all; relative names are relative to the file's directory.
Result<void> save_scene(const Scene& scene, const std::string& path);

}  // namespace nephele
