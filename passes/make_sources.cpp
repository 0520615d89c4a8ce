// The one place that names the kinds of sources.
#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <variant>

#include "passes/kit/cloud_source.h"
#include "passes/nephele.h"
#include "passes/sources/cell_source.h"
#include "passes/sources/listed_source.h"
#include "passes/sources/set_source.h"

namespace nephele {
namespace {

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

FieldGrid field_grid(const RenderSettings& settings) {
  const Preset of_quality = preset(settings.quality);
  return {settings.ring_size_cells > 0 ? settings.ring_size_cells : of_quality.ring_size_cells,
          settings.layer_count > 0 ? settings.layer_count : of_quality.layer_count,
          static_cast<float>(of_quality.crown_per_cell * settings.crown_factor)};
}

class Maker {
 public:
  Maker(Workshop& make, const Scene& scene, const RenderSettings& settings)
      : make_(make), scene_(scene), settings_(settings), room_(most_particles(make.device())) {}

  void add(const CloudSettings& clouds) {
    if (clouds.coverage <= 0.0f && !clouds.weather_map) return;
    keep(std::make_unique<CellSource>(make_, unused("field"), clouds, field_grid(settings_), scene_.world_origin_m,
                                      room_));
  }
  void add(const ParticleGroup& group) {
    if (group.particles.empty()) return;
    keep(std::make_unique<ListedSource>(make_, unused("particles"), group, scene_wind_m_per_s(scene_),
                                        scene_.world_origin_m, room_));
  }
  void add(const PlacedSet& placed) {
    if (placed.set.set) add_sets("set", placed);
  }
  void add(const ScatteredSets& scattered) {
    if (!scattered.kinds.empty() && (scattered.coverage > 0.0f || scattered.weather_map))
      add_sets("scatter", scattered);
  }
  std::vector<std::unique_ptr<CloudSource>> made() { return std::move(made_); }

 private:
  // A coarser level's particles are about as small to the eye as those of the field's rings, which are half a cell
  // wide.
  template <class Sets>
  void add_sets(const char* kind, const Sets& sets) {
    const float smallest_angle = 1.7f / static_cast<float>(field_grid(settings_).ring_size_cells);
    keep(std::make_unique<SetSource>(make_, unused(kind), sets, scene_wind_m_per_s(scene_), scene_.world_origin_m,
                                     smallest_angle, room_));
  }
  // "field", "field_2", ...
  std::string unused(const std::string& kind) {
    const int number = ++numbers_[kind];
    return number == 1 ? kind : kind + '_' + std::to_string(number);
  }
  void keep(std::unique_ptr<CloudSource> source) {
    room_ -= std::min(room_, source->capacity());
    made_.push_back(std::move(source));
  }

  Workshop& make_;
  const Scene& scene_;
  const RenderSettings& settings_;
  std::uint32_t room_;  // for particles of further sources
  std::map<std::string, int> numbers_;
  std::vector<std::unique_ptr<CloudSource>> made_;
};

}  // namespace

std::vector<std::unique_ptr<CloudSource>> make_sources(Workshop& make, const Scene& scene,
                                                       const RenderSettings& settings) {
  Maker maker(make, scene, settings);
  maker.add(ParticleGroup{.particles = scene.particles});
  if (scene.clouds) maker.add(*scene.clouds);
  for (const SceneSource& source : scene.sources) std::visit([&](const auto& kind) { maker.add(kind); }, source);
  return maker.made();
}

double view_distance_m(const Scene& scene) {
  std::optional<float> farthest_m;
  const auto reach = [&farthest_m](float distance_m) {
    farthest_m = std::max(farthest_m.value_or(distance_m), distance_m);
  };
  for (const CloudSettings* field : cloud_fields(scene)) reach(field->view_distance_m);
  for (const SceneSource& source : scene.sources)
    if (const auto* scattered = std::get_if<ScatteredSets>(&source)) reach(scattered->view_distance_m);
  return double{farthest_m.value_or(CloudSettings{}.view_distance_m)};
}

glm::dvec2 scene_wind_m_per_s(const Scene& scene) {
  const std::vector<const CloudSettings*> fields = cloud_fields(scene);
  return fields.empty() ? glm::dvec2(0.0) : fields.front()->wind_m_per_s;
}

}  // namespace nephele
