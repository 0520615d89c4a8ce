#include "tools/clouds/cloud_skin.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "engine/accepted.h"

namespace nephele::clouds {
namespace {

constexpr double kFarthest = 2.0;  // of BodyIndex::nearest

double largest(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

// A body's children stand closer on one flank than on another, which keeps the surface from looking even.
double liveliness(const glm::dvec3& direction, const glm::dvec3& lively) {
  return 0.55 + 0.45 * glm::dot(direction, lively);
}

}  // namespace

void read_skin(JsonObject& json, SkinParameters& skin) {
  json.integer("generations", skin.generations, 0, 4);
  json.integer("children", skin.children, 0, 64);
  json.number("smallest_share", skin.smallest_share, {0.1, 0.9});
  json.number("largest_share", skin.largest_share, {0.1, 0.9});
  if (skin.largest_share < skin.smallest_share && json.has("largest_share"))
    json.refuse("largest_share", "smallest_share or more");
  else if (skin.largest_share < skin.smallest_share && json.has("smallest_share"))
    json.refuse("smallest_share", "largest_share or less");
  json.number("place", skin.place, {0.3, 1.0});
  json.number("lowest_up", skin.lowest_up, {-1.0, 0.9});
  json.number("smallest_m", skin.smallest_m, {1.0, 1000.0});
  json.number("extinction_per_m", skin.extinction_per_m, {1e-4, 10.0});
}

std::uint64_t BodyIndex::key(const glm::ivec3& cell) {
  const auto part = [](int value) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(value) & 0x1fffffu); };
  return part(cell.x) | part(cell.y) << 21 | part(cell.z) << 42;
}

glm::ivec3 BodyIndex::cell_of(const glm::dvec3& place_m) const { return glm::ivec3(glm::floor(place_m / cell_m_)); }

void BodyIndex::add(const CloudBody& body, std::size_t number) {
  const auto entry = static_cast<std::uint32_t>(entries_.size());
  entries_.push_back({body, number});
  const glm::ivec3 low = cell_of(body.center_m - kFarthest * body.radius_m);
  const glm::ivec3 high = cell_of(body.center_m + kFarthest * body.radius_m);
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x) cells_[key({x, y, z})].push_back(entry);
}

double BodyIndex::nearest(const glm::dvec3& place_m, std::size_t left_out) const {
  double best = kFarthest * kFarthest;
  const auto cell = cells_.find(key(cell_of(place_m)));
  if (cell == cells_.end()) return kFarthest;
  for (const std::uint32_t entry : cell->second) {
    if (entries_[entry].number == left_out) continue;
    const CloudBody& body = entries_[entry].body;
    const glm::dvec3 offset = (place_m - body.center_m) / body.radius_m;
    best = std::min(best, glm::dot(offset, offset));
  }
  return std::sqrt(best);
}

