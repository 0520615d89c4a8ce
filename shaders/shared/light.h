// Sunlight between particles: light space, its tile grid, and the optical depth of a particle along a sun ray.
//
// *Light space*: origin at the camera, w towards the sun, u horizontal and v across both, metres. Sun rays are the
// lines of constant (u, v). *Warped coordinates* of light space grow like the logarithm of the distance from the
// camera, so one square grid of tiles is fine near the camera and still covers the whole field; tiles at the border
// take in everything beyond it.
#ifndef NEPHELE_SHARED_LIGHT_H
#define NEPHELE_SHARED_LIGHT_H

#include "prelude.h"
#include "ellipsoid.h"
#include "tile_rectangle.h"
#include "types.h"
#include "world.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kLightTiles, 192u);       // tiles along a side of the grid
NEPHELE_CONST(uint, kLightTileBits, 16u);     // of a tile's index
NEPHELE_CONST(float, kLightInnerM, 2000.0f);  // within about this distance tiles have one size
NEPHELE_CONST(uint, kSunKeyBits, 16u);        // of the order along w
// Clamp: beyond this depth under 1 % of the light is left, even at an effective extinction of 0.025 times the true one
// ([Yusov14] 5.3 scales it by 0.05). Traversal stops here.
NEPHELE_CONST(float, kMaxSunOpticalDepth, 200.0f);

// ---- Warped coordinates and tiles ----

// Half the extent of the grid: the view distance with room for the corners of a square field.
NEPHELE_FN float light_reach_m(float view_distance_m) { return 1.5f * max(view_distance_m, 10000.0f); }

NEPHELE_FN float light_warp(float x_m) {
  float y = log2(1.0f + abs(x_m) / kLightInnerM);
  return x_m < 0.0f ? -y : y;
}

NEPHELE_FN float light_unwarp(float y) {
  float x_m = kLightInnerM * (exp2(abs(y)) - 1.0f);
  return y < 0.0f ? -x_m : x_m;
}

// (u, v) in metres <-> the grid as [0, 1]^2; outside it when beyond the reach.
NEPHELE_FN float light_uv_scale(float view_distance_m) { return 0.5f / light_warp(light_reach_m(view_distance_m)); }
NEPHELE_FN vec2 scaled_light_uv(vec2 across_m, float scale) {
  return vec2(0.5f + light_warp(across_m.x) * scale, 0.5f + light_warp(across_m.y) * scale);
}
NEPHELE_FN vec2 light_uv(vec2 across_m, float view_distance_m) {
  return scaled_light_uv(across_m, light_uv_scale(view_distance_m));
}

NEPHELE_FN vec2 light_across(vec2 uv, float view_distance_m) {
  float scale = 2.0f * light_warp(light_reach_m(view_distance_m));
  return vec2(light_unwarp((uv.x - 0.5f) * scale), light_unwarp((uv.y - 0.5f) * scale));
}

// The tile of a point; points beyond the grid belong to its border. Monotone in u and in v.
NEPHELE_FN uvec2 light_tile(vec2 across_m, float view_distance_m) {
  vec2 uv = light_uv(across_m, view_distance_m);
  float last = float(kLightTiles) - 1.0f;
  return uvec2(uint(clamp(floor(uv.x * float(kLightTiles)), 0.0f, last)),
               uint(clamp(floor(uv.y * float(kLightTiles)), 0.0f, last)));
}

NEPHELE_FN uint light_tile_index(uvec2 tile) { return tile.y * kLightTiles + tile.x; }

// ---- Order from the sun ----

// w as a fraction of the grid: 0 at the sun's end, 1 at the far one, not clamped.
NEPHELE_FN float sun_fraction(float w_m, float view_distance_m) {
  return 0.5f - 0.5f * light_warp(w_m) / light_warp(light_reach_m(view_distance_m));
}

// Sorting by this key puts what is nearest to the sun first, to a resolution of 1/65 536 of the warped range: 0.3 m
// at the camera, 12 m at 80 km. All keys beyond the grid are equal.
NEPHELE_FN uint sun_key(float w_m, float view_distance_m) {
  return uint(clamp(sun_fraction(w_m, view_distance_m), 0.0f, 1.0f) * 65535.0f);
}

