#include "tools/volume_arguments.h"

#include <cstddef>
#include <glm/glm.hpp>
#include <variant>
#include <vector>

#include "engine/accepted.h"
#include "tools/checked_options.h"

namespace nephele::tools {
namespace {

constexpr RealNumber kVoxelM{1e-3, 1e5};

// "25" or "50,50,20".
Result<glm::dvec3> parse_voxel(const std::string& text) {
  const std::vector<std::string> parts = CLI::detail::split(text, ',');
  glm::dvec3 voxel_m(0.0);
  bool good = parts.size() == 1 || parts.size() == 3;
  for (int axis = 0; good && axis < 3; ++axis) {
    const auto value = read_value(kVoxelM, parts[parts.size() == 1 ? 0 : static_cast<std::size_t>(axis)]);
    good = value && accepts(kVoxelM, *value);
    if (good) voxel_m[axis] = std::get<double>(*value);
  }
  if (!good)
    return Error{"--voxel-m is " + shown_text(text) + "; accepted: " + accepted_words(kVoxelM) +
                 ", or three of them as X,Y,Z"};
  return voxel_m;
}

}  // namespace

void add_volume_options(CLI::App& app, VolumeArguments& arguments) {
  app.add_option("--grid", arguments.open.grid,
                 "Of a .vdb: the grid; default the first whose name contains density or extinction, or the only one")
      ->type_name("NAME");
  app.add_option("--variable", arguments.open.variable,
                 "Of a .nc: the variable; default the first of the usual names of cloud water")
      ->type_name("NAME");
  app.add_option("--voxel-m", arguments.voxel_m,
                 "Size of a voxel in metres, for .npy and PNG slices: one number, or X,Y,Z")
      ->type_name("X");
  add_checked_option(app, "--extinction-per-m-per-unit", arguments.open.scale_per_m,
                     "Extinction (1/m) of one unit of the values; default 1, for water from --effective-radius-um",
                     RealNumber{1e-9, 1e9});
  add_checked_option(app, "--effective-radius-um", arguments.effective_radius_um,
                     "Of droplets, where the values are water (.nc)", RealNumber{1, 100});
}

Result<clouds::VolumeOptions> volume_options(const VolumeArguments& arguments) {
  clouds::VolumeOptions open = arguments.open;
  if (!arguments.voxel_m.empty()) {
    const Result<glm::dvec3> voxel_m = parse_voxel(arguments.voxel_m);
    if (!voxel_m) return voxel_m.error();
    open.voxel_m = *voxel_m;
  }
  open.effective_radius_m = arguments.effective_radius_um * 1e-6;
  return open;
}

}  // namespace nephele::tools
