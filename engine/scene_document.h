// The scene file as a JSON document: what the reader, the writer and the editor of scenes share. Not for programs:
// those have engine/scene.h, engine/scene_writer.h and engine/scene_edit.h, which need no JSON library.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/json_reader.h"
#include "engine/result.h"
#include "engine/scene.h"

namespace nephele {

// A file that a scene names, to be read once the rest of the scene is found good.
struct SceneFile {
  std::string key, name;  // as the scene has them
  std::function<Result<void>(const std::string& path)> load;
};
using SceneFiles = std::vector<SceneFile>;

// Reads a scene's keys over what `scene` holds: a value whose key is absent stays. `files` get functions that change
// `scene`, which must not be moved before they have run.
void read_scene(JsonObject& json, Scene& scene, SceneFiles& files);

// "reference", "homogeneous" or "soft", in scenes and in particle sets; the key is "shape".
const char* particle_shape_name(ParticleShape shape);
void read_particle_shape(JsonObject& json, ParticleShape& shape);

// All of the scene that is neither a list nor in a file, as the scene file has it. map_file stands for the name of the
// weather map of `clouds`.
nlohmann::ordered_json settings_document(const Scene& scene, const std::string& map_file);

// The angle in degrees, as few digits as give the same angle times kRadiansPerDegree. Of ten angles that are multiples
// of nothing, one has no such number, because doubles of degrees then lie wider apart than those of radians: for it the
// nearest.
double degrees_of(double angle_rad);

// The float as a double of few digits that rounds to it: 0.1f is 0.1, not 0.10000000149011612.
double few_digits(float value);

}  // namespace nephele