// Given a point at w in a list ordered by the sun_key of each particle's end nearest to the sun: once an end lies
// below this height, that particle and all after it lie behind the point. One key's width below w, and another for
// rounding; never, where keys are all equal.
NEPHELE_FN float sun_stop_m(float w_m, float view_distance_m) {
  float fraction = clamp(sun_fraction(w_m, view_distance_m), 0.0f, 2.0f) + 2.0f / 65535.0f;
  if (fraction >= 1.0f) return -3.0e38f;
  return light_unwarp((1.0f - 2.0f * fraction) * light_warp(light_reach_m(view_distance_m)));
}

// ---- A particle as an occluder ----

// What is left of a particle's matter where it is torn (structure.h), fitted to within a hundredth: 0.43 of it, if
// wholly.
NEPHELE_FN float torn_matter(uint flags) {
  float torn = float((flags >> kParticleTornShift) & kMostTorn) / float(kMostTorn);
  return (flags & kParticleDetail) != 0u ? 1.0f - torn * (0.81f - 0.244f * torn) : 1.0f;
}

// A particle seen along w. At offset d = (du, dv) from its centre the sun ray's squared impact parameter is
// d^T shape d (1 at the silhouette) and the middle of its chord is at w = center.z + dot(slope, d); a ray through
// the middle of the silhouette has a chord of 2 half_m.
struct Occluder {
  vec3 center_m;      // light space
  float top_m;        // largest w of the ellipsoid
  vec3 shape_per_m2;  // uu, uv, vv of the symmetric matrix `shape` above
  float half_m;
  vec2 slope;
  float base_m;            // height of the flat base over the centre, along render z; kNoBaseM: none
  float extinction_per_m;  // peak
  uint flags;              // of Particle.flags kParticleHomogeneous
};

// As it is kept in a buffer: three texels.
struct PackedOccluder {
  vec4 center_top;
  vec4 shape_half;  // half_m is negative when the particle is homogeneous
  vec4 slope_base_extinction;
};

NEPHELE_FN PackedOccluder pack_occluder(Occluder o) {
  float half_m = (o.flags & kParticleHomogeneous) != 0u ? -o.half_m : o.half_m;
  PackedOccluder packed;
  packed.center_top = vec4(o.center_m, o.top_m);
  packed.shape_half = vec4(o.shape_per_m2, half_m);
  packed.slope_base_extinction = vec4(o.slope, o.base_m, o.extinction_per_m);
  return packed;
}

NEPHELE_FN Occluder unpack_occluder(PackedOccluder packed) {
  Occluder o;
  o.center_m = vec3(packed.center_top);
  o.top_m = packed.center_top.w;
  o.shape_per_m2 = vec3(packed.shape_half);
  o.half_m = abs(packed.shape_half.w);
  o.slope = vec2(packed.slope_base_extinction);
  o.base_m = packed.slope_base_extinction.z;
  o.extinction_per_m = packed.slope_base_extinction.w;
  o.flags = packed.shape_half.w < 0.0f ? kParticleHomogeneous : 0u;
  return o;
}

// Half the extents of an ellipsoid along the light space axes, widened by what float positions and the logarithm
// of a device may be off, so that no point of the ellipsoid falls outside the tiles given to it.
struct LightBounds {
  vec3 center_m;
  vec3 extent_m;
};

// The rectangle of tiles that bounds cover.
NEPHELE_FN uvec2 light_rectangle(LightBounds bounds, float view_distance_m) {
  vec3 first_m = bounds.center_m - bounds.extent_m;
  vec3 last_m = bounds.center_m + bounds.extent_m;
  uvec2 low = light_tile(vec2(first_m.x, first_m.y), view_distance_m);
  uvec2 high = light_tile(vec2(last_m.x, last_m.y), view_distance_m);
  return tile_rectangle(low, high + 1u);
}

