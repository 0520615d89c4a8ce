// nephele render: headless frames of a scene to PNG or EXR files.
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "engine/atomic_file.h"
#include "engine/camera_path.h"
#include "engine/check.h"
#include "engine/device.h"
#include "engine/image_io.h"
#include "engine/scene.h"
#include "passes/nephele.h"
#include "tools/command.h"
#include "tools/options.h"
#include "tools/progress.h"
#include "tools/render_stats.h"
#include "tools/scene_tables.h"

namespace nephele::tools {
namespace {

constexpr double kDefaultFramesPerS = 30.0;
constexpr std::uint64_t kMaxFrames = 1000000;
constexpr double kMaxTimeS = 1e9;

// As typed.
struct RenderOptions {
  std::string scene, path, out, layers, stats, tables, device, tuning;
  std::string size = "1280x720", quality = "medium", backend = "auto", blend = "volume", method = "particles";
  std::uint32_t scale = 1, steps = RenderSettings{}.march_steps;
  double time_s = 0;
  std::uint64_t frames = 0;  // 0: not given
  std::uint64_t warmup = 0;
  bool reuse = false, quiet = false;
};

// Checked and loaded: nothing the user typed can be wrong any more, except what only the device knows.
struct RenderJob {
  Scene scene;
  std::optional<CameraPath> path;
  RenderSettings settings;
  std::uint64_t frames = 1;

