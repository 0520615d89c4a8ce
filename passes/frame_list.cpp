// The order of the frame, stated here alone. A step that the scene does not need is not recorded.
#include "passes/frame_list.h"

#include <algorithm>
#include <array>
#include <optional>

#include "passes/layer/view_sort.h"
#include "passes/light/cloud_shadow.h"
#include "passes/light/light_field.h"
#include "passes/light/light_tiles.h"
#include "passes/light/occlusion.h"
#include "passes/sky/atmosphere.h"
#include "passes/sky/composite.h"
#include "passes/sky/terrain.h"
#include "passes/sources/cloud_particles.h"

namespace nephele {
namespace {

using shared::FrameConstants;
using shared::FrameCounters;

constexpr std::uint32_t kTilePairsPerParticle = 8;  // of capacity; fair weather needs some five
constexpr std::uint32_t kMinTilePairs = 1u << 16;   // a few listed particles may each cover every tile
constexpr std::uint32_t kShadowTexelsPerTile = 2;

// Below this the sun lights no cloud: the horizon dips by 4.5 degrees at 20 km.
constexpr float kSunGoneSine = -0.08f;

LightGrid light_grid(const RenderSettings& settings) {
  LightGrid grid{128, 26, 50.0, settings.light_sweeps};
  if (settings.quality == Quality::low) grid = {64, 16, 75.0, settings.light_sweeps};
  if (settings.quality == Quality::high) grid = {128, 32, 50.0, settings.light_sweeps};
  if (settings.light_side_cells) grid.side_cells = settings.light_side_cells;
  if (settings.light_height_cells) grid.height_cells = settings.light_height_cells;
  if (settings.light_cell_m > 0) grid.cell_m = settings.light_cell_m;
  return grid;
}

bool by_nearest_point(const RenderSettings& settings) {
  return settings.method == Method::raymarch || settings.blend == BlendMode::exact;
}

}  // namespace

struct FramePasses::Clouds {
  Clouds(Workshop& make, const GpuTables& tables, std::vector<std::unique_ptr<CloudSource>> sources,
         const RenderSettings& settings, double light_reach, const glm::dvec2& wind_m_per_s)
      : particles(make, std::move(sources)),
        light_tiles(make, particles.capacity(), std::max(kMinTilePairs, kTilePairsPerParticle * particles.capacity())),
        light_field(settings.light == Light::field
                        ? std::make_unique<LightField>(make, particles.sources(), light_grid(settings),
                                                       particles.extent(), light_reach, wind_m_per_s)
                        : nullptr),
        occlusion(make, particles.capacity(), light_field ? std::optional<float>(light_field->near_m()) : std::nullopt),
        sort(make, particles.capacity(), by_nearest_point(settings) ? ViewOrder::nearest_point : ViewOrder::center),
        shadow(make, kShadowTexelsPerTile),
        layer(make, tables, {settings.width, settings.height, settings.scale, settings.full_layer}, settings.backend,
              settings.blend, particles.capacity(),
              {.light_field = settings.light == Light::field,
               .smooth_particles = !settings.detail,
               .soft_particles = particles.has_soft_particles()},
              settings.method == Method::raymarch ? settings.march_steps : 0),
        counters_back{&make.buffer("counters_back_0", sizeof(FrameCounters), Buffer::Memory::readback),
                      &make.buffer("counters_back_1", sizeof(FrameCounters), Buffer::Memory::readback)},
        records_back{&make.buffer("source_records_back_0", particles.records_bytes(), Buffer::Memory::readback),
                     &make.buffer("source_records_back_1", particles.records_bytes(), Buffer::Memory::readback)},
        no_radiance(&make.image("no_light_radiance", {.force_3d = true})),
        no_lattice(&make.buffer("no_light_lattice", sizeof(shared::LightLattice))) {}

  CloudParticles particles;
  LightTiles light_tiles;
  std::unique_ptr<LightField> light_field;  // none: light from tables
  Occlusion occlusion;
  ViewSort sort;
  CloudShadow shadow;
  CloudLayer layer;
  std::array<const Buffer*, kFramesInFlight> counters_back, records_back;  // by slot
  const Image* no_radiance;
  const Buffer* no_lattice;
  const Buffer* all_particles = nullptr;  // of the last frame
  bool has_air = false;                   // in the last frame
};

struct FramePasses::Passes {
  Passes(Workshop& make, const RenderSettings& settings)
      : constants(make.buffer("frame_constants", sizeof(FrameConstants))),
        no_host(make.image("no_host", {VK_FORMAT_R32_SFLOAT})),
        atmosphere(make),
        composite(make, settings.width, settings.height) {}

