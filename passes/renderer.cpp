// The renderer: settings to frame constants, and what a frame leaves behind. The order of passes is frame_list.cpp's.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <optional>

#include "engine/camera.h"
#include "engine/frame.h"
#include "engine/workshop.h"
#include "passes/frame_list.h"
#include "passes/nephele.h"
#include "shared/light.h"
#include "shared/light_lattice.h"
#include "shared/phase.h"
#include "shared/world.h"

namespace nephele {
namespace {

using shared::FrameConstants;

constexpr float kSunAngularRadiusRad = 0.004654f;  // 0.267 degrees

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

glm::dvec3 from_origin(const Scene& scene, const glm::dvec3& world_m) {
  return world_m - glm::dvec3(scene.world_origin_m, 0.0);
}

// What does not change from frame to frame, but for what the clouds are.
FrameConstants fixed_constants(const Scene& scene, const RenderSettings& settings) {
  FrameConstants c{};
  c.sun_direction = glm::vec3(direction_from_angles(scene.sun.azimuth_rad, scene.sun.elevation_rad));
  c.light_from_render = shared::make_light_from_render(glm::dvec3(c.sun_direction));
  c.sun_angular_radius_rad = kSunAngularRadiusRad;
  c.sun_irradiance = scene.sun.irradiance;
  c.exposure = std::exp2(scene.exposure_ev);
  c.ground_albedo = scene.ground.albedo;
  c.ground_enabled = scene.ground.enabled;
  c.atmosphere_enabled = scene.atmosphere.enabled;
  c.image_size_px = {settings.width, settings.height};
  c.layer_size_px = (c.image_size_px + settings.scale - 1u) / settings.scale;
  c.scale = settings.scale;
  c.culling_enabled = settings.culling;
  c.detail_enabled = settings.detail;
  c.light_unit = shared::light_field_unit(scene.sun.irradiance, static_cast<float>(scene.sun.elevation_rad));
  c.phase_g = scene.phase.g;
  c.phase_function = static_cast<std::uint32_t>(scene.phase.function);
  c.view_distance_m = static_cast<float>(view_distance_m(scene));
  return c;
}

std::string phase_text(std::uint32_t function, double g) {
  return concat(phase_function_name(PhaseFunction{function}), " with g = ", g);
}

Result<void> check_phase(const FrameConstants& wanted, const PhaseSettings& phase, const TableParameters& tables) {
  if (wanted.phase_function == tables.phase_function && phase.g == tables.g_multiple) return {};
  return Error{concat("the scene's phase function is ", phase_text(wanted.phase_function, phase.g),
                      "; the sky's tables are baked for ", phase_text(tables.phase_function, tables.g_multiple))};
}

}  // namespace

struct Sky::Implementation {
  Implementation(Device& device, const Tables& baked)
      : kernels(device), tables(device, baked), volumes(kernels, baked.parameters.particle_seed) {}

  Kernels kernels;
  GpuTables tables;
  ShadingVolumes volumes;
};

struct Renderer::Implementation {
  explicit Implementation(Sky::Implementation& sky_in)
      : sky(sky_in), device(sky.kernels.device()), workshop(sky.kernels), executor(device) {}

  void set(const Scene& scene_in, const RenderSettings& settings_in) {
    scene = scene_in;
    settings = settings_in;
    constants = fixed_constants(scene, settings);
    ++changes;
    last_camera_m.reset();
    workshop.begin();
    passes = std::make_unique<FramePasses>(workshop, sky.tables, sky.volumes, scene, settings);
    workshop.end(executor.frames_recorded());
    const CloudExtent clouds = passes->cloud_extent();
    constants.clouds_top_m = clouds.highest_m;
  }

  // The steps of one frame; none when the last frame's image is this one's too. A host's images may change without a
  // word.
  FrameBuilder build(const CameraState& camera, double time_s, const HostScene& host) {
    check_host(host);
    constants.host_scene = host.distance_m != nullptr || scene.terrain.has_value();
    const FrameView view{from_origin(scene, camera.position_m), time_s};
    last_camera_m = camera.position_m;
    place_camera(camera, view);
    workshop.free_unused(executor.frames_recorded());
    FrameBuilder frame(executor, settings.reuse ? Reuse::all : Reuse::lasting);
    InputBytes inputs = as_inputs(changes, constants, camera.position_m);
    const InputBytes clouds = passes->cloud_inputs(view);
    inputs.insert(inputs.end(), clouds.begin(), clouds.end());
    const bool same = frame.stands(&passes->hdr(), inputs);
    if (same && !host.distance_m) {
      recorded.push_back({recorded.empty() ? last_counted : recorded.back().counts, 0});
    } else {
      const auto slot = static_cast<std::uint32_t>(executor.frames_recorded() % kFramesInFlight);
      passes->add(frame, constants, view, host, slot);
      recorded.push_back({slot, 0});
    }
    if (recorded.size() > kFramesInFlight) recorded.pop_front();
    description = frame.describe();
    return frame;
  }