NEPHELE_FN Occluder make_occluder(Particle particle, mat3 light_from_render, float camera_altitude_m,
                                  NEPHELE_OUT(LightBounds) bounds) {
  // Conjugate semi-axes in light space; their outer products sum to the ellipsoid's covariance form.
  mat3 axes = light_from_render * shape_matrix(particle.shape);
  vec3 a = axes[0];
  vec3 b = axes[1];
  vec3 c = axes[2];
  float uu = a.x * a.x + b.x * b.x + c.x * c.x;
  float uv = a.x * a.y + b.x * b.y + c.x * c.y;
  float vv = a.y * a.y + b.y * b.y + c.y * c.y;
  float uw = a.x * a.z + b.x * b.z + c.x * c.z;
  float vw = a.y * a.z + b.y * b.z + c.y * c.z;
  float ww = a.z * a.z + b.z * b.z + c.z * c.z;

  // The silhouette's form is the inverse of the covariance across; the determinant is the sum of the squares of the
  // three projected parallelograms (Cauchy-Binet), which does not cancel for flat particles.
  float ab = a.x * b.y - a.y * b.x;
  float bc = b.x * c.y - b.y * c.x;
  float ca = c.x * a.y - c.y * a.x;
  float inverse_det = 1.0f / (ab * ab + bc * bc + ca * ca);
  vec3 towards_sun = transpose(light_from_render)[2];
  vec3 along = unit_from_render(particle.shape) * towards_sun;

  bounds.center_m = light_from_render * particle.center_m;
  vec3 slack_m = 4.0e-6f * (abs(bounds.center_m) + kLightInnerM);
  bounds.extent_m = vec3(sqrt(uu), sqrt(vv), sqrt(ww)) * 1.00001f + slack_m;

  Occluder occluder;
  occluder.center_m = bounds.center_m;
  occluder.top_m = bounds.center_m.z + bounds.extent_m.z;
  occluder.shape_per_m2 = vec3(vv, -uv, uu) * inverse_det;
  occluder.half_m = inversesqrt(dot(along, along));
  occluder.slope = vec2(vv * uw - uv * vw, uu * vw - uv * uw) * inverse_det;
  occluder.base_m = particle.base_m - altitude_m(particle.center_m, camera_altitude_m);
  occluder.extinction_per_m = particle.extinction_per_m * torn_matter(particle.flags);
  occluder.flags = particle.flags & kParticleHomogeneous;
  return occluder;
}

// A particle's extinction as a fraction of its peak, averaged over the air's structure (structure.h), as a polynomial
// in q = 1 - r^2, so that chords integrate in closed form. Fitted with weight r^2 to balls whose surface is displaced
// as far as that of most particles is, kStructureDeepest: RMS error 0.04, mean fill 0.416 for 0.408. The smooth
// reference particle (reference_particle.h) has nearly the same: mean fill 0.43. Exactly 1 for homogeneous particles.
NEPHELE_CONST(float, kProfile2, 2.45f);
NEPHELE_CONST(float, kProfile3, 0.4f);
NEPHELE_CONST(float, kProfile4, -1.85f);

NEPHELE_FN float particle_profile(float q, uint flags) {
  return (flags & kParticleHomogeneous) != 0u ? 1.0f : q * q * (kProfile2 + q * (kProfile3 + q * kProfile4));
}

// Its integral along a chord of the unit sphere from the chord's middle to the signed distance s, where
// q = h2 - s^2 with h2 = 1 - (impact parameter)^2.
NEPHELE_FN float profile_integral(float s, float h2, uint flags) {
  float s2 = s * s;
  float i2 = h2 * (h2 - s2 * (2.0f / 3.0f)) + s2 * s2 * 0.2f;
  float i3 = h2 * (h2 * (h2 - s2) + 0.6f * s2 * s2) - s2 * s2 * s2 * (1.0f / 7.0f);
  float i4 = h2 * (h2 * (h2 * (h2 - s2 * (4.0f / 3.0f)) + 1.2f * s2 * s2) - s2 * s2 * s2 * (4.0f / 7.0f)) +
             s2 * s2 * s2 * s2 * (1.0f / 9.0f);
  return (flags & kParticleHomogeneous) != 0u ? s : s * (kProfile2 * i2 + kProfile3 * i3 + kProfile4 * i4);
}

// The part of a particle's chord along a sun ray that lies beyond a point and above the flat base: from `begin` to
// `end` along w in units of half_m, measured from the chord's middle; h2 as for profile_integral. Empty when nothing
// of the particle lies between the point and the sun.
struct SunChord {
  float begin;
  float end;  // >= begin
  float h2;
  float middle_m;  // w of the chord's middle
};