  const Buffer& constants;
  const Image& no_host;  // bound where there is no host's image, never read
  AtmospherePass atmosphere;
  CompositePass composite;
  std::unique_ptr<Clouds> clouds;
  std::unique_ptr<TerrainPass> terrain;
};

FramePasses::FramePasses(Workshop& make, const GpuTables& tables, const ShadingVolumes& volumes, const Scene& scene,
                         const RenderSettings& settings)
    : tables_(tables),
      volumes_(volumes),
      hdr_(make.image("hdr", {VK_FORMAT_R32G32B32A32_SFLOAT, settings.width, settings.height})),
      display_(make.image("display", {VK_FORMAT_R8G8B8A8_UNORM, settings.width, settings.height})),
      origin_m_(scene.world_origin_m),
      passes_(std::make_unique<Passes>(make, settings)) {
  std::vector<std::unique_ptr<CloudSource>> sources = make_sources(make, scene, settings);
  if (!sources.empty())
    passes_->clouds = std::make_unique<Clouds>(make, tables_, std::move(sources), settings, view_distance_m(scene),
                                               scene_wind_m_per_s(scene));
  if (scene.terrain)
    passes_->terrain = std::make_unique<TerrainPass>(make, *scene.terrain, settings.width, settings.height);
}

Result<void> FramePasses::check(const Device& device, const RenderSettings& settings) {
  return settings.light == Light::field ? check_light_grid(device, light_grid(settings)) : Result<void>{};
}

FramePasses::~FramePasses() = default;

void FramePasses::add(FrameBuilder& frame, const FrameConstants& constants, const FrameView& view,
                      const HostScene& host, std::uint32_t slot) {
  frame.update("frame_constants", passes_->constants, as_push(constants));
  CompositeInputs composite{.frame_constants = &passes_->constants,
                            .host_distance = host.distance_m ? host.distance_m : &passes_->no_host,
                            .host_radiance = host.radiance ? host.radiance : &passes_->no_host};
  const TerrainPass::HostImages drawn{*composite.host_distance, *composite.host_radiance, host.distance_m != nullptr};
  if (passes_->terrain)
    composite.host_distance = &passes_->terrain->add_distance(
        frame, passes_->constants, view.camera_m + glm::dvec3(origin_m_, 0.0), view.camera_m, drawn);
  if (constants.atmosphere_enabled)
    composite.atmosphere =
        &passes_->atmosphere.add(frame, constants, passes_->constants,
                                 {.ground_albedo = constants.ground_enabled ? constants.ground_albedo : glm::vec3(0.0f),
                                  .aerial_perspective = passes_->clouds != nullptr || constants.host_scene});
  if (passes_->clouds) add_clouds(frame, constants, view, composite, slot);
  if (passes_->terrain)
    composite.host_radiance = &passes_->terrain->add_radiance(frame, passes_->constants, constants.sun_direction,
                                                              composite.atmosphere, composite.cloud_shadow, drawn);
  passes_->composite.add(frame, composite, view.camera_m, hdr_, display_);
}

void FramePasses::add_clouds(FrameBuilder& frame, const FrameConstants& constants, const FrameView& view,
                             CompositeInputs& composite, std::uint32_t slot) {
  Clouds& c = *passes_->clouds;
  const Image* transmittance = constants.atmosphere_enabled ? &passes_->atmosphere.tables().transmittance : nullptr;
  c.has_air = constants.atmosphere_enabled;
  const CloudParticles::Outputs particles = c.particles.add(frame, passes_->constants, view);
  c.all_particles = &particles.particles;
  const LightTileLists tiles = c.light_tiles.add(frame, passes_->constants, particles.particles, particles.counters);
  const Buffer& lights = c.occlusion.add(frame, passes_->constants, particles.particles, particles.visible,
                                         particles.counters, tiles, transmittance);
  const Buffer& draw_order = c.sort.add(frame, particles.particles, particles.visible, particles.counters);
  LightField::Outputs light{c.no_radiance, c.no_lattice};
  if (c.light_field)
    light = c.light_field->add(frame, {constants, passes_->constants, view,
                                       constants.atmosphere_enabled ? &passes_->atmosphere.tables() : nullptr});
  c.layer.add(frame, {passes_->constants,
                      particles.particles,
                      particles.visible,
                      draw_order,
                      lights,
                      particles.counters,
                      particles.records,
                      passes_->atmosphere.tables().sky_irradiance,
                      {tables_, volumes_, *light.radiance},
                      *light.lattice,
                      *composite.host_distance});
  composite.layer_color = &c.layer.layer_color();
  composite.layer_depth = &c.layer.layer_depth();
  if (constants.scale > 1) {
    composite.layer_scene = &c.layer.layer_scene();
    composite.full_color = c.layer.color();
    composite.full_depth = c.layer.depth();
  }
  if ((constants.ground_enabled || passes_->terrain) && constants.sun_direction.z > kSunGoneSine)
    composite.cloud_shadow = &c.shadow.add(frame, passes_->constants, tiles);
  frame.read_back("read_counters", particles.counters, *c.counters_back[slot], sizeof(FrameCounters));
  frame.read_back("read_counters", particles.records, *c.records_back[slot], c.particles.records_bytes());
}

InputBytes FramePasses::cloud_inputs(const FrameView& view) const {
  return passes_->clouds ? passes_->clouds->particles.inputs(view) : InputBytes();
}

CloudExtent FramePasses::cloud_extent() const {
  return passes_->clouds ? passes_->clouds->particles.extent() : CloudExtent{kNoTopM, -kNoTopM};
}

void FramePasses::count(FrameStats& stats, std::uint32_t slot) const {
  stats.overflow = {{"particles", 0}, {"visible", 0}, {"tile_pairs", 0}, {"screen_pairs", 0}, {"rays", 0}};
  stats.sources.clear();
  stats.particles_generated = stats.particles_visible = 0;
  stats.pairs_shaded = 0;
  if (!passes_->clouds) return;
  const FrameCounters& counters = *static_cast<const FrameCounters*>(passes_->clouds->counters_back[slot]->mapped());
  stats.particles_generated = counters.particle_count;
  stats.particles_visible = counters.visible_count;
  stats.overflow["particles"] = counters.particle_demand - counters.particle_count;
  stats.overflow["visible"] = counters.visible_demand - counters.visible_count;
  stats.overflow["tile_pairs"] = counters.tile_pair_demand - counters.tile_pair_count;
  stats.overflow["screen_pairs"] = counters.screen_pair_demand - counters.screen_pair_count;
  stats.overflow["rays"] = counters.rays_cut_short;
  stats.pairs_shaded = counters.pairs_shaded;
  const auto* record = static_cast<const shared::SourceRecord*>(passes_->clouds->records_back[slot]->mapped());
  for (const auto& source : passes_->clouds->particles.sources()) {
    stats.sources.push_back({source->name(), record->count, record->demand - record->count});
    ++record;
  }
}

std::vector<shared::Particle> FramePasses::read_particles(std::uint32_t slot) const {
  if (!passes_->clouds || !passes_->clouds->all_particles) return {};
  const auto& counters = *static_cast<const FrameCounters*>(passes_->clouds->counters_back[slot]->mapped());
  return passes_->clouds->all_particles->read_vector<shared::Particle>(counters.particle_count);
}

std::optional<std::vector<LightAt>> FramePasses::light_at(Kernels& kernels,
                                                          const std::vector<glm::vec3>& places_m) const {
  if (!passes_->clouds || !passes_->clouds->light_field) return std::nullopt;
  if (places_m.empty()) return std::vector<LightAt>();
  Device& device = kernels.device();
  Buffer places(device, "light_places", places_m.size() * sizeof(glm::vec3)),
      light(device, "light_at", LightField::kQueryParts * places_m.size() * sizeof(LightAt));
  places.write_vector(places_m);
  FrameBuilder frame(device);
  passes_->clouds->light_field->add_query(
      frame, kernels,
      {passes_->constants, passes_->clouds->has_air ? &passes_->atmosphere.tables() : nullptr, tables_.near_beam(),
       static_cast<std::uint32_t>(places_m.size()), places, light});
  FrameExecutor(device).run(frame);
  const auto parts = light.read_vector<LightAt>(LightField::kQueryParts * places_m.size());
  std::vector<LightAt> sums(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(places_m.size()));
  for (std::size_t i = places_m.size(); i < parts.size(); ++i)
    for (std::size_t k = 0; k < parts[i].harmonics.size(); ++k)
      sums[i % places_m.size()].harmonics[k] += parts[i].harmonics[k];
  return sums;
}

const CloudLayer* FramePasses::cloud_layer() const { return passes_->clouds ? &passes_->clouds->layer : nullptr; }

}  // namespace nephele
