// Volumes in NetCDF files, as models of the weather write them.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>

#include "engine/result.h"
#include "tools/clouds/volume_reader.h"

namespace nephele::clouds {

struct NetcdfOptions {
  std::string variable;               // empty: the first of the usual names of cloud water
  std::size_t time = 0;               // step
  std::optional<double> scale_per_m;  // extinction of one unit; none: by the variable's units
  double effective_radius_m = 10.0e-6;
  std::optional<glm::dvec3> voxel_m;  // along axes that have no coordinates
};

// Axes are told by attributes, units and names, in any order. Coordinates are the middles of voxels, in m or km; levels
// need not be even. Places are the file's; where they are beyond 100 km, they are measured from the volume's corner,
// which becomes the grid's anchor. Water becomes extinction as 1.5 rho q / (rho_w r), with the air's density from the
// file or, without one, of the standard atmosphere.
Result<std::unique_ptr<VolumeReader>> open_netcdf_volume(const std::string& path, const NetcdfOptions& options);

// One variable, "extinction" (z, y, x) in m-1, and its coordinates; planes across z. Written under a temporary name and
// renamed.
Result<void> write_netcdf_volume(const std::string& path, VolumeReader& volume);

}  // namespace nephele::clouds
