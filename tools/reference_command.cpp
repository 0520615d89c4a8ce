// nephele reference: the path-traced truth of a scene, on the CPU, over the very particles that the renderer draws.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <variant>

#include "engine/atomic_file.h"
#include "engine/check.h"
#include "engine/device.h"
#include "engine/image_io.h"
#include "passes/kit/cloud_source.h"
#include "passes/nephele.h"
#include "shared/tonemap.h"
#include "shared/world.h"
#include "tools/checked_options.h"
#include "tools/clouds/open_volume.h"
#include "tools/clouds/volume_reader.h"
#include "tools/command.h"
#include "tools/options.h"
#include "tools/path_tracer/extinction_field.h"
#include "tools/path_tracer/reference_image.h"
#include "tools/path_tracer/voxel_field.h"
#include "tools/progress.h"
#include "tools/scene_tables.h"
#include "tools/scene_view.h"
#include "tools/volume_arguments.h"

namespace nephele::tools {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kDefaultSamples = 64, kMaxSamples = 1u << 24;
constexpr std::uint32_t kPassSamples = 16;
constexpr auto kSaveEvery = std::chrono::seconds(30);
constexpr std::uint32_t kMaxThreads = 256;
constexpr double kMaxSkyRadiance = 1e6;
constexpr std::size_t kMostVoxels = std::size_t{1} << 29;  // four bytes each

// As typed.
struct ReferenceOptions {
  std::string scene, view, out, layers, picture, tables, device, volume;
  VolumeArguments volume_arguments;
  TypedSettings typed{.settings = {.width = 320, .height = 180}, .given = {}};
  std::optional<std::uint32_t> spp;
  std::optional<double> noise, sky_radiance;
  std::uint64_t seed = 1;
  std::uint32_t threads = 0;
  double time_s = 0;
  bool resume = false, quiet = false;
};

// The particles of the scene, all that the renderer makes for this camera: from a frame too small to cost anything.
Result<std::vector<shared::Particle>> rendered_particles(const Scene& scene, const Tables& tables,
                                                         const ReferenceOptions& options) {
  const Result<std::unique_ptr<Device>> device = Device::create(DeviceOptions::from_environment(options.device));
  if (!device) return device.error();
  const Result<std::unique_ptr<Sky>> sky = Sky::create(**device, tables);
  if (!sky) return sky.error();
  RenderSettings settings = options.typed.settings;
  settings.width = settings.height = 8;
  const Result<std::unique_ptr<Renderer>> renderer = Renderer::create(**sky, scene, settings);
  if (!renderer) return renderer.error();
  (*renderer)->render(scene.camera, options.time_s);
  for (const auto& [buffer, lost] : (*renderer)->stats().overflow)
    if (buffer == "particles" && lost > 0)
      return Error{concat("the scene has ", lost, " particles more than its buffer holds; take a lower --quality")};
  return (*renderer)->read_particles();
}

// Of everything that decides what a sample is worth.
class Key {
 public:
  template <class T>
  void add(const T& value) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(&value);
    for (std::size_t i = 0; i < sizeof value; ++i) hash_ = (hash_ ^ bytes[i]) * 0x100000001b3u;  // FNV-1a
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

std::uint64_t state_key(const Scene& scene, const std::vector<shared::Particle>& particles, const std::string& volume,
                        const std::optional<double>& sky_radiance) {
  Key key;
  for (const char letter : volume) key.add(letter);
  for (const shared::Particle& particle : particles) key.add(particle);
  for (const double value :
       {scene.camera.position_m.x, scene.camera.position_m.y, scene.camera.position_m.z, scene.camera.yaw_rad,
        scene.camera.pitch_rad, scene.camera.roll_rad, scene.camera.vertical_fov_rad, scene.sun.azimuth_rad,
        scene.sun.elevation_rad, scene.phase.g, scene.world_origin_m.x, scene.world_origin_m.y,
        sky_radiance.value_or(-1.0)})
    key.add(value);
  key.add(scene.sun.irradiance);
  key.add(scene.ground.albedo);
  key.add(scene.ground.enabled);
  key.add(scene.atmosphere.enabled);
  key.add(scene.phase.function);
  if (scene.terrain) {
    const Terrain& terrain = *scene.terrain;
    for (const std::uint16_t texel : terrain.texels) key.add(texel);
    for (const double value : {terrain.origin_m.x, terrain.origin_m.y, terrain.extent_m.x, terrain.extent_m.y,
                               double{terrain.lowest_m}, double{terrain.highest_m}, static_cast<double>(terrain.width)})
      key.add(value);
  }
  return key.value();
}

// The voxels of --volume, where the scene's set stands.
struct PlacedVoxels {
  truth::Voxels voxels;
  Placement at;
  glm::dvec3 camera_m{0.0};  // in the air that they stand still in

