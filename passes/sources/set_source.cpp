#include "passes/sources/set_source.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "engine/check.h"
#include "engine/particle_set.h"
#include "nephele_shaders.h"

namespace nephele {

using shared::ListedInstance;
using shared::SetConstants;
using shared::SetKind;
using shared::SetParticleRecord;

namespace {

constexpr std::uint32_t kLocalSize = 64;
constexpr float kLevelsApart = 2.5f;  // at least, in distance, so that two levels at most show at once
constexpr std::size_t kCountedCameras = 256;
constexpr double kResolvedInCell = 0.6;
constexpr double kRoom = 1.3;  // over the particles that are expected

std::uint32_t groups_for(std::uint32_t threads) { return (threads + kLocalSize - 1) / kLocalSize; }

std::uint32_t flags_of(const ParticleSet& set) {
  const auto detail = static_cast<std::uint32_t>(std::lround(set.detail * static_cast<float>(shared::kMostSoftDetail)));
  switch (set.shape) {
    case ParticleShape::reference:
      return set.detail > 0.0f ? shared::kParticleDetail : 0u;
    case ParticleShape::homogeneous:
      return shared::kParticleHomogeneous;
    case ParticleShape::soft:
      return shared::kParticleSoft | detail << shared::kParticleSoftShift;
  }
  return 0;
}

// At least one element, which is never read where there is none.
template <class T>
const Buffer& upload(Workshop& make, const std::string& name, std::vector<T> values) {
  values.resize(std::max<std::size_t>(values.size(), 1));
  return make.uploaded(name, std::as_bytes(std::span(values)));
}

// The size of what its particles resolve: of most of them, the radius of a ball, half of that of a soft one, whose
// matter lies in its middle.
float resolved_m(const ParticleSet& set) {
  std::vector<float> radii;
  for (const SetParticle& p : set.particles) radii.push_back(shared::mean_radius_m(p.ellipsoid()));
  const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
  std::nth_element(radii.begin(), middle, radii.end());
  return set.shape == ParticleShape::soft ? 0.5f * *middle : *middle;
}

// Cells of the lattice in a unit of the world.
std::uint32_t lattice_of(const ScatteredSets& scattered) {
  const double cell_m = 1000.0 / std::sqrt(double{scattered.clouds_per_km2});
  return static_cast<std::uint32_t>(std::max(std::lround(double{shared::kOriginUnitM} / cell_m), 1L));
}

// Cells of the lattice that reach as far as the view does, wherever in its own the camera is.
void set_reach(SetConstants& constants, double view_distance_m) {
  constants.view_distance_m = static_cast<float>(view_distance_m);
  if (constants.lattice == 0) return;
  const double cell_m = double{shared::lattice_cell_m(constants.lattice)};
  constants.side = 2 * static_cast<std::uint32_t>(std::ceil(view_distance_m / cell_m)) + 2;
  constants.candidates = constants.side * constants.side;
}

// Vertical extent and reach of a set about its origin, and its mean extinction weighted by volume.
struct SetMeasure {
  float lowest_m = INFINITY, highest_m = -INFINITY, across_m = 0.0f, radius_m = 0.0f, extinction_per_m = 0.0f;
};

SetMeasure measure(const ParticleSet& set) {
  SetMeasure all;
  double matter = 0.0, volume = 0.0;
  const auto add = [&all](const ParticleSet& level) {
    for (const SetParticle& p : level.particles) {
      const float up_m = shared::ellipsoid_extent(p.ellipsoid(), {0, 0, 1});
      const float longest_m = shared::longest_axis_at_most_m(p.ellipsoid());
      all.lowest_m = std::min(all.lowest_m, std::max(p.center_m.z - up_m, p.base_m));
      all.highest_m = std::max(all.highest_m, p.center_m.z + up_m);
      all.across_m = std::max(all.across_m, glm::length(glm::vec2(p.center_m)) + longest_m);
      all.radius_m = std::max(all.radius_m, glm::length(p.center_m) + longest_m);
    }
  };
  add(set);
  for (const ParticleSet& level : set.coarser) add(level);
  for (const SetParticle& p : set.particles) {
    const double own = static_cast<double>(shared::shape_determinant(p.ellipsoid()));
    matter += own * static_cast<double>(p.extinction_per_m);
    volume += own;
  }
  all.extinction_per_m = volume > 0.0 ? static_cast<float>(matter / volume) : 0.0f;
  return all;
}

}  // namespace

// Makes a plan from a scene's source.
class SetPlanner {
 public:
  SetPlanner(float smallest_angle, const glm::dvec2& world_origin_m) : smallest_angle_(smallest_angle) {
    plan.world_origin_m = world_origin_m;
  }

