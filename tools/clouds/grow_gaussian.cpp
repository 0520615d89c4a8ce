#include "tools/clouds/grow_gaussian.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "tools/clouds/repeatable.h"

namespace nephele::clouds {
namespace {

struct Bell {
  glm::dvec2 center_m, sigma_m;
  double weight;
};

// Joined like independent chances: never above 1, and smooth where two meet.
class Bells {
 public:
  Bells(const GaussianParameters& p, RandomSequence& random) {
    const glm::dvec2 sigma = glm::dvec2(p.width_m, p.depth_m) / 3.2;
    bells_.push_back({glm::dvec2(0.0), sigma * (1.0 - 0.3 * p.asymmetry), 1.0});
    const int others = p.asymmetry > 0.0 ? 2 + static_cast<int>(random.index(3)) : 0;
    for (int i = 0; i < others; ++i) {
      const glm::dvec2 way(random.direction(0.0, 0.0));
      const double size = random.between(0.4, 0.75), far = random.between(0.8, 1.6);
      bells_.push_back({way * sigma * (far * p.asymmetry), sigma * size, random.between(0.5, 1.0) * p.asymmetry});
    }
    // The highest place counts 1.
    for (const Bell& bell : bells_) highest_ = std::max(highest_, sum_at(bell.center_m));
  }

  double at(const glm::dvec2& place_m) const { return std::min(1.0, sum_at(place_m) / highest_); }
  const std::vector<Bell>& all() const { return bells_; }

