// What `nephele sweep` reads: scenes, and series of settings that each vary along axes. Their product is the list of
// variants to be measured.
//
//   {"scenes": [{"name": "fair", "file": "../scenes/fair_weather.json", "reference": "fair.exr"}],
//    "settings": {"resolution": "320x180"},
//    "series": [{"name": "exact", "settings": {"blend": "exact"}, "axes": {"quality": ["low", "high"], "scale": [1,
//    2]}}], "reference": {"quality": "high"}, "warmup_frames": 1, "frames": 3, "repetitions": 7}
//
// Settings: every key of the table in passes/settings.cpp, "table_preset", and "scene.PATH" for any member of the scene
// file, as in "scene.clouds.view_distance_m". A variant has the sweep's settings, then its series', then its place on
// the axes. Files are found from the configuration's directory.
//
// Errors are measured against the scene's reference, an EXR file of the variants' resolution, or else against the image
// of the top-level reference settings for the variant's own scene and resolution.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/image_io.h"
#include "engine/result.h"
#include "engine/scene.h"
#include "passes/nephele.h"

namespace nephele::tools {

// Before a configuration changes them: nothing reads the full layer, and every measured frame does all its work.
inline constexpr RenderSettings kSweepSettings{.full_layer = false, .reuse = false};

// One picture to be rendered.
struct SweepPicture {
  Scene scene;
  RenderSettings render = kSweepSettings;
  std::string table_preset = "default";
  nlohmann::json description;  // every setting and the whole scene document: equal pictures have equal ones
  std::string key;             // its hash
};

struct SweepVariant {
  std::string scene, series;
  std::string place;    // on the axes: "quality=low scale=2"
  nlohmann::json axes;  // the same as an object
  SweepPicture picture;
  std::shared_ptr<const ImageF> reference_image;  // from a file
  std::optional<SweepPicture> reference_picture;  // to be rendered; neither: no errors are measured

  std::string name() const { return scene + ' ' + series + (place.empty() ? "" : ' ' + place); }
};

struct Sweep {
  std::vector<SweepVariant> variants;  // at least one, all different; those of a scene are neighbours
  std::uint32_t warmup_frames = 1, frames = 3, repetitions = 7;
  std::string hash;  // of everything that decides what is measured
};

// `typed` are settings that take the place of the file's common ones. The first fault is an error that names the file,
// the key and what is accepted.
Result<Sweep> load_sweep(const std::string& path, const nlohmann::json& typed = nlohmann::json::object());

// Every setting and the scene document, as results tell them.
nlohmann::json describe(const SweepPicture& picture, const nlohmann::json& scene_document);

}  // namespace nephele::tools