void grow_skin(std::vector<CloudBody>& bodies, const SkinParameters& skin, double floor_m, RandomSequence& random) {
  if (bodies.empty()) return;
  constexpr double kHidden = 0.88;   // inside another body by this share of its radii
  constexpr double kCrowded = 0.62;  // so near to a child that stands already
  double mean_radius = 0.0, largest_radius = 0.0;
  for (const CloudBody& body : bodies) {
    mean_radius += largest(body.radius_m);
    largest_radius = std::max(largest_radius, largest(body.radius_m));
  }
  // A large body reaches into many cells: not into more than 17^3.
  BodyIndex older(std::max(2.0 * mean_radius / static_cast<double>(bodies.size()), 0.25 * largest_radius));
  for (std::size_t i = 0; i < bodies.size(); ++i) older.add(bodies[i], i);

  std::size_t first = 0;
  double tried = skin.children;
  for (std::uint32_t generation = 0; generation < skin.generations; ++generation, tried *= 0.55) {
    const std::size_t parents_end = bodies.size();
    BodyIndex young(std::max(
        {skin.smallest_m, 0.5 * mean_radius / static_cast<double>(parents_end - first), 0.25 * largest_radius}));
    mean_radius = largest_radius = 0.0;
    for (std::size_t parent = first; parent < parents_end; ++parent) {
      const CloudBody body = bodies[parent];
      const double radius = std::min({body.radius_m.x, body.radius_m.y, body.radius_m.z});
      const glm::dvec3 lively = random.direction(-0.3, 1.0);
      const double smallest = std::max(skin.smallest_share * radius, skin.smallest_m);
      const double biggest = skin.largest_share * radius;
      if (smallest > biggest) continue;
      const int places = static_cast<int>(tried * random.between(0.7, 1.3) + 0.5);
      for (int i = 0; i < places && bodies.size() < kMaxGrownBodies; ++i) {
        const glm::dvec3 direction = random.direction(skin.lowest_up, 1.0);
        const double size = random.size(smallest, biggest);
        const double kept = random.unit(), flat = random.between(0.85, 1.0), wide = random.between(0.9, 1.15);
        if (kept > liveliness(direction, lively) + 0.25) continue;
        const glm::dvec3 center =
            body.center_m + direction * body.radius_m * (skin.place * (1.1 - 0.4 * size / radius));
        if (center.z < floor_m || older.nearest(center, parent) < kHidden || young.nearest(center) < kCrowded) continue;
        const CloudBody child{center, {size * wide, size / wide, size * flat}, skin.extinction_per_m};
        young.add(child, bodies.size());
        bodies.push_back(child);
        mean_radius += size;
        largest_radius = std::max(largest_radius, size);
      }
    }
    if (bodies.size() == parents_end) return;
    for (std::size_t i = parents_end; i < bodies.size(); ++i) older.add(bodies[i], i);
    first = parents_end;
  }
}

void keep_connected(std::vector<CloudBody>& bodies) {
  std::vector<std::size_t> group(bodies.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  const auto head = [&](std::size_t i) {
    while (group[i] != i) i = group[i] = group[group[i]];
    return i;
  };
  // Sorted by x, so that only bodies which overlap there are compared.
  std::vector<std::size_t> order(bodies.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto left = [&](std::size_t i) { return bodies[i].center_m.x - bodies[i].radius_m.x; };
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return std::pair(left(a), a) < std::pair(left(b), b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const CloudBody& a = bodies[order[i]];
    for (std::size_t j = i + 1; j < order.size() && left(order[j]) < a.center_m.x + a.radius_m.x; ++j) {
      const CloudBody& b = bodies[order[j]];
      const glm::dvec3 offset = (a.center_m - b.center_m) / (a.radius_m + b.radius_m);
      if (glm::dot(offset, offset) < 0.81) group[head(order[i])] = head(order[j]);
    }
  }
  std::vector<double> volume(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i)
    volume[head(i)] += bodies[i].radius_m.x * bodies[i].radius_m.y * bodies[i].radius_m.z;
  const auto chosen = static_cast<std::size_t>(std::max_element(volume.begin(), volume.end()) - volume.begin());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (head(i) == chosen) bodies[kept++] = bodies[i];
  bodies.resize(kept);
}

Result<ParticleSet> set_of_bodies(std::vector<CloudBody> bodies, bool flat_base) {
  const auto empty = [](const CloudBody& body) { return body.center_m.z + 0.9 * body.radius_m.z <= 0.0; };
  if (flat_base) bodies.erase(std::remove_if(bodies.begin(), bodies.end(), empty), bodies.end());
  if (bodies.empty()) return Error{"the parameters leave no cloud: not one body stands above its base"};
  glm::dvec3 low(1e30), high(-1e30);
  for (const CloudBody& body : bodies) {
    low = glm::min(low, body.center_m - body.radius_m);
    high = glm::max(high, body.center_m + body.radius_m);
  }
  const glm::dvec3 origin(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), flat_base ? 0.0 : low.z);
  ParticleSet set;
  set.top_m = static_cast<float>(high.z - origin.z);
  set.detail = 1.0f;
  for (const CloudBody& body : bodies)
    set.particles.push_back({.center_m = glm::vec3(body.center_m - origin),
                             .diagonal_m = glm::vec3(body.radius_m),
                             .extinction_per_m = static_cast<float>(body.extinction_per_m)});
  give_particles_base_and_top(set);
  return set;
}

}  // namespace nephele::clouds
