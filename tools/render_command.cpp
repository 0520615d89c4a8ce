// nephele render: headless frames of a scene to PNG or EXR files.
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
#include "tools/checked_options.h"
#include "tools/command.h"
#include "tools/options.h"
#include "tools/progress.h"
#include "tools/render_stats.h"
#include "tools/scene_tables.h"
#include "tools/scene_view.h"

namespace nephele::tools {
namespace {

constexpr double kDefaultFramesPerS = 30.0;
constexpr std::uint64_t kMaxFrames = 1000000;

// As typed.
struct RenderOptions {
  std::string scene, view, path, out, layers, stats, tables, device, tuning;
  TypedSettings typed{.settings = {.full_layer = false, .reuse = false}, .given = {}};
  double time_s = 0;
  std::optional<std::uint64_t> frames;
  std::uint64_t warmup = 0;
  bool quiet = false;
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

Result<RenderJob> prepare(const RenderOptions& options) {
  RenderJob job;
  if (options.out.empty() && options.layers.empty() && options.stats.empty())
    return Error{"render has nothing to write; give --out, --layers or --stats"};

  job.settings = options.typed.settings;
  if (!options.layers.empty()) {
    if (options.typed.has("full_layer") && !job.settings.full_layer)
      return Error{"--layers writes the cloud layer at the image's size, which --full-layer off does not keep"};
    job.settings.full_layer = true;
  }

  if (!options.scene.empty()) {
    Result<Scene> scene = load_scene(options.scene);
    if (!scene) return scene.error();
    job.scene = std::move(*scene);
  }
  if (!options.view.empty())
    if (auto ok = look_from_view(job.scene, options.view); !ok) return ok.error();
  if (!options.path.empty()) {
    Result<CameraPath> path = load_camera_path(options.path);
    if (!path) return path.error();
    job.path = std::move(*path);
  }
  job.frames = options.frames.value_or(job.path ? job.path->frame_count() : 1);

  if (auto ok = check_different({{"--scene", options.scene},
                                 {"--path", options.path},
                                 {"--out", options.out},
                                 {"--layers", options.layers},
                                 {"--stats", options.stats}},
                                job.frames);
      !ok)
    return ok.error();
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
  app->add_option("--view", options->view,
                  "One of the scene's views, by its name or its number from 1 on, as the camera")
      ->type_name("NAME_OR_NUMBER");
  app->add_option("--out", options->out, "Image: .png (tone-mapped sRGB) or .exr (linear R G B)")->type_name("FILE");
  app->add_option("--layers", options->layers, "Cloud layer alone: .exr with R G B T Z")->type_name("FILE");
  app->add_option("--stats", options->stats, "Times and counts: .json")->type_name("FILE");
  app->add_option("--tuning", options->tuning, "Kernels for this kind of device: auto, cpu or gpu (NEPHELE_TUNING)");
  app->add_option("--device", options->device, "Vulkan device: index or part of its name (see nephele devices)")
      ->type_name("NAME_OR_INDEX");
  app->add_option("--tables", options->tables, "Directory that nephele bake --out filled; without it, the cache")
      ->type_name("DIR");
  add_checked_option(*app, "--time", options->time_s, "Seconds the wind has blown at the first frame", kTimeS);
  add_checked_option(*app, "--frames", options->frames, "Frames to render, 30 a second or the path's; names need %04d",
                     WholeNumber{1, kMaxFrames});
  app->add_option("--path", options->path, "Camera path (JSON); without --frames, to its last key")->type_name("FILE");
  add_checked_option(*app, "--warmup", options->warmup, "Frames rendered first, neither timed nor written",
                     WholeNumber{0, kMaxFrames});
  app->add_flag("--quiet", options->quiet, "No progress bar");
  add_setting_options(*app, options->typed);
  return {app, [options] { return run_render(*options); }};
}

}  // namespace nephele::tools