  void add_kind(const ParticleSet& set, float share_below, double scale) {
    SetKind kind{};
    kind.share_below = share_below;
    const SetMeasure own = measure(set);
    kind.radius_m = own.radius_m;
    add_level(kind, set, 0.0f);
    for (const ParticleSet& level : set.coarser) {
      const float nearest_m = kind.levels > 1 ? kLevelsApart * kind.from_m[kind.levels - 1] : 0.0f;
      add_level(kind, level, std::max(resolved_m(level) / smallest_angle_, nearest_m));
    }
    measures.push_back(own);
    plan.kinds.push_back(kind);
    plan.soft = plan.soft || set.shape == ParticleShape::soft ||
                std::any_of(set.coarser.begin(), set.coarser.end(),
                            [](const ParticleSet& level) { return level.shape == ParticleShape::soft; });
    plan.extinction_per_m =
        std::max(plan.extinction_per_m, static_cast<float>(static_cast<double>(own.extinction_per_m) / scale));
  }

  void add_instance(const glm::dvec3& world_m, double heading_rad, double scale) {
    const glm::dvec3 at_m = world_m - glm::dvec3(plan.world_origin_m, 0.0);
    plan.listed.push_back({shared::split_place(at_m), static_cast<float>(std::cos(heading_rad)),
                           static_cast<float>(std::sin(heading_rad)), static_cast<float>(scale), 0u,
                           shared::hash_uint(static_cast<std::uint32_t>(plan.listed.size()))});
    places_m.push_back(at_m);
    extend(measures[0], at_m.z, scale);
    const double across_m = scale * static_cast<double>(measures[0].across_m);
    if (!plan.bounds) plan.bounds = CloudBounds{glm::dvec2(INFINITY), glm::dvec2(-INFINITY), plan.drift_m_per_s};
    plan.bounds->low_m = glm::min(plan.bounds->low_m, glm::dvec2(at_m) - across_m);
    plan.bounds->high_m = glm::max(plan.bounds->high_m, glm::dvec2(at_m) + across_m);
  }

  void extend(const SetMeasure& own, double altitude_m, double scale) {
    const auto at = [&](float own_m) { return static_cast<float>(altitude_m + scale * static_cast<double>(own_m)); };
    plan.extent = has_extent_ ? united(plan.extent, {at(own.lowest_m), at(own.highest_m)})
                              : CloudExtent{at(own.lowest_m), at(own.highest_m)};
    has_extent_ = true;
  }

  // Particles of all levels that may show of an instance at this distance.
  static double particles_at(const SetKind& kind, double distance_m) {
    double sum = 0.0;
    for (std::uint32_t level = 0; level < kind.levels; ++level) {
      const double from_m = (1.0 - double{shared::kSetLevelFade}) * double{kind.from_m[level]};
      const double to_m = level + 1 < kind.levels ? double{kind.from_m[level + 1]} : INFINITY;
      if (distance_m >= from_m && distance_m < to_m) sum += kind.count[level];
    }
    return sum;
  }

