// Volumes in grey pictures: a directory of slices, or one strip of square slices as FlightGear keeps its voxel clouds.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>

#include "engine/result.h"
#include "tools/clouds/volume_reader.h"

namespace nephele::clouds {

struct PngOptions {
  std::optional<glm::dvec3> voxel_m;
  std::optional<double> scale_per_m;  // extinction where a slice is white
};

// A directory: one level a picture (*.png), from below in the order of the last number in the name; of colours blue is
// taken; rows from north to south. slices.json in it, as nephele export writes one, gives size, scale and corner where
// the options do not.
//
// A file: its height is the side of a slice, slices stand from left to right, from below. Of a picture with colours
// blue is the density. https://wiki.flightgear.org/3D_clouds says that of FlightGear's, and nothing of which end is
// below.
Result<std::unique_ptr<VolumeReader>> open_png_volume(const std::string& path, const PngOptions& options);

// slice_0000.png, ..., of 8 bits, and slices.json. The directory is made.
Result<void> write_png_volume(const std::string& directory, VolumeReader& volume);

}  // namespace nephele::clouds
