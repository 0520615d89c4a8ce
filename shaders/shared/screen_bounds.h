// Where an ellipsoid can show on the screen and how near it can come: conservative bounds for the screen tile lists.
// After: Sigg et al., GPU-Based Ray-Casting of Quadratic Surfaces, 2006 (tangent planes of a quadric).
#ifndef NEPHELE_SHARED_SCREEN_BOUNDS_H
#define NEPHELE_SHARED_SCREEN_BOUNDS_H

#include "prelude.h"
#include "tile_rectangle.h"
#include "world.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kScreenTilePx, 8u);
NEPHELE_CONST(uint, kMaxScreenParticles, 1048576u);  // as far as screen_begins.comp goes through a list
// Longest of the short lists: of the volume blend in cloud_columns.comp as many places as its stack holds segments, of
// all others what pays.
NEPHELE_CONST(uint, kColumnPlaces, 256u);
NEPHELE_CONST(uint, kShortPlaces, 128u);
// Longer lists are shaded in pages of this many places, a dispatch each: lavapipe ends all loops of eight threads once
// they have gone round 65 535 times in all, and a place takes them some five rounds, up to twice.
NEPHELE_CONST(uint, kPagePlaces, 4096u);

// Interval of one normalised device coordinate s. The plane s = const through the camera has the normal
// across - s * forward (rows of clip_from_render); it touches the ellipsoid where its distance to the centre equals
// the ellipsoid's extent. Solved for the offset from the centre's own s, so that small or distant ellipsoids don't
// cancel. False where the ellipsoid reaches the plane of the eye and may cover anything.
NEPHELE_FN bool screen_interval(vec3 across, vec3 forward, mat3 render_from_reference, vec3 center_m,
                                NEPHELE_OUT(float) low, NEPHELE_OUT(float) high) {
  low = -1.0f;
  high = 1.0f;
  float depth = dot(forward, center_m);
  vec3 b = transpose(render_from_reference) * forward;
  float in_front = depth * depth - dot(b, b);
  if (!(depth > 0.0f) || !(in_front > 1e-5f * depth * depth)) return false;
  float middle = dot(across, center_m) / depth;
  vec3 a = transpose(render_from_reference) * (across - middle * forward);
  float ab = dot(a, b);
  float reach = sqrt(ab * ab + in_front * dot(a, a));
  low = middle + (-ab - reach) / in_front;
  high = middle + (-ab + reach) / in_front;
  return true;
}

// First pixel and pixel past the last whose centres lie in the interval, widened by the rounding of rays and rows.
// A layer pixel p has its centre at (p + 1/2) * scale in image pixels.
NEPHELE_FN uvec2 covered_pixels(float low, float high, float image_px, float scale, float layer_px) {
  float to_px = 0.5f * image_px / scale;
  float slack = 0.01f + 1e-6f * layer_px;
  float first = ceil((low + 1.0f) * to_px - 0.5f - slack);
  float last = floor((high + 1.0f) * to_px - 0.5f + slack);
  return uvec2(uint(clamp(first, 0.0f, layer_px)), uint(clamp(last + 1.0f, 0.0f, layer_px)));
}

// The rectangle of layer pixels whose rays may meet the ellipsoid (tile_rectangle.h, a pixel being a tile).
NEPHELE_FN uvec2 screen_pixels(mat4 clip_from_render, mat3 render_from_reference, vec3 center_m, uvec2 image_size_px,
                               uint scale, uvec2 layer_size_px) {
  mat4 rows = transpose(clip_from_render);
  vec3 x = vec3(rows[0].x, rows[0].y, rows[0].z);
  vec3 y = vec3(rows[1].x, rows[1].y, rows[1].z);
  vec3 w = vec3(rows[3].x, rows[3].y, rows[3].z);
  if (dot(w, center_m) + 1.00001f * length(transpose(render_from_reference) * w) < 0.0f)
    return kNoTiles;  // behind the eye
  vec2 low;
  vec2 high;
  screen_interval(x, w, render_from_reference, center_m, low.x, high.x);
  screen_interval(y, w, render_from_reference, center_m, low.y, high.y);
  uvec2 px = covered_pixels(low.x, high.x, float(image_size_px.x), float(scale), float(layer_size_px.x));
  uvec2 py = covered_pixels(low.y, high.y, float(image_size_px.y), float(scale), float(layer_size_px.y));
  if (px.x >= px.y || py.x >= py.y) return kNoTiles;
  return tile_rectangle(uvec2(px.x, py.x), uvec2(px.y, py.y));
}

NEPHELE_FN uvec2 tiles_of_pixels(uvec2 pixels) {
  return tile_rectangle(rectangle_low(pixels) / kScreenTilePx,
                        (rectangle_high(pixels) + (kScreenTilePx - 1u)) / kScreenTilePx);
}

