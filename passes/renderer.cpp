// The renderer: settings to frame constants, and what a frame leaves behind. The order of passes is frame_list.cpp's.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>

#include "engine/camera.h"
#include "engine/frame.h"
#include "engine/workshop.h"
#include "passes/frame_list.h"
#include "passes/nephele.h"
#include "shared/light.h"
#include "shared/phase.h"
#include "shared/ring_grid.h"
#include "shared/world.h"

namespace nephele {
namespace {

using shared::FrameConstants;

constexpr double kInnerCellM = 184.0;              // of the published sample
constexpr float kSunAngularRadiusRad = 0.004654f;  // 0.267 degrees

struct Preset {
  std::uint32_t ring_size_cells, layer_count;
  float crown_per_cell;
};

// [Yusov14] Table 1. Its 2, 4 and 6 layers stand on a base particle here, so that caps can close over flat bases.
Preset preset(Quality quality) {
  switch (quality) {
    case Quality::low:
      return {104, 3, 1.2f};
    case Quality::medium:
      return {136, 5, 2.5f};
    case Quality::high:
      return {184, 7, 2.5f};
  }
  return {};
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

glm::dvec3 from_origin(const Scene& scene, const glm::dvec3& world_m) {
  return world_m - glm::dvec3(scene.world_origin_m, 0.0);
}

Scene counted_from_origin(Scene scene) {
  for (ListedParticle& particle : scene.particles) particle.center_m = from_origin(scene, particle.center_m);
  return scene;
}

// As few rings as reach the view distance: their number, and with it the cost, grows with its logarithm.
std::uint32_t ring_count_for(const FrameConstants& constants) {
  std::uint32_t count = 1;
  while (count < shared::kMaxRings && shared::ring_reach_m(constants, count - 1) < constants.view_distance_m) ++count;
  return count;
}

// Double precision until only the fraction of a turn is left: a cycle is as smooth after a year.
float growth_turns(const Scene& scene, double time_s) {
  if (!scene.clouds || scene.clouds->growth_period_s <= 0.0) return -1.0f;
  const double turns = time_s / scene.clouds->growth_period_s;
  return std::min(static_cast<float>(turns - std::floor(turns)), std::nextafter(1.0f, 0.0f));
}

// The weather map under the grid of this frame: it stays where it is in the world while the grid's origin drifts.
shared::WeatherPlacement weather_placement(const Scene& scene, const glm::dvec3& camera_m, double time_s) {
  if (!scene.clouds || !scene.clouds->weather_map) return {};
  const WeatherMap& map = *scene.clouds->weather_map;
  const double unit_m = static_cast<double>(shared::kOriginUnitM);
  const glm::dvec3 cloud_m = shared::cloud_from_world(from_origin(scene, camera_m), scene.clouds->wind_m_per_s, time_s);
  const glm::dvec2 grid_origin_m = glm::round(glm::dvec2(cloud_m) / unit_m) * unit_m;  // as grid_place has it
  const glm::dvec2 drift_m = scene.clouds->wind_m_per_s * time_s;
  return shared::weather_placement({map.width, map.height}, map.origin_m - scene.world_origin_m, map.extent_m,
                                   grid_origin_m + drift_m);
}

// What does not change from frame to frame.
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
  c.phase_g = scene.phase.g;
  c.phase_function = scene.phase.function == PhaseFunction::cornette_shanks ? shared::kPhaseCornetteShanks
                                                                            : shared::kPhaseHenyeyGreenstein;
  c.listed_particle_count = static_cast<std::uint32_t>(scene.particles.size());
  const CloudSettings none{.coverage = 0.0f};
  const CloudSettings& clouds = scene.clouds ? *scene.clouds : none;
  c.clouds_enabled = scene.clouds.has_value() && (clouds.coverage > 0.0f || clouds.weather_map);
  c.seed = clouds.seed;
  c.coverage = clouds.coverage;
  c.base_m = clouds.base_m;
  c.thickness_m = clouds.thickness_m;
  c.extinction_per_m = clouds.extinction_per_m;
  c.view_distance_m = clouds.view_distance_m;
  c.ring_size_cells =
      settings.ring_size_cells > 0 ? settings.ring_size_cells : preset(settings.quality).ring_size_cells;
  c.layer_count = settings.layer_count > 0 ? settings.layer_count : preset(settings.quality).layer_count;
  c.crown_per_cell = preset(settings.quality).crown_per_cell;
  c.inner_cell_m = shared::usable_inner_cell_m(kInnerCellM);
  c.ring_count = ring_count_for(c);
  return c;
}

std::string phase_text(std::uint32_t function, double g) {
  return concat(function == shared::kPhaseCornetteShanks ? "cs" : "hg", " with g = ", g);
}

Result<void> check_phase(const FrameConstants& wanted, const PhaseSettings& phase, const TableParameters& tables) {
  if (wanted.phase_function == tables.phase_function && phase.g == tables.g_multiple) return {};
  return Error{concat("the scene's phase function is ", phase_text(wanted.phase_function, phase.g),
                      "; the sky's tables are baked for ", phase_text(tables.phase_function, tables.g_multiple))};
}

}  // namespace

struct Sky::Implementation {
  Implementation(Device& device, const Tables& baked) : kernels(device), tables(device, baked), noise(kernels) {}