  float highest_m() const { return static_cast<float>(at.at_m.z + at.scale * voxels.bounds_m[2].back()); }
};

Result<PlacedVoxels> placed_voxels(const Scene& scene, const ReferenceOptions& options) {
  const PlacedSet* placed = nullptr;
  std::size_t others = scene.particles.size() + (scene.clouds ? 1 : 0);
  for (const SceneSource& source : scene.sources)
    if (const auto* set = std::get_if<PlacedSet>(&source); set && !placed && set->instances.empty())
      placed = set;
    else
      ++others;
  if (!placed || others > 0)
    return Error{
        "--volume takes the place of the scene's set; accepted: a scene with one source of kind set, without "
        "instances, and no other clouds"};
  const Result<clouds::VolumeOptions> open = volume_options(options.volume_arguments);
  if (!open) return open.error();
  const Result<std::unique_ptr<clouds::VolumeReader>> reader = clouds::open_volume(options.volume, *open);
  if (!reader) return reader.error();
  const Result<clouds::MemoryVolume> volume = clouds::load_volume(**reader, kMostVoxels);
  if (!volume) return Error{options.volume + ": " + volume.error().message};
  const Placement& at = placed->placement;
  const glm::dvec2 wind_m_per_s = at.drifts ? at.wind_m_per_s.value_or(scene_wind_m_per_s(scene)) : glm::dvec2(0.0);
  const glm::dvec3 camera_m = scene.camera.position_m - glm::dvec3(wind_m_per_s * options.time_s, 0.0);
  return PlacedVoxels{{volume->grid().bounds_m, volume->values()}, at, camera_m};
}

// No lower than least_m.
float highest_m(const std::vector<shared::Particle>& particles, float camera_altitude_m, float least_m) {
  float highest = least_m;
  for (const shared::Particle& p : particles)
    highest = std::max(
        highest, shared::altitude_m(p.center_m, camera_altitude_m) + shared::ellipsoid_extent(p.shape, {0, 0, 1}));
  return highest;
}

Result<void> check(const ReferenceOptions& options) {
  if (options.out.empty()) return Error{"reference has nowhere to write; give --out"};
  struct Output {
    const char *option, *extension;
    const std::string& name;
  };
  for (const auto& [option, extension, name] :
       {Output{"--out", ".exr", options.out}, Output{"--layers", ".exr", options.layers},
        Output{"--picture", ".png", options.picture}}) {
    if (name.empty()) continue;
    if (!has_extension(name, extension))
      return Error{concat(option, " is \"", name, "\"; accepted: a name ending in ", extension)};
    if (auto writable = check_writable(name); !writable) return writable;
  }
  return check_different({{"--scene", options.scene},
                          {"--out", options.out},
                          {"--layers", options.layers},
                          {"--picture", options.picture}},
                         1);
}

// Passes until the samples or the noise asked for; state_path is empty where no state is kept.
Result<void> trace(const ReferenceOptions& options, const truth::PathTracer& tracer, truth::ReferenceImage& image,
                   const std::string& state_path, std::uint64_t key) {
  const std::uint32_t most = options.spp.value_or(options.noise ? kMaxSamples : kDefaultSamples);
  const int threads =
      static_cast<int>(options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency()));
  Progress progress(options.quiet);
  auto saved = Clock::now();
  while (image.samples() < most) {
    const double error = image.samples() > 0 ? image.mean_relative_error() : INFINITY;
    if (options.noise && error <= *options.noise) break;
    const std::uint32_t samples = std::min(kPassSamples, most - image.samples());
    image.add_samples(tracer, samples, threads, [&](double fraction) {
      const double traced = image.samples() + fraction * samples;
      // Noise falls with the root of the samples.
      const double done = options.noise ? std::pow(*options.noise / error, 2) : 0.0;
      progress.show(concat("path tracing, ", image.samples(), " samples a pixel"), std::max(done, traced / most));
    });
    if (state_path.empty() || Clock::now() - saved < kSaveEvery) continue;
    if (auto ok = image.save(state_path, key); !ok) return ok;
    saved = Clock::now();
  }
  return state_path.empty() ? Result<void>() : image.save(state_path, key);
}

// As `render` shows it, the sun's glare aside.
Result<void> write_picture(const std::string& path, const ImageF& image, float exposure_ev) {
  std::vector<std::uint8_t> rgba;
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const glm::vec3 radiance(image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2));
      const glm::vec3 shown = shared::display_color(radiance, std::exp2(exposure_ev), glm::uvec2(x, y));
      for (int c = 0; c < 3; ++c) rgba.push_back(static_cast<std::uint8_t>(std::lround(255 * shown[c])));
      rgba.push_back(255);
    }
  return write_png(path, image.width, image.height, rgba);
}