// The pixels of a tile whose rays may meet the ellipsoid, a bit each, four rows of eight a word; the rectangle's where
// it reaches the plane of the eye or is a needle askew. In reference space, with the eye at E and a ray's direction D =
// u X + v Y - E / depth, u and v from the centre's own device coordinates, the ray meets the unit sphere where |E x
// D|^2 <= |D|^2. E x D has no constant term, so nothing cancels far away.
NEPHELE_FN uvec2 tile_mask(mat4 clip_from_render, mat4 render_from_clip, mat3 reference_from_render, vec3 center_m,
                           uvec2 pixels, uvec2 tile, uvec2 image_size_px, uint scale, uvec2 layer_size_px) {
  uvec2 corner = tile * kScreenTilePx;
  uvec2 low = max(rectangle_low(pixels), corner);
  uvec2 past = min(rectangle_high(pixels), corner + kScreenTilePx);
  mat4 rows = transpose(clip_from_render);
  vec4 center = vec4(center_m, 0.0f);
  float depth = dot(rows[3], center);
  vec3 eye = -(reference_from_render * center_m);
  vec3 x = reference_from_render * vec3(render_from_clip[0]);
  vec3 y = reference_from_render * vec3(render_from_clip[1]);
  vec3 eye_x = cross(eye, x);
  vec3 eye_y = cross(eye, y);
  float uu = dot(eye_x, eye_x) - dot(x, x);
  float uv = dot(eye_x, eye_y) - dot(x, y);
  float vv = dot(eye_y, eye_y) - dot(y, y);
  bool ellipse = depth > 0.0f && uu > 0.0f && uu * vv - uv * uv > 0.01f * uu * vv;

  uvec2 mask = uvec2(0u);
  for (uint row = low.y; row < past.y; ++row) {
    uvec2 columns = uvec2(low.x, past.x);
    if (ellipse) {
      float v =
          (2.0f * float(row) + 1.0f) * float(scale) / float(image_size_px.y) - 1.0f - dot(rows[1], center) / depth;
      float b = uv * v + dot(x, eye) / depth;
      float c = vv * v * v + (2.0f * v * dot(y, eye) - dot(eye, eye) / depth) / depth;
      float discriminant = b * b - uu * c;
      float reach = sqrt(max(discriminant, 0.0f));
      float middle = dot(rows[0], center) / depth - b / uu;
      uvec2 met = covered_pixels(middle - reach / uu, middle + reach / uu, float(image_size_px.x), float(scale),
                                 float(layer_size_px.x));
      columns = uvec2(max(low.x, met.x), min(past.x, met.y));
      if (discriminant < 0.0f) columns.y = 0u;
    }
    if (columns.x >= columns.y) continue;
    uint bits = ((1u << (columns.y - columns.x)) - 1u)
                << (columns.x - corner.x + kScreenTilePx * ((row - corner.y) & 3u));
    if (row - corner.y < 4u)
      mask.x |= bits;
    else
      mask.y |= bits;
  }
  return mask;
}

// An ellipsoid around the part of a particle that lies above its flat base. In reference space that is a unit ball cut
// by a plane at height `cut` along `axis`; of the ellipsoids through the ball's top and the cut's circle this one, flat
// and wide, follows the plane closely, and the ball itself bounds the sides. Where hardly anything is cut off: the
// particle's own.
struct BaseBound {
  mat3 reference_from_render;
  vec3 center_m;
};
NEPHELE_CONST(
    float, kBaseBoundShare,
    1.9f);  // (1 - cut) over the half axis along `axis`: 4/3 has the least volume, 2 is the slab between plane and top

NEPHELE_FN BaseBound bound_above_base(mat3 reference_from_render, vec3 center_m, float base_m,
                                      float camera_altitude_m) {
  BaseBound bound;
  bound.reference_from_render = reference_from_render;
  bound.center_m = center_m;
  mat3 render_from_reference = inverse(reference_from_render);
  mat3 rows = transpose(render_from_reference);
  vec3 m = rows * normalize(center_m + vec3(0.0f, 0.0f, kPlanetRadiusM + camera_altitude_m));
  float extent_m = length(m);
  // The base curves away from the plane by this much at most, plus rounding.
  float slack_m = (dot(rows[0], rows[0]) + dot(rows[1], rows[1]) + dot(rows[2], rows[2])) * (0.5f / kPlanetRadiusM) +
                  0.05f + 1e-6f * length(center_m) + 1e-4f * extent_m;
  float cut = min((base_m - altitude_m(center_m, camera_altitude_m) - slack_m) / extent_m, 0.999f);
  if (!(cut > -0.85f)) return bound;  // below -0.9 the ellipsoid would lie inside the ball at the top
  vec3 axis = m / extent_m;
  float along = (1.0f - cut) / kBaseBoundShare;
  float across = sqrt((1.0f - cut * cut) / (kBaseBoundShare * (2.0f - kBaseBoundShare)));
  mat3 stretch = outerProduct(axis, axis) * (1.0f / along - 1.0f / across);
  for (int k = 0; k < 3; ++k) stretch[k][k] += 1.0f / across;
  bound.reference_from_render = stretch * reference_from_render;
  bound.center_m = center_m + render_from_reference * (axis * (1.0f - along));
  return bound;
}

// No point of an ellipsoid is nearer than this; extent_m is half its extent along the direction to its centre.
NEPHELE_FN float near_bound_m(vec3 center_m, float extent_m) {
  return max(0.99999f * length(center_m) - 1.00001f * extent_m, 0.0f);
}

NEPHELE_SHARED_END

#endif
