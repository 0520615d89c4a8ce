#include "passes/sources/cell_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

#include "nephele_shaders.h"
#include "shared/cell_particles.h"
#include "shared/listed_particles.h"

namespace nephele {

using shared::FrameConstants;
using shared::FrameCounters;

namespace {

constexpr std::uint32_t kLocalSize = 64;
constexpr VkDeviceSize kBytesPerParticle = 160;  // the largest array with an element for every particle
constexpr double kEvenOutM = 5000.0;             // over fewer metres than this the sky may be much fuller than its mean

std::uint32_t groups_for(std::uint32_t threads) { return (threads + kLocalSize - 1) / kLocalSize; }

std::vector<shared::ListedSource> listed_sources(std::span<const ListedParticle> listed) {
  std::vector<shared::ListedSource> sources;
  sources.reserve(listed.size());
  for (const ListedParticle& p : listed) {
    const bool reference = p.shape == ParticleShape::reference;
    const std::uint32_t flags = (reference ? 0u : shared::kParticleHomogeneous) |
                                (p.radiance ? shared::kParticleEmissive : 0u) |
                                (reference && !p.radiance ? shared::kParticleDetail : 0u);
    sources.push_back({shared::split_place(p.center_m), p.radius_m, static_cast<float>(p.yaw_rad),
                       p.extinction_per_m * p.density, flags, p.radiance.value_or(glm::vec3(0.0f)),
                       shared::hash_uint(static_cast<std::uint32_t>(sources.size()))});
  }
  return sources;
}

// As cloud_features.glsl has it.
struct GridPush {
  std::array<shared::FeatureWindow, shared::kCloudLattices> windows, near_windows;
  shared::WeatherPlacement weather;
};

GridPush grid_push(const FrameConstants& constants, const shared::WeatherPlacement& weather) {
  GridPush push{{}, {}, weather};
  for (std::uint32_t lattice = 0; lattice < shared::kCloudLattices; ++lattice) {
    push.windows[lattice] = shared::feature_window(constants, lattice);
    push.near_windows[lattice] = shared::near_window(constants, lattice);
  }
  return push;
}

// As weather.h has them; one texel that is never read where there is no map.
std::vector<std::uint32_t> packed_texels(const WeatherMap* map) {
  std::vector<std::uint32_t> packed;
  if (map)
    for (const glm::u8vec2 texel : map->texels) packed.push_back(texel.x | std::uint32_t{texel.y} << 8);
  packed.resize(std::max<std::size_t>(packed.size(), 1));
  return packed;
}

float most_coverage(const FrameConstants& constants, const WeatherMap* map) {
  float most = constants.coverage;
  if (map)
    for (const glm::u8vec2 texel : map->texels) most = std::max(most, static_cast<float>(texel.x) / 255.0f);
  return most;
}

FrameConstants with_coverage(FrameConstants constants, float coverage) {
  constants.coverage = coverage;
  return constants;
}

// All that the content of the cells depends on, the rest 0.
FrameConstants what_cells_need(const FrameConstants& constants) {
  FrameConstants needed;
  std::memset(&needed, 0, sizeof needed);
  needed.origin_index = constants.origin_index;
  needed.camera_cell = constants.camera_cell;
  needed.growth_turns = constants.growth_turns;
  needed.seed = constants.seed;
  needed.coverage = constants.coverage;
  needed.base_m = constants.base_m;
  needed.thickness_m = constants.thickness_m;
  needed.view_distance_m = constants.view_distance_m;
  needed.ring_count = constants.ring_count;
  needed.ring_size_cells = constants.ring_size_cells;
  needed.layer_count = constants.layer_count;
  needed.inner_cell_m = constants.inner_cell_m;
  needed.crown_per_cell = constants.crown_per_cell;
  return needed;
}

}  // namespace

std::uint32_t CloudParticles::capacity_for(const Device& device, const FrameConstants& constants) {
  double cells = 0.0;
  const double reach = shared::cloud_reach_m(constants);
  for (std::uint32_t ring = 0; ring < constants.ring_count; ++ring) {
    const double cell = shared::ring_cell_m(constants, ring);
    const double outer = std::min<double>(reach, shared::ring_reach_m(constants, ring)) + cell;
    const double inner = ring > 0 ? 0.8 * shared::ring_reach_m(constants, ring - 1) : 0.0;
    if (inner < outer) cells += std::numbers::pi * (outer * outer - inner * inner) / (cell * cell);
  }
  const double covered = std::min(1.0, 1.15 * constants.coverage + 0.1 + kEvenOutM / std::max(reach, 1.0));
  const double per_cell = 1.2 + 0.6 * (constants.layer_count - 1.0) + 2.1 * constants.crown_per_cell;
  const double wanted = constants.clouds_enabled ? 1.15 * cells * covered * per_cell + 256.0 : 0.0;
  const double limit = static_cast<double>(
      std::min(device.max_elements(kBytesPerParticle), VkDeviceSize{device.info().max_groups} * kLocalSize));
  return static_cast<std::uint32_t>(std::clamp(wanted + constants.listed_particle_count, 1.0, limit));
}

CloudParticles::CloudParticles(Workshop& make, const FrameConstants& constants, std::span<const ListedParticle> listed,
                               std::uint32_t capacity, const WeatherMap* map)
    : features_kernel_(make.device(), shaders::cloud_features_comp),
      near_(make.device(), shaders::cloud_features_near_comp),
      list_(make.device(), shaders::grid_list_comp),
      cells_(make.device(), shaders::grid_cells_comp),
      show_(make.device(), shaders::grid_show_comp),
      fit_(make.device(), shaders::grid_fit_comp),
      thin_(make.device(), shaders::grid_thin_comp),
      expand_(make.device(), shaders::grid_expand_comp),
      particles_kernel_(make.device(), shaders::particles_comp),
      listed_kernel_(make.device(), shaders::listed_particles_comp),
      visibility_(make.device(), shaders::visibility_comp),
      visible_list_(make.device(), shaders::visible_list_comp),
      map_size_(map ? glm::ivec2(map->width, map->height) : glm::ivec2(0)),
      most_coverage_(most_coverage(constants, map)),
      listed_count_(static_cast<std::uint32_t>(listed.size())),
      capacity_(capacity > 0 ? capacity : capacity_for(make.device(), with_coverage(constants, most_coverage_))),
      cell_count_(constants.clouds_enabled ? shared::grid_cell_count(constants) : 0),
      feature_count_(constants.clouds_enabled ? shared::feature_count(constants) : 0),
      near_count_(constants.clouds_enabled ? shared::near_count(constants) : 0),
      scan_(make, "cells", std::max(cell_count_, capacity_) + 1),
      weather_map_(make.device(), "weather_map", packed_texels(map).size() * sizeof(std::uint32_t)),
      features_(make.device(), "cloud_features",
                VkDeviceSize{std::max(feature_count_, 1u)} * sizeof(shared::PackedFeature)),
      features_near_(make.device(), "cloud_features_near",
                     VkDeviceSize{std::max(near_count_, 1u)} * sizeof(std::uint32_t)),
      cell_list_(make.device(), "cell_list", VkDeviceSize{std::max(cell_count_, 1u)} * sizeof(std::uint32_t)),
      cell_clouds_(make.device(), "cell_clouds",
                   VkDeviceSize{std::max(cell_count_, 1u)} * sizeof(shared::PackedCellCloud)),
      cell_counts_(make.device(), "cell_counts", VkDeviceSize{std::max(cell_count_, 1u)} * sizeof(std::uint32_t)),
      cell_first_(make.device(), "cell_first", VkDeviceSize{cell_count_ + 1} * sizeof(std::uint32_t)),
      distance_counts_(make.device(), "distance_counts", VkDeviceSize{shared::kDistanceBins} * sizeof(std::uint32_t)),
      particle_cell_(make.device(), "particle_cell", VkDeviceSize{capacity_} * sizeof(std::uint32_t)),
      listed_(make.device(), "listed_particles",
              std::max<VkDeviceSize>(listed.size(), 1) * sizeof(shared::ListedSource)),
      particles_(make.device(), "particles", VkDeviceSize{capacity_} * sizeof(shared::Particle)),
      places_(make.device(), "visible_places", VkDeviceSize{capacity_ + 1} * sizeof(std::uint32_t)),
      visible_(make.device(), "visible", VkDeviceSize{capacity_} * sizeof(std::uint32_t)),
      counters_(make.device(), "counters", sizeof(FrameCounters)) {
  NEPHELE_CHECK(constants.listed_particle_count == listed_count_, constants.listed_particle_count, " and ",
                listed_count_);
  NEPHELE_CHECK(constants.ring_count >= 1 && constants.ring_count <= shared::kMaxRings, constants.ring_count, " rings");
  weather_map_.write_vector(packed_texels(map));
  if (!listed.empty()) listed_.write_vector(listed_sources(listed));
}

CloudParticles::Outputs CloudParticles::add(FrameBuilder& frame, const FrameConstants& constants, const Buffer& buffer,
                                            const glm::dvec3& camera_world_m, const shared::WeatherPlacement& weather) {
  NEPHELE_CHECK(weather.size == map_size_, weather.size.x, "x", weather.size.y, ", the map is ", map_size_.x, "x",
                map_size_.y);
  FrameCounters start{};
  start.particle_demand = listed_count_;
  start.particle_count = std::min(listed_count_, capacity_);
  start.particle_groups = {groups_for(start.particle_count), 1, 1};
  start.found_cell_groups = {0, 1, 1};
  start.visible_groups = {0, 1, 1};  // where there are no particles, nothing writes these
  start.draw = {0, 1, 0, 0};
  frame.update("grid_cells", counters_, as_push(start));
  if (constants.clouds_enabled && most_coverage_ > 0.0f) add_grid(frame, constants, buffer, weather);
  if (listed_count_ > 0) add_listed(frame, camera_world_m);
  add_visible(frame, buffer);
  return {particles_, visible_, counters_};
}

void CloudParticles::add_cells(FrameBuilder& frame, const Buffer& buffer, const PushConstants& push) {
  frame.compute({.name = "grid_cells",
                 .kernel = &features_kernel_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, features_, Access::storage_write},
                              {2, weather_map_, Access::storage_read}},
                 .push = push,
                 .groups = {groups_for(feature_count_), 1, 1}});
  frame.compute({.name = "grid_cells",
                 .kernel = &near_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, features_, Access::texels},
                              {2, features_near_, Access::storage_write}},
                 .push = push,
                 .groups = {groups_for(near_count_), 1, 1}});
  frame.fill("grid_cells", cell_counts_, 0);
  frame.compute({.name = "grid_cells",
                 .kernel = &list_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, cell_list_, Access::storage_write},
                              {2, counters_, Access::storage_read_write}},
                 .groups = {groups_for(cell_count_), 1, 1}});
  frame.compute({.name = "grid_cells",
                 .kernel = &cells_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, features_, Access::texels},
                              {2, cell_clouds_, Access::storage_write},
                              {3, cell_counts_, Access::storage_write},
                              {4, weather_map_, Access::storage_read},
                              {5, cell_list_, Access::storage_read},
                              {6, counters_, Access::storage_read},
                              {7, features_near_, Access::words}},
                 .push = push,
                 .indirect = {&counters_, offsetof(FrameCounters, found_cell_groups)}});
}

