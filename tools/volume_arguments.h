// The options that say how a file of voxels is to be read, alike for every command that reads one.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "engine/result.h"
#include "tools/clouds/open_volume.h"

namespace nephele::tools {

// As typed.
struct VolumeArguments {
  clouds::VolumeOptions open;
  std::string voxel_m;
  double effective_radius_um = 10.0;
};

void add_volume_options(CLI::App& app, VolumeArguments& arguments);

// What they mean, or one line that says what is wrong with them. The step of time is the caller's.
Result<clouds::VolumeOptions> volume_options(const VolumeArguments& arguments);

}  // namespace nephele::tools
