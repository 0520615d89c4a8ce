// Fills a shape with bodies: large ones inside, small ones at its surface, placed by chance so that no lattice shows,
// and bumps across the surface for a skin to grow on. The shape is a lattice of small cells, each inside or outside.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/json_reader.h"
#include "engine/result.h"
#include "tools/clouds/cloud_skin.h"
#include "tools/clouds/repeatable.h"

namespace nephele::clouds {

// Cells' middles stand at origin + (index + 1/2) * cell. The outermost cells are outside.
struct SolidLattice {
  glm::ivec3 size{0};
  glm::dvec3 origin_m{0.0};
  double cell_m = 1.0;
  std::vector<std::uint8_t> inside;  // x fastest

  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size.x) +
           static_cast<std::size_t>(x);
  }
  glm::dvec3 middle(const glm::ivec3& cell) const { return origin_m + (glm::dvec3(cell) + 0.5) * cell_m; }
};
inline constexpr std::size_t kMaxSolidCells = std::size_t{1} << 22;

// A lattice that holds the box with a margin of two cells, all outside. Too many cells: an error that names
// smallest_body_m, of which a cell is a third.
Result<SolidLattice> lattice_around(const glm::dvec3& low_m, const glm::dvec3& high_m, double smallest_body_m);

struct FillParameters {
  double smallest_body_m = 60.0;  // radii
  double largest_body_m = 240.0;
  double smallest_bump_m = 55.0;
  double largest_bump_m = 200.0;
  double bump_height = 0.75;  // how much of its radius a bump stands out of the surface
  double extinction_per_m = 0.05;
};
void read_fill(JsonObject& json, FillParameters& fill);

// Distances from the cells' middles to the surface, which lies half a cell from the nearest cell outside; 0 outside.
std::vector<float> depths_m(const SolidLattice& solid);

// Bodies and bumps that cover the shape. A body stands out of it by at most its smallest radius, a bump by at most
// bump_height of its own radius, each give or take a cell.
// lowest_bump_m: no bump's centre is below.
Result<std::vector<CloudBody>> fill_solid(const SolidLattice& solid, const FillParameters& fill, double lowest_bump_m,
                                          RandomSequence& random);

}  // namespace nephele::clouds