void CloudParticles::add_grid(FrameBuilder& frame, const FrameConstants& constants, const Buffer& buffer,
                              const shared::WeatherPlacement& weather) {
  NEPHELE_CHECK(shared::grid_cell_count(constants) == cell_count_ && shared::feature_count(constants) == feature_count_,
                "the grid changed size: ", shared::grid_cell_count(constants), " cells, ", cell_count_, " expected");
  const PushConstants push = as_push(grid_push(constants, weather));
  if (!frame.stands(&cell_clouds_, as_inputs(what_cells_need(constants), weather))) add_cells(frame, buffer, push);
  frame.update("grid_cells", distance_counts_, std::vector<std::byte>(distance_counts_.bytes()));
  frame.compute({.name = "grid_cells",
                 .kernel = &show_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, cell_counts_, Access::storage_read},
                              {2, cell_first_, Access::storage_write},
                              {3, counters_, Access::storage_read_write},
                              {4, distance_counts_, Access::storage_read_write}},
                 .groups = {groups_for(cell_count_ + 1), 1, 1}});
  frame.compute({.name = "grid_cells",
                 .kernel = &fit_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, distance_counts_, Access::storage_read},
                              {2, counters_, Access::storage_read_write}},
                 .push = as_push(capacity_)});
  frame.compute({.name = "grid_cells",
                 .kernel = &thin_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, counters_, Access::storage_read},
                              {2, cell_first_, Access::storage_read_write}},
                 .indirect = {&counters_, offsetof(FrameCounters, thin_groups)}});
  scan_.add(frame, "grid_cells", cell_first_, cell_count_ + 1, counters_, offsetof(FrameCounters, cell_particle_count));
  frame.compute({.name = "particles",
                 .kernel = &expand_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, cell_first_, Access::storage_read},
                              {2, particle_cell_, Access::storage_write},
                              {3, counters_, Access::storage_read_write}},
                 .push = as_push(capacity_),
                 .groups = {groups_for(cell_count_), 1, 1}});
  frame.compute({.name = "particles",
                 .kernel = &particles_kernel_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, features_, Access::texels},
                              {2, cell_clouds_, Access::storage_read},
                              {3, cell_first_, Access::storage_read},
                              {4, particle_cell_, Access::storage_read},
                              {5, counters_, Access::storage_read},
                              {6, particles_, Access::storage_write}},
                 .push = push,
                 .indirect = {&counters_, offsetof(FrameCounters, particle_groups)}});
}

