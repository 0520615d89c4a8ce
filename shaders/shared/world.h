// The world's two frames on the GPU and the way between them.
//
// *Grid space*: xy in metres from a snapped origin in cloud space (the world minus the wind's drift), z = altitude.
// Horizontal distances are arcs along the planet's surface. The origin is origin_index * kOriginUnitM, so a camera
// 10 000 km out still has |xy| <= kOriginUnitM / 2 and floats keep centimetres.
// *Render space*: the world's axes at the camera, origin at the camera, the planet curving away below.
//
// Anything random that is tied to a place lives on a lattice of kOriginUnitM / n metres with integer n: the cell at
// grid position p is floor(p * n / kOriginUnitM) counted from n * origin_index, in wrapping 32-bit integers. So a
// place has one cell whatever the origin.
#ifndef NEPHELE_SHARED_WORLD_H
#define NEPHELE_SHARED_WORLD_H

#include "prelude.h"

#ifdef __cplusplus
#include <cmath>
#endif

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(float, kOriginUnitM, 94208.0f);  // 512 cells of 184 m

// Position in cells of the lattice with n cells a unit, and the index of its cell 0.
NEPHELE_FN vec2 lattice_position(vec2 grid_m, uint n) { return grid_m * (float(n) / kOriginUnitM); }
NEPHELE_FN uvec2 lattice_base(ivec2 origin_index, uint n) { return uvec2(origin_index) * n; }
NEPHELE_FN float lattice_cell_m(uint n) { return kOriginUnitM / float(n); }

// Altitude is kept and so is the arc from the camera: at arc s the planet has turned by phi = s / R, and the point is
// (dir (R + z) sin phi, z - z_cam - 2 (R + z) sin^2(phi / 2)). sin x / x is a series, exact to float for |x| < 0.5
// (3 000 km), since a device's sine may not be.
NEPHELE_FN float sinc_series(float x2) {
  return 1.0f - x2 * (1.0f / 6.0f) * (1.0f - x2 * (1.0f / 20.0f) * (1.0f - x2 * (1.0f / 42.0f)));
}

// From the offset to the camera along the surface and in altitude.
NEPHELE_FN vec3 render_from_offset(vec3 offset_m, float camera_altitude_m) {
  float s2 = offset_m.x * offset_m.x + offset_m.y * offset_m.y;
  float phi2 = s2 * (1.0f / (kPlanetRadiusM * kPlanetRadiusM));
  float lift = 1.0f + (camera_altitude_m + offset_m.z) * (1.0f / kPlanetRadiusM);
  float across = lift * sinc_series(phi2);
  float half_sinc = sinc_series(0.25f * phi2);
  float drop = lift * s2 * (0.5f / kPlanetRadiusM) * half_sinc * half_sinc;
  return vec3(offset_m.x * across, offset_m.y * across, offset_m.z - drop);
}

NEPHELE_FN vec3 render_from_grid(vec3 p_grid_m, vec3 camera_grid_m) {
  return render_from_offset(p_grid_m - camera_grid_m, camera_grid_m.z);
}

// Altitude above the sphere of a point in render space: the difference of two radii, written without their
// cancellation. Good to a few millimetres within 250 km.
NEPHELE_FN float altitude_m(vec3 p_render_m, float camera_altitude_m) {
  float z = p_render_m.z + camera_altitude_m;
  float excess = p_render_m.x * p_render_m.x + p_render_m.y * p_render_m.y + z * (z + 2.0f * kPlanetRadiusM);
  return excess / (sqrt(kPlanetRadiusM * kPlanetRadiusM + excess) + kPlanetRadiusM);
}

// Inverse of render_from_grid for points above the planet within about 1 500 km: phi = atan(t) as a series.
NEPHELE_FN vec3 grid_from_render(vec3 p_render_m, vec3 camera_grid_m) {
  float down = kPlanetRadiusM + camera_grid_m.z + p_render_m.z;
  float x = p_render_m.x / down;
  float y = p_render_m.y / down;
  float t2 = x * x + y * y;
  float series = 1.0f - t2 * (1.0f / 3.0f - t2 * (1.0f / 5.0f - t2 * (1.0f / 7.0f - t2 * (1.0f / 9.0f))));
  float arc = kPlanetRadiusM * series;
  return vec3(camera_grid_m.x + x * arc, camera_grid_m.y + y * arc, altitude_m(p_render_m, camera_grid_m.z));
}

#ifdef __cplusplus
// A place in cloud space, split so that shaders never see a large number.
struct GridPlace {
  ivec2 origin_index;  // of the grid's origin, in units of kOriginUnitM, wrapping
  vec3 grid_m;         // |x|, |y| <= kOriginUnitM / 2
};

inline GridPlace grid_place(dvec3 cloud_m) {
  const double unit = static_cast<double>(kOriginUnitM);
  const double ix = std::round(cloud_m.x / unit), iy = std::round(cloud_m.y / unit);
  const auto wrap = [](double index) {
    return static_cast<int>(static_cast<std::uint32_t>(static_cast<std::int64_t>(index)));
  };
  return {ivec2(wrap(ix), wrap(iy)), vec3(dvec3(cloud_m.x - ix * unit, cloud_m.y - iy * unit, cloud_m.z))};
}

// The clouds drift with the wind through the world: cloud space stands still in the air.
inline dvec3 cloud_from_world(dvec3 world_m, dvec2 wind_m_per_s, double time_s) {
  return {world_m.x - wind_m_per_s.x * time_s, world_m.y - wind_m_per_s.y * time_s, world_m.z};
}

// The nearest usable finest cell: a divisor of the unit that still is one after doubling eight times.
inline float usable_inner_cell_m(double wanted_m) {
  const double blocks = std::round(static_cast<double>(kOriginUnitM) / wanted_m / 256.0);
  return static_cast<float>(static_cast<double>(kOriginUnitM) / (256.0 * std::fmin(std::fmax(blocks, 1.0), 32.0)));
}
#endif

NEPHELE_SHARED_END

#endif
