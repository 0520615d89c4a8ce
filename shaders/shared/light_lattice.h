// The lattice of the light field: nested windows of flat cells around the camera, the ordinates along which light is
// carried through them, and what a cell does to the light. passes/light/light_field.h has the whole method.
//
// A *window* is a block of side x side x height cells in grid space, xy about the window's centre. Cells are numbered
// x fastest, then y, then z upwards. Windows of level k + 1 have cells kLightLevelRatio times as wide as those of level
// k and as high. Two volumes hold windows one above another, a plane of nothing between them.
#ifndef NEPHELE_SHARED_LIGHT_LATTICE_H
#define NEPHELE_SHARED_LIGHT_LATTICE_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kMaxLightLevels, 5u);
// Odd: then a border that a coarse window's step crosses is one of the finer window's too.
NEPHELE_CONST(uint, kLightLevelRatio, 3u);
NEPHELE_CONST(uint, kLightWindowStep, 8u);  // cells by which a window moves

// Ordinates: the vertices of a dodecahedron with its pole up, equal weights, exact for polynomials of degree 5. None is
// horizontal: a horizontal one would never leave a layer of cloud. They come in pairs d (upwards) and -d.
NEPHELE_CONST(uint, kLightPairs, 10u);
NEPHELE_CONST(uint, kLightOrdinates, 20u);  // ordinate 2 p: upwards along pair p, 2 p + 1: downwards
NEPHELE_CONST(float, kLightOrdinateShare, 0.05f);

// One level's window as shaders see it.
struct LightLevel {
  vec2 corner_m;  // of its first cell, from the reference point: the camera, or the centre of the window being solved
  float cell_m;   // width of a cell
  float reach_m;  // nearer than this to the camera, by the larger of |x| and |y|, the level holds
  uint extinction_plane;  // of the window's lowest layer in the volume of extinction
  uint radiance_plane;    // in the volume of radiance
};

struct LightLattice {
  LightLevel levels[kMaxLightLevels];  // finest first
  uint level_count;
  uint side;       // cells along x and y
  uint height;     // cells along z
  float lowest_m;  // altitude of the lowest layer's floor
  float layer_m;   // height of a cell
  vec3 sun_direction;
  float beam_way_m;  // of a sun ray through the middle of a cell, in the window being solved
  // Moments of the phase function and what delta-M scaling makes of them [Wiscombe 1977].
  float moment1, moment2;  // chi_l: mean of P_l over the phase function
  float forward;           // share of scattering that counts as not scattered: chi_2
  float scaled_asymmetry;  // (chi_1 - f) / (1 - f)
};

// A pair of ordinates on a lattice. A line starts in one cell of the first plane across `axis` and goes from plane to
// plane, in each to the nearest cell; where it leaves the lattice at a side it comes in again at the opposite one, as
// another ray. So lines and cells are one to one in each plane.
struct LightPair {
  vec3 direction;  // the upward one
  float length_m;  // of a line's way through one plane
  ivec3 count;     // planes along the axis; cells along the two others
  ivec3 stride;    // between cells along the axis and the two others
  ivec2 slope;     // cells sideways a plane, times 65536
  uint reversed;   // 1: the upward ordinate goes down the axis
  uint axis;       // 0 x, 1 y, 2 z
};

NEPHELE_FN uint light_cell_count(uint side, uint height) { return side * side * height; }

// Cells sideways at the middle of plane k, to the nearest.
NEPHELE_FN int light_line_shift(int slope, int k) { return ((2 * k + 1) * slope + 65536) >> 17; }

// Share of a particle's own record in the depth towards the sun: all of it near the camera, where cells are seen to be
// coarse. nearest_m: distance of the particle's surface; cell_m: of the finest level.
NEPHELE_CONST(float, kNearCameraCells, 4.0f);
NEPHELE_FN float near_camera_share(float nearest_m, float cell_m) {
  return 1.0f - smoothstep(kNearCameraCells, 2.0f * kNearCameraCells, nearest_m / cell_m);
}

// (1 - exp(-s)) / s, s >= 0, without cancellation.
NEPHELE_FN float mean_transmittance(float s) {
  return s < 0.04f ? 1.0f - s * (0.5f - s * (1.0f / 6.0f - s * (1.0f / 24.0f))) : (1.0f - exp(-s)) / s;
}

// Real spherical harmonics up to degree 2, scaled so that sum over m of Y_lm(a) Y_lm(b) = (2 l + 1) P_l(a . b).
NEPHELE_CONST(uint, kLightMoments, 9u);
struct LightHarmonics {
  float y[9];
};
NEPHELE_FN LightHarmonics light_harmonics(vec3 d) {
  const float s3 = 1.7320508f;
  const float s15 = 3.8729833f;
  LightHarmonics h;
  h.y[0] = 1.0f;
  h.y[1] = s3 * d.x;
  h.y[2] = s3 * d.y;
  h.y[3] = s3 * d.z;
  h.y[4] = s15 * d.x * d.y;
  h.y[5] = s15 * d.y * d.z;
  h.y[6] = 1.1180340f * (3.0f * d.z * d.z - 1.0f);
  h.y[7] = s15 * d.x * d.z;
  h.y[8] = 0.5f * s15 * (d.x * d.x - d.y * d.y);
  return h;
}

// The lattice's extinction is summed in integers, so that the order of summing changes nothing.
NEPHELE_CONST(float, kLightFixedPoint, 16777216.0f);  // units of a 1/m

// The unit in which half floats hold radiance: the sun's irradiance, and under the horizon about what dusk leaves of
// it. A power of two of the sun's irradiance, so that a step of it rounds nothing anew.
NEPHELE_FN float light_field_unit(vec3 sun_irradiance, float sun_elevation_rad) {
  const float most = max(sun_irradiance.x, max(sun_irradiance.y, sun_irradiance.z));
  const float dusk = clamp(-1.5f * 57.29578f * sun_elevation_rad, 0.0f, 14.0f);  // halvings
  return most > 0.0f ? most * exp2(-floor(dusk)) : 1.0f;
}

NEPHELE_SHARED_END

#endif