Result<void> run_reference(const ReferenceOptions& options) {
  if (auto ok = check(options); !ok) return ok;
  Result<Scene> scene = options.scene.empty() ? Result<Scene>(Scene{}) : load_scene(options.scene);
  if (!scene) return scene.error();
  if (!options.view.empty())
    if (auto ok = look_from_view(*scene, options.view); !ok) return ok;
  Result<std::vector<shared::Particle>> particles = std::vector<shared::Particle>{};
  std::optional<PlacedVoxels> voxels;
  std::uint32_t particle_seed = TableParameters{}.particle_seed;
  if (!options.volume.empty()) {
    Result<PlacedVoxels> read = placed_voxels(*scene, options);
    if (!read) return read.error();
    voxels = std::move(*read);
  } else {
    const Result<Tables> tables = tables_for_scene(*scene, options.tables, options.quiet);
    if (!tables) return tables.error();
    particles = rendered_particles(*scene, *tables, options);
    if (!particles) return particles.error();
    particle_seed = tables->parameters.particle_seed;
  }

  const auto altitude_m = static_cast<float>(scene->camera.position_m.z);
  std::optional<glm::vec3> uniform_sky;
  if (options.sky_radiance) uniform_sky = glm::vec3(static_cast<float>(*options.sky_radiance));
  const truth::Surroundings surroundings(
      *scene, uniform_sky,
      highest_m(*particles, altitude_m,
                std::max(scene->terrain ? scene->terrain->highest_m : 0.0f, voxels ? voxels->highest_m() : 0.0f)));
  const truth::DensityLattice lattice(particle_seed);
  const glm::vec3 camera_grid_m =
      shared::grid_place(shared::cloud_from_world(scene->camera.position_m - glm::dvec3(scene->world_origin_m, 0.0),
                                                  scene_wind_m_per_s(*scene), options.time_s))
          .grid_m;
  const truth::ExtinctionField clouds(*particles, camera_grid_m, surroundings.sun_direction(), lattice);
  std::optional<truth::VoxelField> volume;
  if (voxels) volume.emplace(std::move(voxels->voxels), voxels->at, voxels->camera_m, surroundings.sun_direction());
  const truth::Medium& field = volume ? static_cast<const truth::Medium&>(*volume) : clouds;
  const truth::Phase phase(scene->phase);
  const truth::PathTracer tracer(field, surroundings, phase);

  truth::ReferenceImage image(scene->camera, options.typed.settings.width, options.typed.settings.height, options.seed);
  const std::string state_path = options.resume ? options.out + ".state" : "";
  const std::uint64_t key = state_key(*scene, *particles, options.volume, options.sky_radiance);
  if (options.resume && std::filesystem::exists(state_path))
    if (auto ok = image.load(state_path, key); !ok) return ok;
  if (auto ok = trace(options, tracer, image, state_path, key); !ok) return ok;
  const ImageF traced = image.picture();
  if (auto ok = write_exr(options.out, traced); !ok) return ok;
  if (!options.picture.empty())
    if (auto ok = write_picture(options.picture, traced, scene->exposure_ev); !ok) return ok;
  if (!options.quiet)
    std::fprintf(stderr, "%s: %u samples a pixel, mean relative standard error %.2f %%\n", options.out.c_str(),
                 image.samples(), 100 * image.mean_relative_error());
  return options.layers.empty() ? Result<void>() : write_exr(options.layers, image.layers(field, surroundings));
}

}  // namespace

