// Terrain as a surface: heights at the vertices of one lattice, which is the map with a border around it that leads
// down to the plain. Between four vertices the surface is bilinear. This is what the surface is; how a ray meets it is
// each reader's own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "engine/scene.h"

namespace nephele {

struct TerrainGrid {
  glm::ivec2 vertices{0};       // columns from the west, rows from the south
  glm::dvec2 corner_m{0.0};     // of vertex (0, 0), in the world
  glm::dvec2 spacing_m{0.0};    // between vertices, east and north
  float highest_m = 0.0f;       // of all vertices
  std::vector<float> height_m;  // altitudes, row by row from the south; 0 all around the border

  float at(glm::ivec2 vertex) const { return height_m[std::size_t(vertex.y) * std::size_t(vertices.x) + vertex.x]; }
};

// Slope east and north at a vertex, by central differences (one-sided at the border); metres a metre.
glm::dvec2 terrain_slope(const TerrainGrid& grid, glm::ivec2 vertex);

// How steep the land about each vertex is, which decides what it is made of: the mean of the squared slope over the
// 5 x 5 vertices there (fewer at the border), so that a crest counts as what its flanks are.
std::vector<float> terrain_steepness(const TerrainGrid& grid);

// Beyond the map the heights of the outermost texels go on times 1 - smoothstep(0, this, distance to the map).
// 2 km; an eighth of the map's smaller extent, if that is less.
double terrain_fade_m(const Terrain& terrain);

// The terrain must be one that check_terrain accepts.
TerrainGrid terrain_grid(const Terrain& terrain);

// Altitude of the surface at a place of the world; 0 beyond the lattice.
double terrain_altitude_m(const TerrainGrid& grid, const glm::dvec2& place_m);

}  // namespace nephele
