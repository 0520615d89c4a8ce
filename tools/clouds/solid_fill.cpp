#include "tools/clouds/solid_fill.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/check.h"

namespace nephele::clouds {
namespace {

constexpr float kFar = 1e12f;

// Squared distances along one line from those of its cells: the lower envelope of parabolas [Felzenszwalb and
// Huttenlocher 2012].
void distances_along_line(std::vector<float>& line, std::vector<float>& result, std::vector<int>& vertex,
                          std::vector<float>& border) {
  const int count = static_cast<int>(line.size());
  const auto f = [&](int i) { return line[static_cast<std::size_t>(i)]; };
  int last = 0;
  vertex[0] = 0;
  border[0] = -std::numeric_limits<float>::infinity();
  border[1] = std::numeric_limits<float>::infinity();
  for (int q = 1; q < count; ++q) {
    float crossing;
    for (;;) {
      const int v = vertex[static_cast<std::size_t>(last)];
      crossing = ((f(q) - f(v)) / static_cast<float>(q - v) + static_cast<float>(q + v)) * 0.5f;
      if (crossing > border[static_cast<std::size_t>(last)] || last == 0) break;
      --last;
    }
    if (crossing > border[static_cast<std::size_t>(last)]) ++last;
    vertex[static_cast<std::size_t>(last)] = q;
    border[static_cast<std::size_t>(last)] = last == 0 ? -std::numeric_limits<float>::infinity() : crossing;
    border[static_cast<std::size_t>(last) + 1] = std::numeric_limits<float>::infinity();
  }
  for (int q = 0, k = 0; q < count; ++q) {
    while (border[static_cast<std::size_t>(k) + 1] < static_cast<float>(q)) ++k;
    const int v = vertex[static_cast<std::size_t>(k)];
    result[static_cast<std::size_t>(q)] = static_cast<float>((q - v) * (q - v)) + f(v);
  }
}

struct Place {
  glm::dvec3 at_m;
  double depth_m;
};

glm::dvec3 shaken(const SolidLattice& solid, const glm::ivec3& cell, RandomSequence& random) {
  const double x = random.between(-0.45, 0.45), y = random.between(-0.45, 0.45), z = random.between(-0.45, 0.45);
  return solid.middle(cell) + solid.cell_m * glm::dvec3(x, y, z);
}

template <class Take>
void for_each_inside(const SolidLattice& solid, Take&& take) {
  for (int z = 1; z + 1 < solid.size.z; ++z)
    for (int y = 1; y + 1 < solid.size.y; ++y)
      for (int x = 1; x + 1 < solid.size.x; ++x)
        if (solid.inside[solid.at(x, y, z)]) take(glm::ivec3(x, y, z));
}

// Out of the shape: away from the middle of what is inside around the cell.
glm::dvec3 outward(const SolidLattice& solid, const glm::ivec3& cell) {
  constexpr int kReach = 2;
  glm::dvec3 sum(0.0);
  for (int z = -kReach; z <= kReach; ++z)
    for (int y = -kReach; y <= kReach; ++y)
      for (int x = -kReach; x <= kReach; ++x) {
        const glm::ivec3 c = cell + glm::ivec3(x, y, z);
        if (glm::any(glm::lessThan(c, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(c, solid.size))) continue;
        if (solid.inside[solid.at(c.x, c.y, c.z)]) sum -= glm::dvec3(x, y, z);
      }
  const double length = glm::length(sum);
  return length > 0.0 ? sum / length : glm::dvec3(0.0, 0.0, 1.0);
}

// Between the two with a density that falls with the square: more large ones than elsewhere, for on a smooth surface
// they alone break its evenness.
double bump_size(const FillParameters& fill, RandomSequence& random) {
  return fill.smallest_bump_m / (1.0 - random.unit() * (1.0 - fill.smallest_bump_m / fill.largest_bump_m));
}

Error too_many(const FillParameters& fill) {
  return {concat("smallest_body_m is ", fill.smallest_body_m, "; with it the shape takes more than ", kMaxGrownBodies,
                 " bodies")};
}

}  // namespace

void read_fill(JsonObject& json, FillParameters& fill) {
  json.number("smallest_body_m", fill.smallest_body_m, {1.0, 2000.0});
  json.number("largest_body_m", fill.largest_body_m, {1.0, 5000.0});
  json.number("smallest_bump_m", fill.smallest_bump_m, {1.0, 2000.0});
  json.number("largest_bump_m", fill.largest_bump_m, {1.0, 5000.0});
  json.number("bump_height", fill.bump_height, {0.0, 1.0});
  json.number("extinction_per_m", fill.extinction_per_m, {1e-4, 10.0});
  if (fill.largest_body_m < fill.smallest_body_m)
    json.fail(json.has("smallest_body_m") ? "smallest_body_m" : "largest_body_m",
              "does not fit: smallest_body_m is above largest_body_m");
  if (fill.largest_bump_m < fill.smallest_bump_m)
    json.fail(json.has("smallest_bump_m") ? "smallest_bump_m" : "largest_bump_m",
              "does not fit: smallest_bump_m is above largest_bump_m");
}

Result<SolidLattice> lattice_around(const glm::dvec3& low_m, const glm::dvec3& high_m, double smallest_body_m) {
  SolidLattice solid;
  solid.cell_m = smallest_body_m / 3.0;
  solid.origin_m = low_m - 2.0 * solid.cell_m;
  const glm::dvec3 cells = glm::ceil((high_m - low_m) / solid.cell_m) + 4.0;
  if (!(cells.x * cells.y * cells.z <= static_cast<double>(kMaxSolidCells)))
    return Error{concat("smallest_body_m is ", smallest_body_m, "; the shape has ", cells.x * cells.y * cells.z,
                        " cells of a third of it; accepted: at most ", kMaxSolidCells)};
  solid.size = glm::ivec3(cells);
  solid.inside.assign(static_cast<std::size_t>(cells.x * cells.y * cells.z), 0);
  return solid;
}

std::vector<float> depths_m(const SolidLattice& solid) {
  std::vector<float> square(solid.inside.size());
  for (std::size_t i = 0; i < square.size(); ++i) square[i] = solid.inside[i] ? kFar : 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    const int count = solid.size[axis], u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::vector<float> line(static_cast<std::size_t>(count)), result(line);
    std::vector<int> vertex(static_cast<std::size_t>(count) + 1);
    std::vector<float> border(static_cast<std::size_t>(count) + 2);
    for (int j = 0; j < solid.size[v]; ++j)
      for (int i = 0; i < solid.size[u]; ++i) {
        glm::ivec3 cell(0);
        cell[u] = i;
        cell[v] = j;
        const std::size_t first = solid.at(cell.x, cell.y, cell.z);
        cell[axis] = 1;
        const std::size_t stride = solid.at(cell.x, cell.y, cell.z) - first;
        for (std::size_t k = 0; k < line.size(); ++k) line[k] = square[first + k * stride];
        distances_along_line(line, result, vertex, border);
        for (std::size_t k = 0; k < line.size(); ++k) square[first + k * stride] = result[k];
      }
  }
  const float cell_m = static_cast<float>(solid.cell_m);
  for (float& value : square) value = value > 0.0f ? (std::sqrt(value) - 0.5f) * cell_m : 0.0f;
  return square;
}

Result<std::vector<CloudBody>> fill_solid(const SolidLattice& solid, const FillParameters& fill, double lowest_bump_m,
                                          RandomSequence& random) {
  constexpr double kCovered = 0.82;  // so near to a body's centre a place needs none of its own
  constexpr double kCrowded = 0.95;  // and a bump has no room
  const std::vector<float> depth = depths_m(solid);
  std::vector<Place> places;
  std::vector<glm::ivec3> surface;
  for_each_inside(solid, [&](const glm::ivec3& cell) {
    const double here = depth[solid.at(cell.x, cell.y, cell.z)];
    places.push_back({shaken(solid, cell, random), here});
    if (here < solid.cell_m) surface.push_back(cell);
  });
  // The deepest first: large bodies take their room before small ones fill what is left. What chance adds keeps those
  // of one depth from standing in rows.
  for (Place& place : places) place.depth_m *= random.between(0.75, 1.0);
  std::vector<std::size_t> order(places.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(-places[a].depth_m, a) < std::pair(-places[b].depth_m, b);
  });
  std::vector<CloudBody> bodies;
  BodyIndex filled(std::max({2.0 * fill.smallest_body_m, 0.25 * fill.largest_body_m, 0.25 * fill.largest_bump_m}));
  const auto fill_place = [&](const Place& place) {
    if (filled.nearest(place.at_m) < kCovered) return;
    const double radius =
        std::clamp(place.depth_m + 0.5 * fill.smallest_body_m, fill.smallest_body_m, fill.largest_body_m);
    bodies.push_back({place.at_m, glm::dvec3(radius), fill.extinction_per_m});
    filled.add(bodies.back(), bodies.size());
  };
  std::size_t next = 0;
  for (; next < order.size() && places[order[next]].depth_m > fill.smallest_body_m; ++next) {
    fill_place(places[order[next]]);
    if (bodies.size() >= kMaxGrownBodies) return too_many(fill);
  }

