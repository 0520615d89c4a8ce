#include "engine/terrain_grid.h"

#include <algorithm>
#include <cmath>

namespace nephele {

double terrain_fade_m(const Terrain& terrain) {
  return std::min(2000.0, std::min(terrain.extent_m.x, terrain.extent_m.y) / 8.0);
}

TerrainGrid terrain_grid(const Terrain& terrain) {
  const glm::dvec2 size(terrain.width, terrain.height);
  const double fade_m = terrain_fade_m(terrain);
  TerrainGrid grid;
  grid.spacing_m = terrain.extent_m / size;
  // The first vertex that is a whole fade away from the map has height 0.
  const glm::ivec2 border(glm::ceil(fade_m / grid.spacing_m + 0.5));
  grid.vertices = glm::ivec2(size) + 2 * border;
  grid.corner_m = terrain.origin_m + (0.5 - glm::dvec2(border)) * grid.spacing_m;
  grid.height_m.reserve(std::size_t(grid.vertices.x) * std::size_t(grid.vertices.y));
  const double scale_m = (double{terrain.highest_m} - terrain.lowest_m) / 65535.0;
  for (int y = 0; y < grid.vertices.y; ++y)
    for (int x = 0; x < grid.vertices.x; ++x) {
      const glm::dvec2 texel = glm::dvec2(glm::ivec2(x, y) - border);  // from the south-west one's middle
      const glm::dvec2 outside_m = glm::max(glm::max(-0.5 - texel, texel - (size - 0.5)), 0.0) * grid.spacing_m;
      const double away = std::min(glm::length(outside_m) / fade_m, 1.0);
      const glm::ivec2 inside = glm::clamp(glm::ivec2(x, y) - border, glm::ivec2(0), glm::ivec2(size) - 1);
      const std::size_t row = terrain.height - 1 - static_cast<std::uint32_t>(inside.y);
      const double height_m = terrain.lowest_m + scale_m * terrain.texels[row * terrain.width + inside.x];
      grid.height_m.push_back(static_cast<float>(height_m * (1.0 - away * away * (3.0 - 2.0 * away))));
      grid.highest_m = std::max(grid.highest_m, grid.height_m.back());
    }
  return grid;
}

glm::dvec2 terrain_slope(const TerrainGrid& grid, glm::ivec2 vertex) {
  const glm::ivec2 low = glm::max(vertex - 1, 0), high = glm::min(vertex + 1, grid.vertices - 1);
  const glm::dvec2 rise_m(double{grid.at({high.x, vertex.y})} - grid.at({low.x, vertex.y}),
                          double{grid.at({vertex.x, high.y})} - grid.at({vertex.x, low.y}));
  return rise_m / (grid.spacing_m * glm::dvec2(high - low));
}

std::vector<float> terrain_steepness(const TerrainGrid& grid) {
  constexpr int kReach = 2;
  const glm::ivec2 size = grid.vertices;
  // The mean along rows, then along columns of it.
  std::vector<double> squared;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      const glm::dvec2 slope = terrain_slope(grid, {x, y});
      squared.push_back(glm::dot(slope, slope));
    }
  const auto mean_along = [&](const std::vector<double>& values, int axis) {
    std::vector<double> means;
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const int at = axis == 0 ? x : y, last = size[axis] - 1;
        double sum = 0.0, count = 0.0;
        for (int i = std::max(at - kReach, 0); i <= std::min(at + kReach, last); ++i) {
          const int column = axis == 0 ? i : x, row = axis == 0 ? y : i;
          sum += values[std::size_t(row) * std::size_t(size.x) + std::size_t(column)];
          count += 1.0;
        }
        means.push_back(sum / count);
      }
    return means;
  };
  const std::vector<double> steepness = mean_along(mean_along(squared, 0), 1);
  return {steepness.begin(), steepness.end()};
}

double terrain_altitude_m(const TerrainGrid& grid, const glm::dvec2& place_m) {
  const glm::dvec2 at = (place_m - grid.corner_m) / grid.spacing_m;
  const glm::dvec2 cell = glm::floor(at);
  if (cell.x < 0 || cell.y < 0 || cell.x + 1 >= grid.vertices.x || cell.y + 1 >= grid.vertices.y) return 0.0;
  const glm::ivec2 corner(cell);
  const glm::dvec2 f = at - cell;
  const auto height = [&](int x, int y) { return static_cast<double>(grid.at(corner + glm::ivec2(x, y))); };
  return glm::mix(glm::mix(height(0, 0), height(1, 0), f.x), glm::mix(height(0, 1), height(1, 1), f.x), f.y);
}

}  // namespace nephele
