// The nodes of a volume's lattice, gathered on a Vulkan device: gather_nodes of volume_fit.h in floats. What follows,
// particles and coarser levels, is the same code for both, so the sets differ by rounding alone.
#pragma once

#include <cstddef>

#include "engine/device.h"
#include "engine/result.h"
#include "tools/clouds/volume_fit.h"

namespace nephele::clouds {

// The volume lies on the device as a whole: an error if it is larger than the device's buffers, or if a window holds
// more voxels than a thread may visit on a CPU driver (kMaxWindowVoxels).
Result<NodeLattice> gather_nodes_on(Device& device, VolumeReader& reader, const FitOptions& options,
                                    FitStats* stats = nullptr);

inline constexpr std::size_t kMaxWindowVoxels = 20000;

}  // namespace nephele::clouds