  // Bumps: surface cells in random order, each with room around it.
  for (std::size_t i = surface.size(); i > 1; --i)
    std::swap(surface[i - 1], surface[random.index(static_cast<std::uint32_t>(i))]);
  BodyIndex bumps(std::max(2.0 * fill.smallest_bump_m, 0.25 * fill.largest_bump_m));
  for (const glm::ivec3& cell : surface) {
    const glm::dvec3 place = shaken(solid, cell, random);
    double radius = bump_size(fill, random);
    const double flat = random.between(0.9, 1.0);
    if (place.z < lowest_bump_m || bumps.nearest(place) < kCrowded) continue;
    const glm::dvec3 out = outward(solid, cell);
    // Where the shape is thin a bump as large as its thickness would hide it.
    const auto depth_at = [&](const glm::dvec3& p) {
      const glm::ivec3 c(glm::floor((p - solid.origin_m) / solid.cell_m));
      if (glm::any(glm::lessThan(c, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(c, solid.size))) return 0.0;
      return static_cast<double>(depth[solid.at(c.x, c.y, c.z)]);
    };
    while (radius > fill.smallest_bump_m && depth_at(place - out * radius) < 0.6 * radius) radius *= 0.8;
    radius = std::max(radius, fill.smallest_bump_m);
    if (bodies.size() == kMaxGrownBodies) return too_many(fill);
    const glm::dvec3 center = place - out * (radius * (1.0 - fill.bump_height));
    if (center.z < lowest_bump_m) continue;
    bodies.push_back({center, {radius, radius, radius * flat}, fill.extinction_per_m});
    bumps.add({place, glm::dvec3(radius), 0.0}, bodies.size());
    filled.add(bodies.back(), bodies.size());
  }

  // What bodies and bumps have left open.
  for (; next < order.size(); ++next) {
    fill_place(places[order[next]]);
    if (bodies.size() >= kMaxGrownBodies) return too_many(fill);
  }
  return bodies;
}

}  // namespace nephele::clouds
