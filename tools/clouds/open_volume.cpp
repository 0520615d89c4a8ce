#include "tools/clouds/open_volume.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "tools/clouds/child_volume.h"
#include "tools/clouds/netcdf_file.h"
#include "tools/clouds/npy_volume.h"
#include "tools/clouds/png_volume.h"
#include "tools/clouds/vdb_file.h"

namespace nephele::clouds {
namespace {

std::string ending(const std::string& path) {
  std::string text = std::filesystem::path(path).extension().string();
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

}  // namespace

Result<std::unique_ptr<VolumeReader>> open_volume(const std::string& path, const VolumeOptions& options) {
  std::error_code failure;
  if (!std::filesystem::exists(path, failure)) return Error{path + ": there is no such file or directory"};
  const std::string kind = ending(path);
  const auto refuse = [&](const char* option, const char* where) {
    return Error{path + ": " + option + " is accepted for " + where + " alone"};
  };
  if (!options.grid.empty() && kind != ".vdb") return refuse("--grid", ".vdb");
  if (!options.variable.empty() && kind != ".nc") return refuse("--variable", ".nc");
  if (options.time > 0 && kind != ".nc") return refuse("--time", ".nc");
  if (kind == ".npy") {
    if (!options.voxel_m) return Error{path + ": --voxel-m is missing; an array does not say how large its voxels are"};
    return open_npy_volume(path, *options.voxel_m, options.scale_per_m.value_or(1.0));
  }
  if (kind == ".vdb") {
    if (options.voxel_m) return Error{path + ": --voxel-m is accepted for files that do not say it; a .vdb does"};
    return open_in_child(path, [path, grid = options.grid, scale = options.scale_per_m.value_or(1.0)] {
      return open_vdb_volume(path, grid, scale);
    });
  }
  if (kind == ".nc") {
    const NetcdfOptions netcdf{.variable = options.variable,
                               .time = options.time,
                               .scale_per_m = options.scale_per_m,
                               .effective_radius_m = options.effective_radius_m,
                               .voxel_m = options.voxel_m};
    return open_in_child(path, [path, netcdf] { return open_netcdf_volume(path, netcdf); });
  }
  if (kind == ".png" || std::filesystem::is_directory(path, failure))
    return open_png_volume(path, {.voxel_m = options.voxel_m, .scale_per_m = options.scale_per_m});
  return Error{path +
               ": not a volume; accepted: .npy, .vdb, .nc a directory of PNG slices or a strip of them in one .png"};
}

}  // namespace nephele::clouds
