// nephele export: particles as a volume, or as points.
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/atomic_file.h"
#include "engine/check.h"
#include "tools/checked_options.h"
#include "tools/clouds/netcdf_file.h"
#include "tools/clouds/npy_volume.h"
#include "tools/clouds/particle_grid.h"
#include "tools/clouds/png_volume.h"
#include "tools/clouds/vdb_file.h"
#include "tools/command.h"
#include "tools/options.h"
#include "tools/progress.h"

namespace nephele::tools {
namespace {

// As typed.
struct ExportOptions {
  std::string scene, set, out;
  std::optional<double> voxel_m;
  bool quiet = false;
};

// Shows how far a grid is read.
class Watched : public clouds::VolumeReader {
 public:
  Watched(clouds::ParticleGrid grid, bool quiet) : inner_(std::move(grid)), progress_(quiet) {}
  const clouds::VolumeGrid& grid() const override { return inner_.grid(); }
  std::array<int, 3> axes() const override { return inner_.axes(); }
  Result<void> read_planes(std::size_t first, std::size_t count, std::span<float> values) override {
    progress_.show("averaging over voxels", static_cast<double>(first) / static_cast<double>(planes()));
    return inner_.read_planes(first, count, values);
  }

 private:
  clouds::ParticleGrid inner_;
  Progress progress_;
};

Result<void> write_ply(const std::string& path, const std::vector<clouds::PlacedBody>& bodies) {
  std::string text = concat(
      "ply\nformat binary_little_endian 1.0\ncomment particles of nephele: centre, symmetric shape whose eigenvalues "
      "are "
      "the radii (m), peak extinction (1/m), base and top (m)\nelement vertex ",
      bodies.size(), "\n");
  for (const char* name : {"x", "y", "z", "shape_xx", "shape_yy", "shape_zz", "shape_xy", "shape_xz", "shape_yz",
                           "extinction", "base", "top"})
    text.append("property float ").append(name).append("\n");
  text += "end_header\n";
  for (const clouds::PlacedBody& body : bodies) {
    const glm::dmat3& s = body.shape_m;
    const double lowest_m = body.center_m.z - std::sqrt(glm::dot(s[2], s[2]));  // of a particle without a base
    const std::array<double, 12> values{body.center_m.x,
                                        body.center_m.y,
                                        body.center_m.z,
                                        s[0][0],
                                        s[1][1],
                                        s[2][2],
                                        s[0][1],
                                        s[0][2],
                                        s[1][2],
                                        body.extinction_per_m,
                                        body.base_m.value_or(lowest_m),
                                        body.top_m};
    for (const double value : values) {
      const auto single = static_cast<float>(value);
      char bytes[sizeof single];
      std::memcpy(bytes, &single, sizeof single);
      text.append(bytes, sizeof single);
    }
  }
  return write_file_atomically(path, text);
}

Result<std::vector<clouds::PlacedBody>> bodies(const ExportOptions& options) {
  if (options.set.empty() == options.scene.empty())
    return Error{"export takes its particles from --scene FILE or from --set SET; give one of them"};
  if (!options.set.empty()) {
    const Result<ParticleSet> set = load_particle_set(options.set);
    if (!set) return set.error();
    return clouds::bodies_of(*set);
  }
  const Result<Scene> scene = load_scene(options.scene);
  if (!scene) return scene.error();
  Result<std::vector<clouds::PlacedBody>> made = clouds::bodies_of(*scene);
  if (!made) return Error{options.scene + ": " + made.error().message};
  return made;
}

Result<void> run_export(const ExportOptions& options) {
  if (options.out.empty()) return Error{"export has nowhere to write; give --out"};
  namespace fs = std::filesystem;
  const fs::path out(options.out);
  const auto ends_in = [&](const char* extension) { return has_extension(options.out, extension); };
  const bool npy = ends_in(".npy"), vdb = ends_in(".vdb"), netcdf = ends_in(".nc"), ply = ends_in(".ply");
  const bool slices = !npy && !vdb && !netcdf && !ply;
  if (slices && out.has_extension() && !fs::is_directory(out))
    return Error{"--out is \"" + options.out + "\"; accepted: .vdb, .nc, .npy, .ply, or a directory's name"};
  if (slices && fs::exists(out) && (!fs::is_directory(out) || !fs::is_empty(out)))
    return Error{"--out is \"" + options.out + "\", which is not an empty directory; accepted: a new or empty one"};
  const auto beside = [](const std::string& name, const char* extension) {
    return name.empty() ? name : fs::path(name).replace_extension(extension).string();
  };
  const std::string note = npy ? beside(options.out, ".volume.json") : "";
  if (!slices)
    for (const std::string& name : {options.out, note})
      if (auto different = check_different({{"--scene", options.scene},
                                            {"--set", options.set},
                                            {"--set's array", beside(options.set, ".npy")},
                                            {"--out", name}},
                                           1);
          !different)
        return different;
  if (!ply && !options.voxel_m) return Error{"--voxel-m is missing; a volume needs it"};

  Result<std::vector<clouds::PlacedBody>> from = bodies(options);
  if (!from) return from.error();
  if (!slices)
    if (auto writable = check_writable(options.out); !writable) return writable;
  if (ply) return write_ply(options.out, *from);
  clouds::VolumeGrid grid = clouds::grid_around(*from, *options.voxel_m);
  if (auto ok = clouds::check_grid(grid); !ok)
    return Error{concat("--voxel-m is ", *options.voxel_m, ": ", ok.error().message, "; take a greater one")};
  const std::array<int, 3> axes = npy || vdb ? std::array{2, 1, 0} : std::array{0, 1, 2};
  Watched volume(clouds::ParticleGrid(std::move(*from), grid, axes), options.quiet);
  if (vdb) return clouds::write_vdb_volume(options.out, volume);
  if (netcdf) return clouds::write_netcdf_volume(options.out, volume);
  if (slices) return clouds::write_png_volume(options.out, volume);
  if (auto ok = clouds::write_npy_volume(options.out, volume); !ok) return ok;
  // An array says neither where it stands nor how large its voxels are.
  const nlohmann::ordered_json json{
      {"voxel_m", *options.voxel_m},
      {"corner_m", {grid.bounds_m[0].front(), grid.bounds_m[1].front(), grid.bounds_m[2].front()}}};
  return write_file_atomically(note, json.dump(2) + '\n');
}

}  // namespace

Command add_export_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("export", "Particles as a volume of mean extinction, or as points");
  const auto options = std::make_shared<ExportOptions>();
  app->add_option("--scene", options->scene, "A scene of listed particles and sets, without fields of clouds")
      ->type_name("FILE");
  app->add_option("--set", options->set, "A particle set")->type_name("SET.json");
  add_checked_option(*app, "--voxel-m", options->voxel_m, "Side of a voxel in metres", RealNumber{1e-3, 1e5});
  app->add_option(
         "--out", options->out,
         "By its ending: .vdb, .nc, .npy (indexed [x][y][z]; NAME.volume.json says where it stands), .ply (the "
         "particles as points), or a directory for PNG slices and slices.json, which says how large and how thick")
      ->type_name("FILE|DIR");
  app->add_flag("--quiet", options->quiet, "No progress bar");
  return {app, [options] { return run_export(*options); }};
}

}  // namespace nephele::tools
