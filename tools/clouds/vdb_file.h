// Volumes in OpenVDB files. All of OpenVDB's headers are in this one source file, because they are slow to compile.
#pragma once

#include <memory>
#include <string>

#include "engine/result.h"
#include "tools/clouds/volume_reader.h"

namespace nephele::clouds {

// The grid by name; without one the first scalar grid whose name contains density or extinction, or the only one.
// Index coordinates are the middles of voxels, as OpenVDB has it; the transform may scale and move, not turn. The box
// of active voxels is the volume. Values times scale are the extinction (1/m).
Result<std::unique_ptr<VolumeReader>> open_vdb_volume(const std::string& path, const std::string& grid, double scale);

// One float grid, "density", a fog volume; even bounds alone, planes across x. Voxels of 0 take no room. Written
// under a temporary name and renamed.
Result<void> write_vdb_volume(const std::string& path, VolumeReader& volume);

}  // namespace nephele::clouds