 private:
  double sum_at(const glm::dvec2& place_m) const {
    double left = 1.0;
    for (const Bell& bell : bells_) {
      const glm::dvec2 q = (place_m - bell.center_m) / bell.sigma_m;
      left *= 1.0 - 0.999 * bell.weight * falling_exponential(0.5 * glm::dot(q, q));
    }
    return 1.0 - left;
  }
  std::vector<Bell> bells_;
  double highest_ = 0.0;
};

// Flat bodies on a hexagonal lattice whose places are shaken, where the bell is high enough. Their lower parts lie
// under the base, which cuts them.
void add_bed(const GaussianParameters& p, const Bells& bells, RandomSequence& random, std::vector<CloudBody>& bodies) {
  const double spacing = std::min(p.width_m, p.depth_m) / 9.0;
  const int columns = static_cast<int>(p.width_m / spacing) + 2;
  const int rows = static_cast<int>(p.depth_m / (0.87 * spacing)) + 2;
  for (int j = -rows; j <= rows; ++j)
    for (int i = -columns; i <= columns; ++i) {
      glm::dvec2 place((i + 0.5 * (j & 1)) * spacing, j * 0.87 * spacing);
      place += spacing * glm::dvec2(random.between(-0.28, 0.28), random.between(-0.28, 0.28));
      const double ragged = random.between(-0.07, 0.07), size = random.between(0.75, 1.15), bell = bells.at(place);
      const double above = (bell + ragged - 0.26) / 0.5;
      if (above < 0.0) continue;
      const double radius = spacing * size * std::min(1.05, 0.62 + 0.5 * above);
      const double up = radius * random.between(0.6, 0.75);
      bodies.push_back({{place, 0.5 * up}, {radius, radius, up}, p.extinction_per_m});
    }
}

// Bodies on top of one another from the base to the top, thinner and leaning as they rise.
void add_tower(const GaussianParameters& p, const glm::dvec2& place, double radius, double top_m,
               const glm::dvec2& lean, RandomSequence& random, std::vector<CloudBody>& bodies) {
  double z = 0.6 * radius;
  glm::dvec2 wander(0.0);
  for (int level = 0; level < 40; ++level) {
    const double share = std::min(1.0, z / std::max(top_m, 1.0));
    const double r = radius * (1.2 - 0.42 * share) * random.between(0.78, 1.12);
    bodies.push_back({{place + lean * z + wander, z},
                      {r, r * random.between(0.9, 1.1), r * random.between(0.85, 1.0)},
                      p.extinction_per_m});
    // A shoulder: without it the tower is a column.
    const glm::dvec2 aside(random.direction(0.0, 0.0));
    const double size = r * random.between(0.45, 0.8), lower = random.between(0.0, 0.6);
    if (z > 0.7 * r && z + size < top_m)
      bodies.push_back({{place + lean * z + wander + aside * (0.85 * r), z - lower * r},
                        {size, size, size * 0.9},
                        p.extinction_per_m});
    wander += radius * 0.25 * glm::dvec2(random.between(-1.0, 1.0), random.between(-1.0, 1.0));
    if (z + r >= top_m) return;
    z = std::min(z + 0.8 * r, std::max(top_m - 0.8 * r, z + 0.3 * r));
  }
}

void add_towers(const GaussianParameters& p, const Bells& bells, RandomSequence& random,
                std::vector<CloudBody>& bodies) {
  const SineCosine slope = sine_cosine(p.lean_deg * kRadiansPerDegree);
  const glm::dvec2 lean = glm::dvec2(random.direction(0.0, 0.0)) * (slope.sine / slope.cosine);
  std::vector<std::pair<glm::dvec2, double>> placed;
  for (std::uint32_t tower = 0; tower < p.towers; ++tower) {
    for (int attempt = 0; attempt < 12; ++attempt) {
      const Bell& bell =
          tower == 0 ? bells.all()[0] : bells.all()[random.index(static_cast<std::uint32_t>(bells.all().size()))];
      const double spread = tower == 0 ? 0.15 : 0.85;
      const glm::dvec2 place = bell.center_m + spread * bell.sigma_m * glm::dvec2(random.normal(), random.normal());
      const double height = bells.at(place);
      const double size = tower == 0
                              ? p.largest_tower_m
                              : random.size(p.smallest_tower_m, p.largest_tower_m) * std::min(1.0, 0.55 + 0.6 * height);
      const double reach = tower == 0 ? 1.0 : random.between(0.5, 1.0);
      const double leaning = random.between(0.3, 1.4);
      if (height < 0.3) continue;
      const bool crowded = std::any_of(placed.begin(), placed.end(), [&](const auto& other) {
        return glm::length(other.first - place) < 0.55 * (other.second + size);
      });
      if (crowded) continue;
      placed.emplace_back(place, size);
      // A thin tower does not rise as high as a thick one.
      const double top = std::min(p.height_m * height * reach, size * 3.2);
      add_tower(p, place, size, top, lean * leaning, random, bodies);
      break;
    }
  }
}

}  // namespace

void read_gaussian(JsonObject& json, GaussianParameters& p) {
  json.integer("seed", p.seed);
  json.number("width_m", p.width_m, {200.0, 20000.0});
  json.number("depth_m", p.depth_m, {200.0, 20000.0});
  json.number("height_m", p.height_m, {50.0, 15000.0});
  json.integer("towers", p.towers, 0, 500);
  json.number("smallest_tower_m", p.smallest_tower_m, {20.0, 3000.0});
  json.number("largest_tower_m", p.largest_tower_m, {20.0, 3000.0});
  if (p.largest_tower_m < p.smallest_tower_m)
    json.fail(json.has("largest_tower_m") ? "largest_tower_m" : "smallest_tower_m",
              "does not fit: smallest_tower_m is above largest_tower_m");
  json.number("lean_deg", p.lean_deg, {0.0, 60.0});
  json.number("asymmetry", p.asymmetry, {0.0, 1.0});
  json.number("extinction_per_m", p.extinction_per_m, {1e-4, 10.0});
  json.object("skin", [&](JsonObject& skin) { read_skin(skin, p.skin); });
}

Result<ParticleSet> grow_gaussian(const GaussianParameters& parameters) {
  RandomSequence shape(parameters.seed, 1), bed(parameters.seed, 2), towers(parameters.seed, 3),
      skin(parameters.seed, 4);
  const Bells bells(parameters, shape);
  std::vector<CloudBody> bodies;
  add_bed(parameters, bells, bed, bodies);
  add_towers(parameters, bells, towers, bodies);
  keep_connected(bodies);
  grow_skin(bodies, parameters.skin, 0.25 * parameters.skin.smallest_m, skin);
  Result<ParticleSet> set = set_of_bodies(std::move(bodies), true);
  if (!set) return set;
  set->source = "grow gaussian";
  set->parameters = parameters_text([p = parameters](JsonObject& json) mutable { read_gaussian(json, p); });
  return set;
}

}  // namespace nephele::clouds