  // What a list's fullest view needs, as cameras among its instances see it.
  std::uint32_t capacity_of_list() const {
    const SetKind& kind = plan.kinds[0];
    double most = 0.0;
    const std::size_t cameras = std::min(kCountedCameras, places_m.size());
    if (cameras == places_m.size() && places_m.size() < 16)
      return static_cast<std::uint32_t>(
          std::min(1.5 * static_cast<double>(kind.count[0]) * static_cast<double>(places_m.size()), 4e9));
    for (std::size_t c = 0; c < cameras; ++c) {
      const glm::dvec3 camera_m = places_m[c * places_m.size() / cameras];
      double sum = 0.0;
      for (std::size_t i = 0; i < places_m.size(); ++i) {
        const double scale = static_cast<double>(plan.listed[i].scale);
        const double away_m = glm::length(places_m[i] - camera_m) / scale - double{kind.radius_m};
        if (away_m * scale < double{plan.constants.view_distance_m}) sum += particles_at(kind, std::max(away_m, 0.0));
      }
      most = std::max(most, sum);
    }
    return static_cast<std::uint32_t>(std::min(kRoom * most + 2.0 * kind.count[0], 4e9));
  }

  // Of a lattice: the mean over kinds in rings around the camera.
  static std::uint32_t capacity_of_lattice(const SetSource::Plan& plan) {
    double sum = 0.0, largest = 0.0;
    const double reach_m = double{plan.constants.view_distance_m}, step_m = std::max(reach_m / 2000.0, 10.0);
    const double scale = double{plan.constants.scale.y};
    for (std::size_t k = 0; k < plan.kinds.size(); ++k) {
      const SetKind& kind = plan.kinds[k];
      const double above = k + 1 < plan.kinds.size() ? double{plan.kinds[k + 1].share_below} : 1.0;
      for (double r_m = 0.5 * step_m; r_m < reach_m; r_m += step_m)
        sum += (above - double{kind.share_below}) * 6.2832e-6 * r_m * step_m * plan.places_per_km2 *
               particles_at(kind, std::max(r_m / scale - double{kind.radius_m}, 0.0));
      largest = std::max(largest, static_cast<double>(kind.count[0]));
    }
    return static_cast<std::uint32_t>(std::min(kRoom * sum + 4.0 * largest, 4e9));
  }

  SetSource::Plan plan;
  std::vector<SetMeasure> measures;
  std::vector<glm::dvec3> places_m;

 private:
  void add_level(SetKind& kind, const ParticleSet& level, float from_m) {
    kind.first[kind.levels] = static_cast<std::uint32_t>(plan.records.size());
    kind.flags[kind.levels] = flags_of(level);
    kind.count[kind.levels] = static_cast<std::uint32_t>(level.particles.size());
    kind.from_m[kind.levels] = from_m;
    ++kind.levels;
    if (kind.levels == 1) plan.level_radii_m.emplace_back();
    plan.level_radii_m.back().push_back(resolved_m(level));
    for (const SetParticle& p : level.particles)
      plan.records.push_back(
          {p.center_m, p.ellipsoid(), p.extinction_per_m, p.base_m, p.top_m, static_cast<std::uint32_t>(p.seed)});
  }