  void check_host(const HostScene& host) const {
    NEPHELE_CHECK((host.radiance != nullptr) == (host.distance_m != nullptr),
                  "a host's scene is radiance and distance");
    for (const Image* image : {host.radiance, host.distance_m})
      NEPHELE_CHECK(!image || (image->desc().width == settings.width && image->desc().height == settings.height),
                    image->name(), ": ", image->desc().width, "x", image->desc().height, ", the image is ",
                    settings.width, "x", settings.height);
  }

  void place_camera(const CameraState& camera, const FrameView& view) {
    const CameraMatrices matrices = camera_matrices(camera, static_cast<double>(settings.width) / settings.height);
    constants.clip_from_render = matrices.clip_from_render;
    constants.render_from_clip = matrices.render_from_clip;
    const glm::dvec3 air_m = shared::cloud_from_world(view.camera_m, scene_wind_m_per_s(scene), view.time_s);
    constants.camera_grid_m = shared::grid_place(air_m).grid_m;
  }

  // A recorded frame that has not been collected.
  struct Recorded {
    std::uint32_t counts;  // slot of the read-back buffer with the counts that hold for it
    double cpu_ms;
  };

  Sky::Implementation& sky;
  Device& device;
  Scene scene;
  RenderSettings settings;
  FrameConstants constants{};
  std::uint64_t changes = 0;  // of scene or settings
  Workshop workshop;
  std::unique_ptr<FramePasses> passes;
  FrameExecutor executor;
  std::deque<Recorded> recorded;            // oldest first
  std::optional<glm::dvec3> last_camera_m;  // of the last frame since scene and settings were set
  std::uint32_t last_counted = 0;           // slot of the last collected frame's counts
  FrameStats stats;
  std::string description;
};

Sky::Sky(std::unique_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
Sky::~Sky() = default;

Result<std::unique_ptr<Sky>> Sky::create(Device& device, const Tables& tables) {
  if (!device.info().usable) return Error{concat("device '", device.info().name, "' lacks ", device.info().missing)};
  if (auto ok = check_tables_fit(device.info(), tables); !ok) return ok.error();
  return std::unique_ptr<Sky>(new Sky(std::make_unique<Implementation>(device, tables)));
}

Device& Sky::device() const { return implementation_->kernels.device(); }
std::size_t Sky::pipeline_count() const { return implementation_->kernels.count(); }

Renderer::Renderer(std::unique_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
Renderer::~Renderer() = default;

Result<void> Renderer::check(const Device& device, const RenderSettings& settings) {
  if (!device.info().usable) return Error{concat("device '", device.info().name, "' lacks ", device.info().missing)};
  if (auto ok = check_settings(settings); !ok) return ok;
  if (std::max(settings.width, settings.height) > device.info().max_image_side_px)
    return Error{concat("image size is ", settings.width, "x", settings.height, "; ", device.info().name,
                        " allows 1 to ", device.info().max_image_side_px, " a side")};
  if (!backend_available(device.info(), settings.backend))
    return Error{concat("backend ", backend_name(settings.backend), " is not available on ", device.info().name,
                        "; see nephele devices")};
  if (settings.method == Method::particles && settings.blend == BlendMode::exact &&
      resolve_backend(device.info(), settings.backend) != Backend::tiled)
    return Error{concat("blend exact needs the backend tiled; the backend is ",
                        backend_name(resolve_backend(device.info(), settings.backend)))};
  return FramePasses::check(device, settings);
}

Result<std::unique_ptr<Renderer>> Renderer::create(Sky& sky, const Scene& scene, const RenderSettings& settings) {
  std::unique_ptr<Renderer> renderer(new Renderer(std::make_unique<Implementation>(*sky.implementation_)));
  if (auto ok = renderer->set(scene, settings); !ok) return ok.error();
  return renderer;
}

Result<void> Renderer::set(const Scene& scene, const RenderSettings& settings) {
  Implementation& r = *implementation_;
  if (auto ok = check(r.device, settings); !ok) return ok;
  for (const CloudSettings* field : cloud_fields(scene))
    if (field->weather_map)
      if (auto ok = check_weather_map(*field->weather_map); !ok) return ok;
  if (scene.terrain)
    if (auto ok = check_terrain(*scene.terrain); !ok) return ok;
  if (auto ok = check_phase(fixed_constants(scene, settings), scene.phase, r.sky.tables.parameters()); !ok) return ok;
  RenderSettings resolved = settings;
  resolved.backend =
      settings.method == Method::raymarch ? Backend::tiled : resolve_backend(r.device.info(), settings.backend);
  r.set(scene, resolved);
  return {};
}

void Renderer::render(const CameraState& camera, double time_s, const HostScene& host) {
  Implementation& r = *implementation_;
  const auto start = std::chrono::steady_clock::now();
  r.recorded.clear();  // frames that a host has not collected
  const FrameBuilder frame = r.build(camera, time_s, host);
  r.recorded.back().cpu_ms = milliseconds_since(start);
  r.executor.run(frame);
  const double frame_ms = milliseconds_since(start);
  collect();
  r.stats.frame_ms = frame_ms;
}

void Renderer::record(const CameraState& camera, double time_s, VkCommandBuffer commands, const HostScene& host) {
  Implementation& r = *implementation_;
  const auto start = std::chrono::steady_clock::now();
  r.executor.record(r.build(camera, time_s, host), commands);
  r.recorded.back().cpu_ms = milliseconds_since(start);
}

void Renderer::collect() {
  Implementation& r = *implementation_;
  if (r.recorded.empty()) return;
  const auto frames_ago = static_cast<std::uint32_t>(r.recorded.size() - 1);
  const Implementation::Recorded frame = r.recorded.front();
  r.recorded.pop_front();
  r.last_counted = frame.counts;
  r.stats.cpu_ms = frame.cpu_ms;
  r.stats.frame_ms = 0;  // the host's to measure
  r.stats.passes = r.executor.pass_times(frames_ago);
  if (!r.stats.passes.empty()) r.stats.fragments_shaded = r.executor.fragments_shaded(frames_ago);
  r.stats.gpu_memory_bytes = r.device.allocated_bytes();
  r.stats.backend =
      r.settings.method == Method::raymarch ? method_name(r.settings.method) : backend_name(r.settings.backend);
  r.passes->count(r.stats, frame.counts);
}

void Renderer::forget() { implementation_->executor.memory().forget(); }

const Image& Renderer::hdr() const { return implementation_->passes->hdr(); }
const Image& Renderer::display() const { return implementation_->passes->display(); }

const Image* Renderer::cloud_color() const {
  const CloudLayer* layer = implementation_->passes->cloud_layer();
  return layer ? layer->color() : nullptr;
}

const Image* Renderer::cloud_depth() const {
  const CloudLayer* layer = implementation_->passes->cloud_layer();
  return layer ? layer->depth() : nullptr;
}

std::vector<float> Renderer::read_hdr() {
  std::vector<float> pixels(std::size_t{4} * implementation_->settings.width * implementation_->settings.height);
  implementation_->passes->hdr().read(std::as_writable_bytes(std::span(pixels)));
  return pixels;
}

std::vector<std::uint8_t> Renderer::read_display() {
  std::vector<std::uint8_t> pixels(std::size_t{4} * implementation_->settings.width * implementation_->settings.height);
  implementation_->passes->display().read(std::as_writable_bytes(std::span(pixels)));
  return pixels;
}

std::vector<float> Renderer::read_layers() {
  const std::size_t count = std::size_t{implementation_->settings.width} * implementation_->settings.height;
  std::vector<float> layers(5 * count);
  const CloudLayer* clouds = implementation_->passes->cloud_layer();
  std::vector<glm::vec4> color(count, glm::vec4(0, 0, 0, 1));
  std::vector<float> depth(count, INFINITY);
  if (clouds) {
    NEPHELE_CHECK(clouds->color(), "RenderSettings::full_layer is off");
    clouds->color()->read(std::as_writable_bytes(std::span(color)));
    clouds->depth()->read(std::as_writable_bytes(std::span(depth)));
  }
  for (std::size_t i = 0; i < count; ++i) {
    const float pixel[5] = {color[i].x, color[i].y, color[i].z, color[i].w, depth[i]};
    std::copy(std::begin(pixel), std::end(pixel), layers.begin() + static_cast<std::ptrdiff_t>(5 * i));
  }
  return layers;
}

std::vector<shared::Particle> Renderer::read_particles() {
  const Implementation& r = *implementation_;
  return r.passes->read_particles(r.recorded.empty() ? r.last_counted : r.recorded.back().counts);
}

Result<std::vector<LightAt>> Renderer::light_at(const std::vector<glm::dvec3>& places_m) {
  Implementation& r = *implementation_;
  if (!r.last_camera_m) return Error{"light at a place is that of a frame; none has been rendered"};
  std::vector<glm::vec3> from_camera_m;
  for (const glm::dvec3& place_m : places_m)
    from_camera_m.emplace_back(glm::dvec2(place_m) - glm::dvec2(*r.last_camera_m), place_m.z);
  const auto light = r.passes->light_at(r.sky.kernels, from_camera_m);
  if (!light) return Error{"light at a place needs clouds, and --light field"};
  return *light;
}

const FrameStats& Renderer::stats() const { return implementation_->stats; }

std::string Renderer::describe_frame() const { return implementation_->description; }

}  // namespace nephele
