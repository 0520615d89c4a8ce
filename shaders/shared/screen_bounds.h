// Where an ellipsoid can show on the screen and how near it can come: conservative bounds for the screen tile lists.
// After: Sigg et al., GPU-Based Ray-Casting of Quadratic Surfaces, 2006 (tangent planes of a quadric).
#ifndef NEPHELE_SHARED_SCREEN_BOUNDS_H
#define NEPHELE_SHARED_SCREEN_BOUNDS_H

#include "prelude.h"
#include "tile_rectangle.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kScreenTilePx, 8u);
// Lists up to this length take fewer slots in the exact blend, and on a CPU a column of pixels a thread.
NEPHELE_CONST(uint, kShortList, 128u);
// Longer lists are shaded in pages of this many places, a dispatch each: lavapipe ends all loops of eight threads once they
// have gone round 65 535 times in all, and a place takes them some five rounds, up to twice.
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

// Shorter half chords of a particle with fine detail show nothing (cloud_shade.glsl): their mean density is a few
// hundredths of the peak at most. So of its unit sphere only what lies within this radius shows.
NEPHELE_CONST(float, kRimFrom, 0.3f);
NEPHELE_CONST(float, kRimRadius, 0.9539392f);  // sqrt(1 - kRimFrom^2)

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
  if (dot(w, center_m) + 1.00001f * length(transpose(render_from_reference) * w) < 0.0f) return kNoTiles;  // behind the eye
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
  return tile_rectangle(rectangle_low(pixels) / kScreenTilePx, (rectangle_high(pixels) + (kScreenTilePx - 1u)) / kScreenTilePx);
}

// One place of a tile's list: the particle in 20 bits, then the first and the last column and row that it may cover
// there, 3 bits each.
NEPHELE_CONST(uint, kMaxScreenParticles, 1048576u);

NEPHELE_FN uint tile_entry(uint particle, uvec2 pixels, uvec2 tile) {
  uvec2 low = max(rectangle_low(pixels), tile * kScreenTilePx) - tile * kScreenTilePx;
  uvec2 last = min(rectangle_high(pixels), (tile + 1u) * kScreenTilePx) - 1u - tile * kScreenTilePx;
  return particle | (low.x << 20u) | (low.y << 23u) | (last.x << 26u) | (last.y << 29u);
}

NEPHELE_FN uint entry_particle(uint entry) { return entry & (kMaxScreenParticles - 1u); }

NEPHELE_FN bool entry_covers(uint entry, uvec2 pixel_in_tile) {
  return pixel_in_tile.x >= ((entry >> 20u) & 7u) && pixel_in_tile.y >= ((entry >> 23u) & 7u) &&
         pixel_in_tile.x <= ((entry >> 26u) & 7u) && pixel_in_tile.y <= (entry >> 29u);
}

// No point of an ellipsoid is nearer than this; extent_m is half its extent along the direction to its centre.
NEPHELE_FN float near_bound_m(vec3 center_m, float extent_m) {
  return max(0.99999f * length(center_m) - 1.00001f * extent_m, 0.0f);
}

NEPHELE_SHARED_END

#endif
