#include "tools/path_tracer/terrain_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shared/prelude.h"

namespace nephele::truth {

using glm::dvec2;
using glm::dvec3;
using glm::ivec2;

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kPlanetM = double{shared::kPlanetRadiusM};
constexpr double kOnwardM = 1e-4;  // past a border between patches

// Where a parabola with these values at 0, 1/2 and 1 first comes down to 0; above 1 where it stays above.
double first_root(double begin, double middle, double end) {
  if (begin <= 0.0) return 0.0;
  const double a = 2.0 * (begin + end - 2.0 * middle), b = 4.0 * middle - 3.0 * begin - end;
  const double discriminant = b * b - 4.0 * a * begin;
  if (discriminant < 0.0) return 2.0;
  const double down = std::sqrt(discriminant) - b;
  return down > 0.0 ? 2.0 * begin / down : 2.0;
}

}  // namespace

TerrainSurface::TerrainSurface(const Terrain& terrain, const dvec3& camera_world_m)
    : grid_(terrain_grid(terrain)),
      steepness_(terrain_steepness(grid_)),
      camera_((dvec2(camera_world_m) - grid_.corner_m) / grid_.spacing_m),
      center_m_(kPlanetM + camera_world_m.z),
      blocks_((grid_.vertices - 1 + kBlock - 1) / kBlock) {
  block_highest_m_.resize(std::size_t(blocks_.x) * std::size_t(blocks_.y));
  for (int y = 0; y < grid_.vertices.y; ++y)
    for (int x = 0; x < grid_.vertices.x; ++x)
      for (int k = 0; k < 4; ++k) {  // a vertex on the border of blocks belongs to each
        const ivec2 block = glm::clamp((ivec2(x, y) - ivec2(k & 1, k >> 1)) / kBlock, ivec2(0), blocks_ - 1);
        float& highest_m = block_highest_m_[std::size_t(block.y) * std::size_t(blocks_.x) + std::size_t(block.x)];
        highest_m = std::max(highest_m, grid_.at({x, y}));
      }
}

dvec2 TerrainSurface::from_camera_m(const dvec3& p_m) const {
  const double across_m = std::hypot(p_m.x, p_m.y);
  if (across_m == 0.0) return dvec2(0.0);
  return dvec2(p_m) * (kPlanetM * std::atan2(across_m, p_m.z + center_m_) / across_m);
}

TerrainSurface::Over TerrainSurface::over(const dvec3& p_m) const {
  return {camera_ + from_camera_m(p_m) / grid_.spacing_m,
          std::sqrt(p_m.x * p_m.x + p_m.y * p_m.y + (p_m.z + center_m_) * (p_m.z + center_m_)) - kPlanetM};
}

double TerrainSurface::patch_m(const ivec2& cell, const dvec2& place) const {
  const dvec2 f = place - dvec2(cell);
  const double south = glm::mix(double{grid_.at(cell)}, double{grid_.at(cell + ivec2(1, 0))}, f.x);
  const double north = glm::mix(double{grid_.at(cell + ivec2(0, 1))}, double{grid_.at(cell + ivec2(1, 1))}, f.x);
  return glm::mix(south, north, f.y);
}

bool TerrainSurface::covers(const dvec3& p_m) const {
  const dvec2 place = over(p_m).place;
  return glm::all(glm::greaterThanEqual(place, dvec2(0.0))) &&
         glm::all(glm::lessThanEqual(place, dvec2(grid_.vertices - 1)));
}