// 1 minus the squared impact parameter of the sun ray at an offset (du, dv) from the centre; negative outside.
NEPHELE_FN float silhouette(Occluder occluder, float du, float dv) {
  vec3 shape = occluder.shape_per_m2;
  return 1.0f - (shape.x * du * du + 2.0f * shape.y * du * dv + shape.z * dv * dv);
}

// up is render z in light space.
NEPHELE_FN SunChord sun_chord(Occluder occluder, vec3 p_light_m, vec3 up) {
  float du = p_light_m.x - occluder.center_m.x;
  float dv = p_light_m.y - occluder.center_m.y;
  float offset_m = occluder.slope.x * du + occluder.slope.y * dv;
  SunChord chord;
  chord.h2 = max(silhouette(occluder, du, dv), 0.0f);
  chord.middle_m = occluder.center_m.z + offset_m;
  float reach = sqrt(chord.h2);
  float begin = (p_light_m.z - chord.middle_m) / occluder.half_m;
  float end = reach;

  // Height over the base plane along the chord: height_m + climb_m * s.
  float height_m = up.x * du + up.y * dv + up.z * offset_m - occluder.base_m;
  float climb_m = up.z * occluder.half_m;
  if (up.z > 1.0e-6f)
    begin = max(begin, -height_m / climb_m);
  else if (up.z < -1.0e-6f)
    end = min(end, -height_m / climb_m);
  else
    end = height_m < 0.0f ? -reach : end;

  chord.begin = clamp(begin, -reach, reach);
  chord.end = clamp(end, chord.begin, reach);
  return chord;
}

NEPHELE_FN float chord_depth(Occluder occluder, SunChord chord) {
  float to_end = profile_integral(chord.end, chord.h2, occluder.flags);
  float to_begin = profile_integral(chord.begin, chord.h2, occluder.flags);
  return occluder.extinction_per_m * occluder.half_m * max(to_end - to_begin, 0.0f);  // against rounding
}

// Optical depth of one particle between a point and the sun.
NEPHELE_FN float occluder_depth(Occluder occluder, vec3 p_light_m, vec3 up) {
  return chord_depth(occluder, sun_chord(occluder, p_light_m, up));
}

// ---- Sampling the depth inside a particle ----

// A regular tetrahedron's corners, unit vectors: they sum to zero and their outer products to 4/3 of the identity, so
// the mean of a linear function at the corners is its value at the centre and sum(value * corner) gives its gradient.
NEPHELE_FN vec3 tetrahedron_corner(uint i) {
  float s = 0.57735027f;
  return vec3(i < 2u ? s : -s, (i & 1u) == 0u ? s : -s, i == 0u || i == 3u ? s : -s);
}

// Where a particle's depth is sampled, as a fraction of its radii. Against the true depth at random points inside
// particles of a whole field, exp(-tau / 4) from these four points and a clamped linear law has an RMS error of 0.15 to
// 0.16; from the centre alone 0.23 to 0.26, from six points on the axes 0.13 to 0.14, and those with the centre 0.17.
NEPHELE_CONST(float, kDepthSampleRadius, 0.6f);

NEPHELE_FN vec3 particle_point(Particle particle, vec3 unit_point) {
  return particle.center_m + shape_matrix(particle.shape) * unit_point;
}

#ifdef __cplusplus
// Rows u, v, w for a sun in any direction. u is horizontal, so that a low sun sees the flat cloud field along a tile
// axis, where the warp keeps it finely divided. With the sun overhead (or underfoot) u is east.
inline mat3 make_light_from_render(dvec3 sun_direction) {
  const dvec3 w = normalize(sun_direction);
  const double horizontal = std::sqrt(w.x * w.x + w.y * w.y);
  const dvec3 u = horizontal > 1e-9 ? dvec3(-w.y, w.x, 0.0) / horizontal : dvec3(1.0, 0.0, 0.0);
  const dvec3 v = cross(w, u);
  return mat3(transpose(dmat3(u, v, w)));
}
#endif

NEPHELE_SHARED_END

#ifdef __cplusplus
static_assert(sizeof(nephele::shared::PackedOccluder) == 48);
static_assert(nephele::shared::kLightTiles * nephele::shared::kLightTiles <= 1u << nephele::shared::kLightTileBits);
static_assert(nephele::shared::kSunKeyBits == 16);
#endif

#endif
