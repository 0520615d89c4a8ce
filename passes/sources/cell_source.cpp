#include "passes/sources/cell_source.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "nephele_shaders.h"
#include "shared/cell_particles.h"

namespace nephele {

using shared::CloudField;
using shared::FieldCounters;
using shared::FieldFrame;

namespace {

constexpr std::uint32_t kLocalSize = 64;
constexpr double kInnerCellM = 184.0;     // of the published sample
constexpr double kEvenOutM = 5000.0;      // over fewer metres than this the sky may be much fuller than its mean
constexpr float kBelowBaseM = 100.0f;     // that flat bases lie below CloudField::base_m at most
constexpr float kAboveTallestM = 500.0f;  // that particles reach beyond base and thickness, by far

std::uint32_t groups_for(std::uint32_t threads) { return (threads + kLocalSize - 1) / kLocalSize; }

// As weather.h has them; one texel that is never read where there is no map.
const Buffer& upload(Workshop& make, std::string_view name, const WeatherMap* map) {
  std::vector<std::uint32_t> packed;
  if (map)
    for (const glm::u8vec2 texel : map->texels) packed.push_back(texel.x | std::uint32_t{texel.y} << 8);
  packed.resize(std::max<std::size_t>(packed.size(), 1));
  return make.uploaded(std::string(name), std::as_bytes(std::span(packed)));
}

float coverage_at_most(const CloudField& field, const WeatherMap* map) {
  float most = field.coverage;
  if (map)
    for (const glm::u8vec2 texel : map->texels) most = std::max(most, static_cast<float>(texel.x) / 255.0f);
  return most;
}

const WeatherMap* map_of(const CloudSettings& clouds) { return clouds.weather_map ? &*clouds.weather_map : nullptr; }

// As few rings as reach the view distance: their number, and with it the cost, grows with its logarithm.
std::uint32_t ring_count_for(const CloudField& field) {
  std::uint32_t count = 1;
  while (count < shared::kMaxRings && shared::ring_reach_m(field, count - 1) < field.view_distance_m) ++count;
  return count;
}

// What does not change from frame to frame.
CloudField fixed_field(const CloudSettings& clouds, const FieldGrid& grid) {
  CloudField field{};
  field.seed = clouds.seed;
  field.coverage = clouds.coverage;
  field.base_m = clouds.base_m;
  field.thickness_m = clouds.thickness_m;
  field.extinction_per_m = clouds.extinction_per_m;
  field.view_distance_m = clouds.view_distance_m;
  field.ring_size_cells = grid.ring_size_cells;
  field.layer_count = grid.layer_count;
  field.crown_per_cell = grid.crown_per_cell;
  field.inner_cell_m = shared::usable_inner_cell_m(kInnerCellM);
  field.ring_count = ring_count_for(field);
  if (clouds.weather_map) field.weather.size = {clouds.weather_map->width, clouds.weather_map->height};
  return field;
}

// Double precision until only the fraction of a turn is left: a cycle is as smooth after a year.
float growth_turns(double growth_period_s, double time_s) {
  if (growth_period_s <= 0.0) return -1.0f;
  const double turns = time_s / growth_period_s;
  return std::min(static_cast<float>(turns - std::floor(turns)), std::nextafter(1.0f, 0.0f));
}

}  // namespace

std::uint32_t CellSource::capacity_for(const CloudField& field, float most_coverage) {
  double cells = 0.0;
  const double reach = shared::cloud_reach_m(field);
  for (std::uint32_t ring = field.first_ring; ring <= shared::last_ring(field); ++ring) {
    const double cell = shared::ring_cell_m(field, ring);
    const double outer = std::min<double>(reach, shared::ring_reach_m(field, ring)) + cell;
    const double inner = ring > field.first_ring ? 0.8 * shared::ring_reach_m(field, ring - 1) : 0.0;
    if (inner < outer) cells += std::numbers::pi * (outer * outer - inner * inner) / (cell * cell);
  }
  const double covered = std::min(1.0, 1.15 * most_coverage + 0.1 + kEvenOutM / std::max(reach, 1.0));
  const double per_cell = 1.2 + 0.6 * (field.layer_count - 1.0) + 2.1 * field.crown_per_cell;
  return static_cast<std::uint32_t>(std::min(1.15 * cells * covered * per_cell + 256.0, 4e9));
}

CellSource::CellSource(Workshop& make, std::string name, const CloudSettings& clouds, const FieldGrid& grid,
                       const glm::dvec2& world_origin_m, std::uint32_t most)
    : CellSource(
          make, name, fixed_field(clouds, grid), upload(make, name + "_weather_map", map_of(clouds)),
          coverage_at_most(fixed_field(clouds, grid), map_of(clouds)),
          std::max(1u, std::min(most, capacity_for(fixed_field(clouds, grid),
                                                   coverage_at_most(fixed_field(clouds, grid), map_of(clouds))))),
          {world_origin_m, clouds.wind_m_per_s, clouds.growth_period_s,
           clouds.weather_map ? clouds.weather_map->origin_m : glm::dvec2(0.0),
           clouds.weather_map ? clouds.weather_map->extent_m : glm::dvec2(0.0)}) {}

CellSource::CellSource(Workshop& make, std::string name, const CloudField& field, const WeatherMap* map,
                       std::uint32_t capacity)
    : CellSource(make, name, field, upload(make, name + "_weather_map", map), coverage_at_most(field, map),
                 capacity > 0
                     ? capacity
                     : std::min(most_particles(make.device()), capacity_for(field, coverage_at_most(field, map))),
                 Motion{}) {}

CellSource::CellSource(Workshop& make, std::string name, const CloudField& field, const Buffer& weather_map,
                       float most_coverage, std::uint32_t capacity, const Motion& motion)
    : CloudSource(std::move(name), capacity),
      features_kernel_(make.compute(shaders::cloud_features_comp)),
      near_(make.compute(shaders::cloud_features_near_comp)),
      list_cells_(make.compute(shaders::list_cells_comp)),
      cells_(make.compute(shaders::grid_cells_comp)),
      count_cell_particles_(make.compute(shaders::count_cell_particles_comp)),
      fit_capacity_(make.compute(shaders::fit_capacity_comp)),
      drop_far_cells_(make.compute(shaders::drop_far_cells_comp)),
      assign_slots_(make.compute(shaders::assign_slots_comp)),
      particles_kernel_(make.compute(shaders::particles_comp)),
      field_(field),
      motion_(motion),
      most_coverage_(most_coverage),
      cell_count_(shared::grid_cell_count(field)),
      feature_count_(shared::feature_count(field)),
      near_count_(shared::near_count(field)),
      scan_(make, name_ + "_cells", cell_count_ + 1),
      constants_(make.buffer(name_ + "_constants", sizeof(shared::FieldConstants))),
      counters_(make.buffer(name_ + "_counters", sizeof(FieldCounters))),
      weather_map_(weather_map),
      features_(make.buffer(name_ + "_features", VkDeviceSize{feature_count_} * sizeof(shared::PackedFeature))),
      features_near_(make.buffer(name_ + "_features_near", VkDeviceSize{near_count_} * sizeof(std::uint32_t))),
      cell_list_(make.buffer(name_ + "_cell_list", VkDeviceSize{cell_count_} * sizeof(std::uint32_t))),
      cell_clouds_(make.buffer(name_ + "_cell_clouds", VkDeviceSize{cell_count_} * sizeof(shared::PackedCellCloud))),
      cell_counts_(make.buffer(name_ + "_cell_counts", VkDeviceSize{cell_count_} * sizeof(std::uint32_t))),
      cell_first_(make.buffer(name_ + "_cell_first", (VkDeviceSize{cell_count_} + 1) * sizeof(std::uint32_t))),
      distance_counts_(make.buffer(name_ + "_distance_counts", shared::kDistanceBins * sizeof(std::uint32_t))),
      particle_cell_(make.buffer(name_ + "_particle_cell", VkDeviceSize{capacity_} * sizeof(std::uint32_t))) {
  NEPHELE_CHECK(field.ring_count >= 1 && field.first_ring + field.ring_count <= shared::kMaxRings, field.ring_count,
                " rings from ", field.first_ring);
}

CloudExtent CellSource::extent() const {
  return {field_.base_m - kBelowBaseM, field_.base_m + field_.thickness_m + kAboveTallestM};
}

// The weather map stays where it is in the world while the grid's origin drifts.
FieldFrame CellSource::field_frame(const FrameView& view) const {
  FieldFrame frame{};
  frame.field = field_;
  const glm::dvec3 air_m = view.in_air(motion_.wind_m_per_s);
  shared::place_camera(frame, shared::grid_place(air_m));
  frame.field.growth_turns = growth_turns(motion_.growth_period_s, view.time_s);
  if (field_.weather.size.x > 0) {
    const double unit_m = static_cast<double>(shared::kOriginUnitM);
    const glm::dvec2 grid_origin_m = glm::round(glm::dvec2(air_m) / unit_m) * unit_m;  // as grid_place has it
    frame.field.weather =
        shared::weather_placement(field_.weather.size, motion_.map_origin_m - motion_.world_origin_m,
                                  motion_.map_extent_m, grid_origin_m + motion_.wind_m_per_s * view.time_s);
  }
  return frame;
}

// One ring, the coarsest whose cells are at most twice the size asked for: particles are about half a cell wide.
std::unique_ptr<CloudSource> CellSource::evenly(Workshop& make, const std::string& name, double reach_m,
                                                double cell_m) const {
  CloudField field = field_;
  field.ring_count = 1;
  field.first_ring = 0;
  while (field.first_ring + 1 < shared::kMaxRings && double{shared::ring_cell_m(field, field.first_ring + 1)} <= cell_m)
    ++field.first_ring;
  // Within the reach nothing fades before the view's own end does, and the ring's border lies beyond.
  const double border_m = 1.05 * reach_m / (1.0 - double{shared::kViewFade});
  const double cells = 2.0 * border_m / double{shared::ring_cell_m(field, field.first_ring)} + 2.0;
  field.ring_size_cells = 8 * static_cast<std::uint32_t>(std::ceil(cells / 8.0));
  // The centre of the coarsest window is up to two cells from the camera, which sees as far as from there.
  const double seen_m = double{field.view_distance_m} + 2.0 * cell_m;
  field.view_distance_m = static_cast<float>(std::min(seen_m, border_m));
  return std::unique_ptr<CloudSource>(
      new CellSource(make, name, field, weather_map_, most_coverage_,
                     std::min(most_particles(make.device()), capacity_for(field, most_coverage_)), motion_));
}

InputBytes CellSource::inputs(const FrameView& view) const { return as_inputs(field_frame(view), weather_map_.id()); }

void CellSource::add(FrameBuilder& frame, const FrameView& view, const ParticleSink& sink) {
  add_field(frame, field_frame(view), sink);
}

void CellSource::add_cells(FrameBuilder& frame, const ParticleSink& sink) {
  frame.compute({.name = sink.row,
                 .kernel = &features_kernel_,
                 .bindings = {{0, constants_, Access::storage_read},
                              {1, features_, Access::storage_write},
                              {2, weather_map_, Access::storage_read}},
                 .groups = {groups_for(feature_count_), 1, 1}});
  frame.compute({.name = sink.row,
                 .kernel = &near_,
                 .bindings = {{0, constants_, Access::uniform},
                              {1, features_, Access::texels},
                              {2, features_near_, Access::storage_write}},
                 .groups = {groups_for(near_count_), 1, 1}});
  frame.fill(sink.row, cell_counts_, 0);
  frame.compute({.name = sink.row,
                 .kernel = &list_cells_,
                 .bindings = {{0, constants_, Access::uniform},
                              {1, cell_list_, Access::storage_write},
                              {2, counters_, Access::storage_read_write}},
                 .groups = {groups_for(cell_count_), 1, 1}});
  frame.compute({.name = sink.row,
                 .kernel = &cells_,
                 .bindings = {{0, constants_, Access::storage_read},
                              {1, features_, Access::texels},
                              {2, cell_clouds_, Access::storage_write},
                              {3, cell_counts_, Access::storage_write},
                              {4, weather_map_, Access::storage_read},
                              {5, cell_list_, Access::storage_read},
                              {6, counters_, Access::storage_read},
                              {7, features_near_, Access::words}},
                 .indirect = {&counters_, offsetof(FieldCounters, found_cell_groups)}});
}

void CellSource::add_field(FrameBuilder& frame, const FieldFrame& field_frame, const ParticleSink& sink) {
  const CloudField& field = field_frame.field;
  NEPHELE_CHECK(field.weather.size == field_.weather.size, name_, ": a weather map of ", field.weather.size.x, "x",
                field.weather.size.y, ", the source has one of ", field_.weather.size.x, "x", field_.weather.size.y);
  NEPHELE_CHECK(shared::grid_cell_count(field) == cell_count_ && shared::feature_count(field) == feature_count_, name_,
                ": the grid changed size: ", shared::grid_cell_count(field), " cells, ", cell_count_, " expected");
  if (most_coverage_ <= 0.0f) return;
  shared::FieldConstants constants{};
  constants.frame = field_frame;
  for (std::uint32_t lattice = 0; lattice < shared::kCloudLattices; ++lattice) {
    constants.windows[lattice] = shared::feature_window(field, lattice);
    constants.near_windows[lattice] = shared::near_window(field, lattice);
  }
  constants.source = sink.source;
  constants.capacity = capacity_;
  FieldCounters start{};
  start.found_cell_groups = {0, 1, 1};
  frame.update(sink.row, constants_, as_push(constants));
  frame.update(sink.row, counters_, as_push(start));
  // The map and the counts are buffers of their own, which may have been made again.
  if (!frame.stands(&cell_clouds_, as_inputs(field, weather_map_.id(), cell_counts_.id()))) add_cells(frame, sink);
  frame.update(sink.row, distance_counts_, std::vector<std::byte>(shared::kDistanceBins * sizeof(std::uint32_t)));
  frame.compute({.name = sink.row,
                 .kernel = &count_cell_particles_,
                 .bindings = {{0, constants_, Access::uniform},
                              {1, cell_counts_, Access::storage_read},
                              {2, cell_first_, Access::storage_write},
                              {3, counters_, Access::storage_read_write},
                              {4, distance_counts_, Access::storage_read_write}},
                 .groups = {groups_for(cell_count_ + 1), 1, 1}});
  frame.compute({.name = sink.row,
                 .kernel = &fit_capacity_,
                 .bindings = {{0, constants_, Access::uniform},
                              {1, distance_counts_, Access::storage_read},
                              {2, counters_, Access::storage_write},
                              {3, sink.counters, Access::storage_read_write},
                              {4, sink.records, Access::storage_write}}});
  frame.compute({.name = sink.row,
                 .kernel = &drop_far_cells_,
                 .bindings = {{0, constants_, Access::uniform},
                              {1, counters_, Access::storage_read},
                              {2, cell_first_, Access::storage_read_write}},
                 .indirect = {&counters_, offsetof(FieldCounters, thin_groups)}});
  scan_.add(frame, sink.row, cell_first_, cell_count_ + 1, counters_, offsetof(FieldCounters, cell_particle_count));
  frame.compute({.name = sink.row,
                 .kernel = &assign_slots_,
                 .bindings = {{0, constants_, Access::uniform},
                              {1, cell_first_, Access::storage_read},
                              {2, particle_cell_, Access::storage_write},
                              {3, sink.counters, Access::storage_write},
                              {4, sink.records, Access::storage_read_write}},
                 .groups = {groups_for(cell_count_), 1, 1}});
  frame.compute({.name = sink.row,
                 .kernel = &particles_kernel_,
                 .bindings = {{0, constants_, Access::uniform},
                              {1, features_, Access::texels},
                              {2, cell_clouds_, Access::storage_read},
                              {3, cell_first_, Access::storage_read},
                              {4, particle_cell_, Access::storage_read},
                              {5, sink.records, Access::storage_read},
                              {6, sink.particles, Access::storage_write}},
                 .indirect = {&sink.records,
                              sink.source * sizeof(shared::SourceRecord) + offsetof(shared::SourceRecord, groups)}});
}

}  // namespace nephele