  double frame_time_s(std::uint64_t frame) const {
    return static_cast<double>(frame) / (path ? path->frames_per_s : kDefaultFramesPerS);
  }
  CameraState camera(std::uint64_t frame) const {
    return path ? path->at(frame_time_s(frame), scene.camera) : scene.camera;
  }
};

Result<void> check_output(const char* option, const std::string& name, std::initializer_list<const char*> extensions,
                          std::uint64_t frames) {
  if (name.empty()) return {};
  std::string accepted;
  bool known = false;
  for (const char* extension : extensions) {
    known = known || has_extension(name, extension);
    accepted += (accepted.empty() ? "" : " or ") + std::string(extension);
  }
  if (!known) return Error{std::string(option) + " is \"" + name + "\"; accepted: a name ending in " + accepted};
  if (frames > 1 && !has_frame_number(name))
    return Error{std::string(option) + " is \"" + name + "\"; with more than one frame it needs %04d in it"};
  return check_writable(frame_file_name(name, 0));
}

Backend parse_backend(const std::string& name) {
  for (const Backend backend : {Backend::interlock, Backend::attachment, Backend::tiled, Backend::alpha})
    if (name == backend_name(backend)) return backend;
  return Backend::automatic;
}

Result<RenderJob> prepare(const RenderOptions& options) {
  RenderJob job;
  if (options.out.empty() && options.layers.empty() && options.stats.empty())
    return Error{"render has nothing to write; give --out, --layers or --stats"};

  if (!(std::abs(options.time_s) <= kMaxTimeS))
    return Error{concat("--time is ", options.time_s, "; accepted: a number from ", -kMaxTimeS, " to ", kMaxTimeS)};
  if (options.out == options.layers && !options.out.empty())
    return Error{"--out and --layers are both \"" + options.out + "\""};

  const Result<ImageSize> size = parse_image_size("--size", options.size);
  if (!size) return size.error();
  job.settings = {.width = size->width,
                  .height = size->height,
                  .quality = quality_named(options.quality),
                  .scale = options.scale,
                  .full_layer = !options.layers.empty(),
                  .reuse = options.reuse,
                  .backend = parse_backend(options.backend),
                  .blend = options.blend == blend_mode_name(BlendMode::exact) ? BlendMode::exact : BlendMode::volume,
                  .method = options.method == method_name(Method::raymarch) ? Method::raymarch : Method::particles,
                  .march_steps = options.steps};

  if (!options.scene.empty()) {
    Result<Scene> scene = load_scene(options.scene);
    if (!scene) return scene.error();
    job.scene = std::move(*scene);
  }
  if (!options.path.empty()) {
    Result<CameraPath> path = load_camera_path(options.path);
    if (!path) return path.error();
    job.path = std::move(*path);
  }
  job.frames = options.frames > 0 ? options.frames : job.path ? job.path->frame_count() : 1;

  if (auto ok = check_output("--out", options.out, {".png", ".exr"}, job.frames); !ok) return ok.error();
  if (auto ok = check_output("--layers", options.layers, {".exr"}, job.frames); !ok) return ok.error();
  if (auto ok = check_output("--stats", options.stats, {".json"}, 1); !ok) return ok.error();
  return job;
}

// Linear R G B, without the alpha that read_hdr carries.
ImageF hdr_image(const RenderSettings& settings, const std::vector<float>& rgba) {
  ImageF image{settings.width, settings.height, {"R", "G", "B"}, {}};
  image.data.reserve(rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    image.data.insert(image.data.end(), {rgba[i], rgba[i + 1], rgba[i + 2]});
  return image;
}

Result<void> write_outputs(const RenderOptions& options, const RenderSettings& settings, Renderer& renderer,
                           std::uint64_t frame) {
  const std::string out = frame_file_name(options.out, frame);
  Result<void> written;
  if (has_extension(out, ".png"))
    written = write_png(out, settings.width, settings.height, renderer.read_display());
  else if (has_extension(out, ".exr"))
    written = write_exr(out, hdr_image(settings, renderer.read_hdr()));
  if (!written || options.layers.empty()) return written;
  return write_exr(frame_file_name(options.layers, frame),
                   {settings.width, settings.height, {"R", "G", "B", "T", "Z"}, renderer.read_layers()});
}

void warn_of_overflow(const std::vector<FrameStats>& frames) {
  for (const FrameStats& frame : frames)
    for (const auto& [buffer, lost] : frame.overflow)
      if (lost > 0) {
        std::fprintf(stderr, "nephele: warning: %llu items found no room in buffer \"%s\"; the picture lacks them\n",
                     static_cast<unsigned long long>(lost), buffer.c_str());
        return;
      }
}

Result<void> run_render(const RenderOptions& options) {
  const Result<RenderJob> job = prepare(options);
  if (!job) return job.error();
  const Result<std::unique_ptr<Device>> device =
      Device::create(DeviceOptions::from_environment(options.device, options.tuning));
  if (!device) return device.error();
  const Result<Tables> tables = tables_for_scene(job->scene, options.tables, options.quiet);
  if (!tables) return tables.error();
  const Result<std::unique_ptr<Sky>> sky = Sky::create(**device, *tables);
  if (!sky) return sky.error();
  const Result<std::unique_ptr<Renderer>> made = Renderer::create(**sky, job->scene, job->settings);
  if (!made) return made.error();
  Renderer& renderer = **made;

  Progress progress(options.quiet);
  const double total = static_cast<double>(options.warmup + job->frames);
  for (std::uint64_t i = 0; i < options.warmup; ++i) {
    progress.show("warming up", static_cast<double>(i) / total);
    renderer.render(job->camera(0), options.time_s);
  }
  std::vector<FrameStats> frames;
  for (std::uint64_t i = 0; i < job->frames; ++i) {
    progress.show("rendering", static_cast<double>(options.warmup + i) / total);
    renderer.render(job->camera(i), options.time_s + job->frame_time_s(i));
    frames.push_back(renderer.stats());
    if (auto written = write_outputs(options, job->settings, renderer, i); !written) return written;
  }
  warn_of_overflow(frames);
  if (options.stats.empty()) return {};
  return write_file_atomically(options.stats, render_stats_json((*device)->info(), job->settings, frames));
}

}  // namespace

Command add_render_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("render", "Render frames of a scene to PNG or EXR files");
  const auto options = std::make_shared<RenderOptions>();
  app->add_option("--scene", options->scene, "Scene file (JSON); without it, a default sky")->type_name("FILE");
  app->add_option("--out", options->out, "Image: .png (tone-mapped sRGB) or .exr (linear R G B)")->type_name("FILE");
  app->add_option("--layers", options->layers, "Cloud layer alone: .exr with R G B T Z")->type_name("FILE");
  app->add_option("--stats", options->stats, "Times and counts: .json")->type_name("FILE");
  app->add_option("--size", options->size, "Pixels")->type_name("WIDTHxHEIGHT")->capture_default_str();
  app->add_option("--quality", options->quality, "Size of the cloud grid: rings, cells, layers")
      ->check(CLI::IsMember({"low", "medium", "high"}))
      ->capture_default_str();
  app->add_option("--scale", options->scale, "Divisor of the cloud layer's resolution")
      ->check(CLI::IsMember({1u, 2u, 4u}))
      ->capture_default_str();
  app->add_option("--backend", options->backend, "How overlapping particles are blended (see nephele devices)")
      ->check(CLI::IsMember({"auto", "interlock", "attachment", "tiled", "alpha"}))
      ->capture_default_str();
  app->add_option("--blend", options->blend,
                  "volume: pairs of particles share their volume; exact: any number (tiled only)")
      ->check(CLI::IsMember({"volume", "exact"}))
      ->capture_default_str();
  app->add_option("--method", options->method,
                  "raymarch: the baseline, rays through the same particles in steps; no --backend, --blend")
      ->check(CLI::IsMember({"particles", "raymarch"}))
      ->capture_default_str();
  app->add_option("--steps", options->steps,
                  "Of a marched ray through eight particles in a row; 16 is coarse, 512 fine")
      ->check(CLI::Range(kMinMarchSteps, kMaxMarchSteps))
      ->capture_default_str();
  app->add_option("--tuning", options->tuning, "Kernels for this kind of device: auto, cpu or gpu (NEPHELE_TUNING)");
  app->add_option("--device", options->device, "Vulkan device: index or part of its name (see nephele devices)")
      ->type_name("NAME_OR_INDEX");
  app->add_option("--tables", options->tables, "Directory that nephele bake --out filled; without it, the cache")
      ->type_name("DIR");
  app->add_option("--time", options->time_s, "Seconds the wind has blown at the first frame")
      ->type_name("SECONDS")
      ->capture_default_str();
  app->add_option("--frames", options->frames, "Frames to render, 30 a second or the path's; names need %04d")
      ->check(CLI::Range(std::uint64_t{1}, kMaxFrames));
  app->add_option("--path", options->path, "Camera path (JSON); without --frames, to its last key")->type_name("FILE");
  app->add_option("--warmup", options->warmup, "Frames rendered first, neither timed nor written")
      ->check(CLI::Range(std::uint64_t{0}, kMaxFrames))
      ->capture_default_str();
  app->add_flag("--reuse", options->reuse,
                "Do not do again what the frame before left ready, as hosts do; without it every frame's time is that "
                "of all its work");
  app->add_flag("--quiet", options->quiet, "No progress bar");
  return {app, [options] { return run_render(*options); }};
}

}  // namespace nephele::tools
