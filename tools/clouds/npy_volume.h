// Volumes in NumPy arrays: float32, float16 or uint8, indexed [x][y][z] in C order, read piece by piece.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <string>

#include "engine/result.h"
#include "tools/clouds/volume_reader.h"

namespace nephele::clouds {

// The frame's origin is the outer corner of the first voxel. Values times scale are the extinction (1/m).
Result<std::unique_ptr<VolumeReader>> open_npy_volume(const std::string& path, const glm::dvec3& voxel_m, double scale);

// float32, indexed [x][y][z]; planes across x. Written under a temporary name and renamed.
Result<void> write_npy_volume(const std::string& path, VolumeReader& volume);

}  // namespace nephele::clouds