Command add_reference_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("reference", "Path-trace the truth of a scene on the CPU");
  const auto options = std::make_shared<ReferenceOptions>();
  app->add_option("--scene", options->scene, "Scene file (JSON); without it, a default sky")->type_name("FILE");
  app->add_option("--view", options->view,
                  "One of the scene's views, by its name or its number from 1 on, as the camera")
      ->type_name("NAME_OR_NUMBER");
  app->add_option("--out", options->out, "Image: .exr with R G B T SE")->type_name("FILE");
  app->add_option("--layers", options->layers, "Cloud layer alone: .exr with R G B T Z")->type_name("FILE");
  app->add_option("--picture", options->picture, "Tone-mapped as render shows it: .png")->type_name("FILE");
  add_checked_option(*app, "--time", options->time_s, "Seconds; moves the clouds with the wind", kTimeS);
  add_checked_option(*app, "--spp", options->spp, "Samples a pixel; 64 without --noise", WholeNumber{1, kMaxSamples});
  add_checked_option(*app, "--noise", options->noise,
                     "Until the mean relative standard error of the pixels is below this", RealNumber{0, 1, false});
  add_checked_option(*app, "--sky-radiance", options->sky_radiance,
                     "A sky of this radiance everywhere, instead of the atmosphere", RealNumber{0, kMaxSkyRadiance});
  add_checked_option(*app, "--seed", options->seed, "Of the random numbers",
                     WholeNumber{0, std::numeric_limits<std::uint64_t>::max()});
  add_checked_option(*app, "--threads", options->threads, "Threads that trace",
                     WholeNumber{1, kMaxThreads, 1, "one a core"});
  app->add_flag("--resume", options->resume, "Go on from FILE.exr.state, and keep it up to date");
  app->add_option("--volume", options->volume,
                  "A file of voxels as import reads it, traced itself in place of the scene's one set")
      ->type_name("VOLUME");
  add_volume_options(*app, options->volume_arguments);
  app->add_option("--tables", options->tables, "Directory that nephele bake --out filled; without it, the cache")
      ->type_name("DIR");
  app->add_option("--device", options->device, "Vulkan device: index or part of its name (see nephele devices)")
      ->type_name("NAME_OR_INDEX");
  app->add_flag("--quiet", options->quiet, "No progress bar, no summary");
  // Of the frame whose particles are traced: the cloud grid is its, and the size of the image.
  add_setting_options(*app, options->typed);
  return {app, [options] { return run_reference(*options); }};
}

}  // namespace nephele::tools
