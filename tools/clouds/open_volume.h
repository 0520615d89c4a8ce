// The one door to volumes: a reader by the ending of the name.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>

#include "engine/result.h"
#include "tools/clouds/volume_reader.h"

namespace nephele::clouds {

struct VolumeOptions {
  std::optional<glm::dvec3> voxel_m;    // of a file that does not say it
  std::optional<double> scale_per_m;    // extinction of one unit of the values (1/m)
  std::string grid;                     // of .vdb
  std::string variable;                 // of .nc
  std::size_t time = 0;                 // of .nc: which step
  double effective_radius_m = 10.0e-6;  // of droplets, where values are water
};

// .npy, .vdb, .nc or a directory of PNG slices. Whatever is wrong with it is one line that names the file. Files that a
// foreign library reads are read in a process of their own (child_volume.h).
Result<std::unique_ptr<VolumeReader>> open_volume(const std::string& path, const VolumeOptions& options);

}  // namespace nephele::clouds
