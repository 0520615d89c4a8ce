// A volume that a process of its own reads: whatever a foreign library does with a damaged file (crash, never end, ask
// for all memory), here it is one line of text.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "engine/result.h"
#include "tools/clouds/volume_reader.h"

namespace nephele::clouds {

struct ChildLimits {
  double seconds = 60.0;         // for each answer
  std::size_t memory_bytes = 0;  // of address space; 0: 4 GiB and 8 times the file
};

// `open` runs in the child, and so does everything that the reader does; exceptions become errors. Call it while no
// other thread of this process holds a lock that `open` may want.
Result<std::unique_ptr<VolumeReader>> open_in_child(const std::string& path,
                                                    std::function<Result<std::unique_ptr<VolumeReader>>()> open,
                                                    const ChildLimits& limits = {});

}  // namespace nephele::clouds