void CloudParticles::add_listed(FrameBuilder& frame, const glm::dvec3& camera_world_m) {
  struct Push {
    shared::SplitPlace camera;
    std::uint32_t count;
  };
  const std::uint32_t count = std::min(listed_count_, capacity_);
  frame.compute({.name = "particles",
                 .kernel = &listed_kernel_,
                 .bindings = {{0, listed_, Access::storage_read}, {1, particles_, Access::storage_write}},
                 .push = as_push(Push{shared::split_place(camera_world_m), count}),
                 .groups = {groups_for(count), 1, 1}});
}

void CloudParticles::add_visible(FrameBuilder& frame, const Buffer& buffer) {
  const Indirect every_particle{&counters_, offsetof(FrameCounters, particle_groups)};
  frame.fill("visibility", places_, 0);
  frame.compute({.name = "visibility",
                 .kernel = &visibility_,
                 .bindings = {{0, buffer, Access::uniform},
                              {1, particles_, Access::texels},
                              {2, counters_, Access::storage_read},
                              {3, places_, Access::storage_write}},
                 .indirect = every_particle});
  scan_.add(frame, "visibility", places_, capacity_ + 1, counters_, offsetof(FrameCounters, visible_demand));
  frame.compute({.name = "visibility",
                 .kernel = &visible_list_,
                 .bindings = {{0, places_, Access::storage_read},
                              {1, visible_, Access::storage_write},
                              {2, counters_, Access::storage_read_write}},
                 .indirect = every_particle});
}

}  // namespace nephele
