#include "tools/clouds/grow_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "engine/check.h"
#include "tools/clouds/repeatable.h"

namespace nephele::clouds {
namespace {

double side(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

constexpr std::size_t kMaxCrossings = std::size_t{1} << 25;

// Adds a vote to the cells whose line along the axis has crossed the surface an odd number of times before them.
Result<void> vote_along(int axis, const std::vector<Triangle>& triangles, const SolidLattice& solid,
                        std::vector<std::uint8_t>& votes) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto count_u = static_cast<std::size_t>(solid.size[u]), count_v = static_cast<std::size_t>(solid.size[v]);
  std::vector<std::vector<float>> crossings(count_u * count_v);
  std::size_t count = 0;
  for (const Triangle& triangle : triangles) {
    std::array<glm::dvec2, 3> flat;
    std::array<double, 3> height;
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3 cells = (triangle[i] - solid.origin_m) / solid.cell_m - 0.5;
      flat[i] = {cells[u], cells[v]};
      height[i] = cells[axis];
    }
    const double area = side(flat[0], flat[1], flat[2]);
    if (area == 0.0) continue;  // seen from its edge
    const glm::dvec2 low = glm::min(glm::min(flat[0], flat[1]), flat[2]);
    const glm::dvec2 high = glm::max(glm::max(flat[0], flat[1]), flat[2]);
    for (int j = static_cast<int>(std::floor(low.y)); j <= static_cast<int>(std::ceil(high.y)); ++j)
      for (int i = static_cast<int>(std::floor(low.x)); i <= static_cast<int>(std::ceil(high.x)); ++i) {
        if (i < 0 || j < 0 || i >= solid.size[u] || j >= solid.size[v]) continue;
        // Off the lattice's lines by an odd share of a cell, or a line would run along edges that many meshes have
        // there and count both triangles at one.
        const glm::dvec2 line(i + 3.1e-3, j + 1.7e-3);
        const double a = side(flat[1], flat[2], line) / area, b = side(flat[2], flat[0], line) / area;
        if (a < 0.0 || b < 0.0 || a + b > 1.0) continue;
        if (++count > kMaxCrossings) return Error{"the mesh lies in too many layers over one another"};
        crossings[static_cast<std::size_t>(j) * count_u + static_cast<std::size_t>(i)].push_back(
            static_cast<float>(a * height[0] + b * height[1] + (1.0 - a - b) * height[2]));
      }
  }
  for (int j = 0; j < solid.size[v]; ++j)
    for (int i = 0; i < solid.size[u]; ++i) {
      std::vector<float>& found = crossings[static_cast<std::size_t>(j) * count_u + static_cast<std::size_t>(i)];
      std::sort(found.begin(), found.end());
      std::size_t passed = 0;
      for (int k = 0; k < solid.size[axis]; ++k) {
        while (passed < found.size() && found[passed] < static_cast<float>(k)) ++passed;
        if (passed % 2 == 0) continue;
        glm::ivec3 cell;
        cell[axis] = k;
        cell[u] = i;
        cell[v] = j;
        ++votes[solid.at(cell.x, cell.y, cell.z)];
      }
    }
  return {};
}

}  // namespace

MeshParameters::MeshParameters() {
  fill.smallest_bump_m = 56.0;
  fill.largest_bump_m = 200.0;
  fill.bump_height = 0.45;
  skin.generations = 2;
  skin.children = 22;
  skin.lowest_up = -1.0;
}

void read_mesh_parameters(JsonObject& json, MeshParameters& p) {
  json.integer("seed", p.seed);
  json.number("width_m", p.width_m, {50.0, 50000.0});
  json.choice("up", p.up, {{"y", UpAxis::y}, {"z", UpAxis::z}});
  json.boolean("flat_base", p.flat_base);
  json.number("base_share", p.base_share, {0.0, 0.9});
  json.object("fill", [&](JsonObject& fill) { read_fill(fill, p.fill); });
  json.object("skin", [&](JsonObject& skin) { read_skin(skin, p.skin); });
}

Result<SolidLattice> solid_of_triangles(const std::vector<Triangle>& triangles, double smallest_body_m) {
  glm::dvec3 low(1e30), high(-1e30);
  for (const Triangle& triangle : triangles)
    for (const glm::dvec3& corner : triangle) {
      low = glm::min(low, corner);
      high = glm::max(high, corner);
    }
  Result<SolidLattice> solid = lattice_around(low, high, smallest_body_m);
  if (!solid) return solid;
  std::vector<std::uint8_t> votes(solid->inside.size(), 0);
  for (int axis = 0; axis < 3; ++axis)
    if (auto ok = vote_along(axis, triangles, *solid, votes); !ok) return ok.error();
  for (int z = 1; z + 1 < solid->size.z; ++z)
    for (int y = 1; y + 1 < solid->size.y; ++y)
      for (int x = 1; x + 1 < solid->size.x; ++x) {
        const std::size_t cell = solid->at(x, y, z);
        solid->inside[cell] = votes[cell] >= 2;
      }
  return solid;
}

Result<ParticleSet> grow_mesh(const MeshParameters& p, const std::vector<Triangle>& triangles) {
  glm::dvec3 low(1e30), high(-1e30);
  std::vector<Triangle> upright = triangles;
  for (Triangle& triangle : upright)
    for (glm::dvec3& corner : triangle) {
      if (p.up == UpAxis::y) corner = {corner.x, -corner.z, corner.y};
      low = glm::min(low, corner);
      high = glm::max(high, corner);
    }
  const double width = std::max(high.x - low.x, high.y - low.y);
  if (!(width > 0.0)) return Error{"the mesh has no width"};
  const double scale = p.width_m / width, base = p.flat_base ? p.base_share * (high.z - low.z) : 0.0;
  for (Triangle& triangle : upright)
    for (glm::dvec3& corner : triangle) corner = (corner - low - glm::dvec3(0.0, 0.0, base)) * scale;
  Result<SolidLattice> solid = solid_of_triangles(upright, p.fill.smallest_body_m);
  if (!solid) return solid.error();
  if (p.flat_base)  // half a body is left for the base to cut
    for (int z = 0; z < solid->size.z; ++z)
      for (int y = 0; y < solid->size.y; ++y)
        for (int x = 0; x < solid->size.x; ++x)
          if (solid->middle({x, y, z}).z < -0.5 * p.fill.smallest_body_m) solid->inside[solid->at(x, y, z)] = 0;
  RandomSequence filling(p.seed, 31), growing(p.seed, 32);
  const double lowest = p.flat_base ? 0.25 * p.fill.smallest_bump_m : -1e9;
  Result<std::vector<CloudBody>> bodies = fill_solid(*solid, p.fill, lowest, filling);
  if (!bodies) return bodies.error();
  if (bodies->empty())
    return Error{
        concat("the mesh encloses nothing, or is thinner than a third of smallest_body_m, ", p.fill.smallest_body_m)};
  grow_skin(*bodies, p.skin, lowest, growing);
  Result<ParticleSet> set = set_of_bodies(std::move(*bodies), p.flat_base);
  if (!set) return set;
  set->source = "grow mesh";
  set->parameters = parameters_text([q = p](JsonObject& json) mutable { read_mesh_parameters(json, q); });
  return set;
}

}  // namespace nephele::clouds