  Kernels kernels;
  GpuTables tables;
  DetailNoise noise;
};

struct Renderer::Implementation {
  explicit Implementation(Sky::Implementation& sky_in)
      : sky(sky_in), device(sky.kernels.device()), workshop(sky.kernels), executor(device) {}

  void set(const Scene& scene_in, const RenderSettings& settings_in) {
    scene = counted_from_origin(scene_in);
    settings = settings_in;
    constants = fixed_constants(scene, settings);
    ++changes;
    workshop.begin();
    passes = std::make_unique<FramePasses>(workshop, sky.tables, sky.noise, scene, settings, constants);
    workshop.end(executor.frames_recorded());
  }

  // The steps of one frame; none when the last frame's image is this one's too. A host's images may change without a
  // word.
  FrameBuilder build(const CameraState& camera, double time_s, const HostScene& host) {
    check_host(host);
    constants.host_scene = host.distance_m != nullptr;
    place_camera(camera, time_s);
    workshop.free_unused(executor.frames_recorded());
    FrameBuilder frame(executor, settings.reuse ? Reuse::all : Reuse::lasting);
    const shared::WeatherPlacement weather = weather_placement(scene, camera.position_m, time_s);
    const bool same = frame.stands(&passes->hdr(), as_inputs(changes, constants, camera.position_m, weather));
    if (same && !host.distance_m) {
      recorded.push_back({recorded.empty() ? last_counted : recorded.back().counts, 0});
    } else {
      const auto slot = static_cast<std::uint32_t>(executor.frames_recorded() % kFramesInFlight);
      passes->add(frame, constants, from_origin(scene, camera.position_m), host, weather, slot);
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

  void place_camera(const CameraState& camera, double time_s) {
    const CameraMatrices matrices = camera_matrices(camera, static_cast<double>(settings.width) / settings.height);
    constants.clip_from_render = matrices.clip_from_render;
    constants.render_from_clip = matrices.render_from_clip;
    const glm::dvec2 wind = scene.clouds ? scene.clouds->wind_m_per_s : glm::dvec2(0.0);
    shared::place_camera(
        constants, shared::grid_place(shared::cloud_from_world(from_origin(scene, camera.position_m), wind, time_s)));
    constants.growth_turns = growth_turns(scene, time_s);
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
  std::deque<Recorded> recorded;   // oldest first
  std::uint32_t last_counted = 0;  // slot of the last collected frame's counts
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

const char* method_name(Method method) { return method == Method::raymarch ? "raymarch" : "particles"; }

Renderer::Renderer(std::unique_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
Renderer::~Renderer() = default;

Result<void> Renderer::check(const Device& device, const RenderSettings& settings) {
  if (!device.info().usable) return Error{concat("device '", device.info().name, "' lacks ", device.info().missing)};
  if (settings.width < 1 || settings.height < 1 || settings.width > kMaxImageSide || settings.height > kMaxImageSide)
    return Error{
        concat("image size is ", settings.width, "x", settings.height, "; accepted: 1 to ", kMaxImageSide, " a side")};
  if (std::max(settings.width, settings.height) > device.info().max_image_side_px)
    return Error{concat("image size is ", settings.width, "x", settings.height, "; ", device.info().name,
                        " allows 1 to ", device.info().max_image_side_px, " a side")};
  if (settings.scale != 1 && settings.scale != 2 && settings.scale != 4)
    return Error{concat("scale is ", settings.scale, "; accepted: 1, 2 or 4")};
  if (!backend_available(device.info(), settings.backend))
    return Error{concat("backend ", backend_name(settings.backend), " is not available on ", device.info().name,
                        "; see nephele devices")};
  if (settings.method == Method::particles && settings.blend == BlendMode::exact &&
      resolve_backend(device.info(), settings.backend) != Backend::tiled)
    return Error{concat("blend exact needs the backend tiled; the backend is ",
                        backend_name(resolve_backend(device.info(), settings.backend)))};
  if (settings.march_steps < kMinMarchSteps || settings.march_steps > kMaxMarchSteps)
    return Error{
        concat("step count is ", settings.march_steps, "; accepted: ", kMinMarchSteps, " to ", kMaxMarchSteps)};
  const std::uint32_t ring = settings.ring_size_cells;
  if (ring != 0 && (ring < kMinRingSizeCells || ring > kMaxRingSizeCells || ring % 8 != 0))
    return Error{concat("ring size is ", ring, " cells; accepted: a multiple of 8 from ", kMinRingSizeCells, " to ",
                        kMaxRingSizeCells)};
  if (settings.layer_count > kMaxLayers)
    return Error{concat("layer count is ", settings.layer_count, "; accepted: 1 to ", kMaxLayers)};
  return {};
}

Result<std::unique_ptr<Renderer>> Renderer::create(Sky& sky, const Scene& scene, const RenderSettings& settings) {
  std::unique_ptr<Renderer> renderer(new Renderer(std::make_unique<Implementation>(*sky.implementation_)));
  if (auto ok = renderer->set(scene, settings); !ok) return ok.error();
  return renderer;
}

Result<void> Renderer::set(const Scene& scene, const RenderSettings& settings) {
  Implementation& r = *implementation_;
  if (auto ok = check(r.device, settings); !ok) return ok;
  if (scene.clouds && scene.clouds->weather_map)
    if (auto ok = check_weather_map(*scene.clouds->weather_map); !ok) return ok;
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

const FrameStats& Renderer::stats() const { return implementation_->stats; }

std::string Renderer::describe_frame() const { return implementation_->description; }

}  // namespace nephele