  float smallest_angle_;
  bool has_extent_ = false;
};

static_assert(kMaxCoarserLevels + 1 == shared::kMostSetLevels);

SetSource::SetSource(Workshop& make, std::string name, const PlacedSet& placed, const glm::dvec2& wind_m_per_s,
                     const glm::dvec2& world_origin_m, float smallest_angle, std::uint32_t most)
    : SetSource(
          make, std::move(name),
          [&] {
            SetPlanner planner(smallest_angle, world_origin_m);
            const Placement& at = placed.placement;
            if (at.drifts) planner.plan.drift_m_per_s = at.wind_m_per_s.value_or(wind_m_per_s);
            planner.plan.constants.view_distance_m = placed.view_distance_m;
            planner.add_kind(*placed.set.set, 0.0f, at.scale);
            const double s = std::sin(at.heading_rad), c = std::cos(at.heading_rad);
            for (const SetInstance& own :
                 placed.instances.empty() ? std::vector<SetInstance>{SetInstance{}} : placed.instances) {
              const glm::dvec3 turned_m(c * own.at_m.x + s * own.at_m.y, c * own.at_m.y - s * own.at_m.x, own.at_m.z);
              planner.add_instance(at.at_m + at.scale * turned_m, at.heading_rad + own.heading_rad,
                                   at.scale * own.scale);
            }
            planner.plan.constants.candidates = static_cast<std::uint32_t>(planner.plan.listed.size());
            planner.plan.capacity = planner.capacity_of_list();
            return std::move(planner.plan);
          }(),
          most) {}

SetSource::SetSource(Workshop& make, std::string name, const ScatteredSets& scattered, const glm::dvec2& wind_m_per_s,
                     const glm::dvec2& world_origin_m, float smallest_angle, std::uint32_t most)
    : SetSource(
          make, std::move(name),
          [&] {
            SetPlanner planner(smallest_angle, world_origin_m);
            SetSource::Plan& plan = planner.plan;
            if (scattered.drifts) plan.drift_m_per_s = scattered.wind_m_per_s.value_or(wind_m_per_s);
            double shares = 0.0, below = 0.0;
            for (const ScatteredSets::Kind& kind : scattered.kinds) shares += double{kind.share};
            for (const ScatteredSets::Kind& kind : scattered.kinds) {
              if (!(kind.share > 0.0f)) continue;
              planner.add_kind(*kind.set.set, static_cast<float>(below / shares), double{scattered.scale.x});
              below += double{kind.share};
              for (const float scale : {scattered.scale.x, scattered.scale.y})
                planner.extend(planner.measures.back(), double{scattered.altitude_m}, double{scale});
            }
            double coverage = double{scattered.coverage};
            if (const auto& map = scattered.weather_map) {
              for (const glm::u8vec2 texel : map->texels) {
                plan.weather_texels.push_back(texel.x | std::uint32_t{texel.y} << 8);
                coverage = std::max(coverage, texel.x / 255.0);
              }
              plan.map_origin_m = map->origin_m;
              plan.map_extent_m = map->extent_m;
              plan.constants.weather.size = {map->width, map->height};
            }
            plan.constants.lattice = lattice_of(scattered);
            set_reach(plan.constants, double{scattered.view_distance_m});
            plan.places_per_km2 = double{scattered.clouds_per_km2} * std::min(1.0, coverage + 0.1);
            plan.constants.seed = scattered.seed;
            plan.constants.coverage = scattered.coverage;
            plan.constants.altitude_m = scattered.altitude_m;
            plan.constants.scale = scattered.scale;
            plan.capacity = SetPlanner::capacity_of_lattice(plan);
            return std::move(plan);
          }(),
          most) {}

SetSource::SetSource(Workshop& make, std::string name, Plan plan, std::uint32_t most)
    : CloudSource(std::move(name), std::min(plan.capacity, most)),
      plan_(std::move(plan)),
      instances_kernel_(make.compute(shaders::set_instances_comp)),
      claim_(make.compute(shaders::claim_counted_slots_comp)),
      particles_kernel_(make.compute(shaders::set_particles_comp)),
      scan_(make, name_ + "_entries", 2 * plan_.constants.candidates + 1),
      records_(make.uploaded(name_ + "_records", std::as_bytes(std::span(plan_.records)))),
      kinds_(make.uploaded(name_ + "_kinds", std::as_bytes(std::span(plan_.kinds)))),
      listed_(upload(make, name_ + "_listed", plan_.listed)),
      weather_map_(upload(make, name_ + "_weather_map", plan_.weather_texels)),
      constants_(make.buffer(name_ + "_constants", sizeof(SetConstants))),
      instances_(make.buffer(name_ + "_instances",
                             VkDeviceSize{plan_.constants.candidates} * sizeof(shared::SetInstanceRecord))),
      begins_(
          make.buffer(name_ + "_begins", (2 * VkDeviceSize{plan_.constants.candidates} + 1) * sizeof(std::uint32_t))),
      total_(make.buffer(name_ + "_total", sizeof(std::uint32_t))) {
  plan_.constants.kinds = static_cast<std::uint32_t>(plan_.kinds.size());
  plan_.constants.capacity = capacity_;
}

// Of each set the coarsest level that resolves a cell.
std::unique_ptr<CloudSource> SetSource::evenly(Workshop& make, const std::string& name, double reach_m,
                                               double cell_m) const {
  Plan plan = plan_;
  for (std::size_t k = 0; k < plan.kinds.size(); ++k) {
    SetKind& kind = plan.kinds[k];
    std::uint32_t level = 0;
    while (level + 1 < kind.levels && double{plan.level_radii_m[k][level + 1]} <= kResolvedInCell * cell_m) ++level;
    kind.first[0] = kind.first[level];
    kind.count[0] = kind.count[level];
    kind.flags[0] = kind.flags[level];
    kind.levels = 1;
  }
  // Within the reach nothing fades before the view's own end does. The centre of a window is up to two cells from the
  // camera, which sees as far as from there.
  const double border_m = 1.05 * reach_m / (1.0 - double{shared::kSetViewFade});
  set_reach(plan.constants, std::min(double{plan.constants.view_distance_m} + 2.0 * cell_m, border_m));
  if (plan.constants.lattice > 0) {
    plan.capacity = SetPlanner::capacity_of_lattice(plan);
  } else {  // all instances may lie within the reach, and here all are drawn by one level
    const std::uint64_t all = std::uint64_t{plan.constants.candidates} * plan.kinds[0].count[0];
    plan.capacity = static_cast<std::uint32_t>(std::min(all, std::uint64_t{4} * plan.capacity));
  }
  return std::unique_ptr<CloudSource>(new SetSource(make, name, std::move(plan), most_particles(make.device())));
}

SetConstants SetSource::constants(const FrameView& view) const {
  SetConstants constants = plan_.constants;
  const glm::dvec3 air_m = view.in_air(plan_.drift_m_per_s);
  const shared::GridPlace place = shared::grid_place(air_m);
  constants.camera = shared::split_place(air_m);
  constants.origin_index = place.origin_index;
  constants.camera_grid_m = place.grid_m;
  if (constants.lattice > 0) {
    const glm::vec2 cell = shared::lattice_position(glm::vec2(place.grid_m), constants.lattice);
    constants.first_cell = glm::ivec2(glm::floor(cell)) - static_cast<int>(constants.side / 2);
  }
  if (constants.weather.size.x > 0) {
    const double unit_m = static_cast<double>(shared::kOriginUnitM);
    const glm::dvec2 grid_origin_m = glm::round(glm::dvec2(air_m) / unit_m) * unit_m;  // as grid_place has it
    constants.weather =
        shared::weather_placement(constants.weather.size, plan_.map_origin_m - plan_.world_origin_m, plan_.map_extent_m,
                                  grid_origin_m + plan_.drift_m_per_s * view.time_s);
  }
  return constants;
}

InputBytes SetSource::inputs(const FrameView& view) const { return as_inputs(constants(view), records_.id()); }

void SetSource::add(FrameBuilder& frame, const FrameView& view, const ParticleSink& sink) {
  struct Claim {
    std::uint32_t source, capacity;
  };
  SetConstants now = constants(view);
  now.source = sink.source;
  const std::uint32_t entries = 2 * now.candidates;
  frame.update(sink.row, constants_, as_push(now));
  frame.compute({.name = sink.row,
                 .kernel = &instances_kernel_,
                 .bindings = {{0, constants_, Access::storage_read},
                              {1, kinds_, Access::storage_read},
                              {2, listed_, Access::storage_read},
                              {3, weather_map_, Access::storage_read},
                              {4, instances_, Access::storage_write},
                              {5, begins_, Access::storage_write}},
                 .groups = {groups_for(now.candidates), 1, 1}});
  scan_.add(frame, sink.row, begins_, entries + 1, total_);
  frame.compute({.name = sink.row,
                 .kernel = &claim_,
                 .bindings = {{0, sink.counters, Access::storage_read_write},
                              {1, sink.records, Access::storage_write},
                              {2, total_, Access::storage_read}},
                 .push = as_push(Claim{sink.source, capacity_})});
  frame.compute({.name = sink.row,
                 .kernel = &particles_kernel_,
                 .bindings = {{0, constants_, Access::storage_read},
                              {1, records_, Access::storage_read},
                              {2, instances_, Access::storage_read},
                              {3, begins_, Access::storage_read},
                              {4, sink.records, Access::storage_read},
                              {5, sink.particles, Access::storage_write}},
                 .indirect = {&sink.records,
                              sink.source * sizeof(shared::SourceRecord) + offsetof(shared::SourceRecord, groups)}});
}

}  // namespace nephele