// How far to go on from a place; hit: the surface is there.
double TerrainSurface::step_over_m(const dvec3& origin_m, const dvec3& direction, double at_m, bool& hit) const {
  const Over here = over(origin_m + at_m * direction);
  const dvec2 per_m =
      over(origin_m + (at_m + 1.0) * direction).place - here.place;  // changes by a millionth in a patch
  const auto exit_m = [&](const dvec2& low, const dvec2& high) {
    double exit = kNever;
    for (int k = 0; k < 2; ++k)
      if (per_m[k] != 0.0) exit = std::min(exit, ((per_m[k] > 0.0 ? high[k] : low[k]) - here.place[k]) / per_m[k]);
    return std::max(exit, 0.0);
  };
  const dvec2 last(grid_.vertices - 1);
  const dvec2 outside = glm::max(glm::max(-here.place, here.place - last), 0.0);
  if (outside.x > 0.0 || outside.y > 0.0) {
    double enter_m = 0.0;
    for (int k = 0; k < 2; ++k) {
      const double to = here.place[k] < 0.0 ? -here.place[k] : last[k] - here.place[k];
      if (outside[k] <= 0.0) continue;
      if (to * per_m[k] <= 0.0) return kNever;  // away from it
      enter_m = std::max(enter_m, to / per_m[k]);
    }
    return 0.999 * enter_m + 0.01;  // a long way bends a little
  }
  const ivec2 cell = glm::clamp(ivec2(here.place), ivec2(0), grid_.vertices - 2);
  const ivec2 block = cell / kBlock;
  const double highest_m =
      double{block_highest_m_[std::size_t(block.y) * std::size_t(blocks_.x) + std::size_t(block.x)]};
  if (here.altitude_m > highest_m) {
    const double exit = exit_m(dvec2(block * kBlock), dvec2((block + 1) * kBlock));
    // Between two places a ray sinks below both by less than a metre in 7 km.
    if (exit < 5000.0 && over(origin_m + (at_m + exit) * direction).altitude_m > highest_m + 1.0)
      return exit + kOnwardM;
    if (here.altitude_m - highest_m > 10.0) return here.altitude_m - highest_m;  // it cannot sink faster than it goes
  }
  const double exit = std::min(exit_m(dvec2(cell), dvec2(cell + 1)), 1e5);
  const auto over_patch_m = [&](double further_m) {
    const Over there = over(origin_m + (at_m + further_m) * direction);
    return there.altitude_m - patch_m(cell, there.place);
  };
  const double root = first_root(over_patch_m(0.0), over_patch_m(0.5 * exit), over_patch_m(exit));
  hit = root <= 1.0;
  return hit ? root * exit : exit + kOnwardM;
}

double TerrainSurface::hit_m(const dvec3& origin_m, const dvec3& direction) const {
  const double radius_m = kPlanetM + double{grid_.highest_m};
  const dvec3 from_center_m = origin_m + dvec3(0.0, 0.0, center_m_);
  const double along_m = glm::dot(from_center_m, direction);
  const double power = glm::dot(from_center_m, from_center_m) - radius_m * radius_m;
  const double discriminant = along_m * along_m - power;
  if (discriminant < 0.0) return kNever;
  const double end_m = -along_m + std::sqrt(discriminant);
  double at_m = std::max(0.0, -along_m - std::sqrt(discriminant));
  const double sea = along_m * along_m - (glm::dot(from_center_m, from_center_m) - kPlanetM * kPlanetM);
  const double sea_m = along_m < 0.0 && sea > 0.0 ? -along_m - std::sqrt(sea) : kNever;
  while (at_m < std::min(end_m, sea_m + 1.0)) {
    bool hit = false;
    const double step_m = step_over_m(origin_m, direction, at_m, hit);
    at_m += step_m;
    if (hit) return at_m;
    if (step_m == kNever) break;
  }
  return kNever;
}

TerrainSurface::Land TerrainSurface::land(const dvec3& p_m) const {
  const Over here = over(p_m);
  const ivec2 cell = glm::clamp(ivec2(glm::floor(here.place)), ivec2(0), grid_.vertices - 2);
  const dvec2 f = glm::clamp(here.place - dvec2(cell), 0.0, 1.0);
  dvec2 slope(0.0);
  double steepness = 0.0;
  for (int k = 0; k < 4; ++k) {
    const ivec2 corner(k & 1, k >> 1);
    const double weight = (corner.x ? f.x : 1.0 - f.x) * (corner.y ? f.y : 1.0 - f.y);
    const ivec2 vertex = cell + corner;
    slope += weight * terrain_slope(grid_, vertex);
    steepness +=
        weight * double{steepness_[std::size_t(vertex.y) * std::size_t(grid_.vertices.x) + std::size_t(vertex.x)]};
  }
  // Axes at the place: up, and what leads on from the camera and across.
  const dvec3 from_center_m = p_m + dvec3(0.0, 0.0, center_m_);
  const dvec3 up = glm::normalize(from_center_m);
  const double across_m = std::hypot(p_m.x, p_m.y);
  const dvec2 azimuth = across_m > 0.0 ? dvec2(p_m) / across_m : dvec2(1.0, 0.0);
  const dvec3 across(-azimuth.y, azimuth.x, 0.0), onward = glm::cross(across, up);
  const dvec3 east = azimuth.x * onward - azimuth.y * across, north = azimuth.y * onward + azimuth.x * across;
  return {glm::normalize(up - slope.x * east - slope.y * north), here.altitude_m, std::sqrt(steepness),
          from_camera_m(p_m)};
}

}  // namespace nephele::truth
