// Shades and blends the tiles with lists of several pages, a page a dispatch, a pixel a thread. What a pixel has
// blended so far waits in a buffer for the next page, so a list may have any length (kPagePlaces in screen_bounds.h).
// All threads go through the list in step, a place a round.
//
// volume: blend.h folds from back to front, so page 0 is the list's end and none is left out.
// exact: page 0 is the list's beginning. No page is gone through twice, so segments past the slots merge
// (exact_blend.h).
// variants: volume=BLEND_VOLUME exact=BLEND_EXACT
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/exact_blend.h"
#include "shared/screen_bounds.h"
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant) uniform Push { uint page; };
#include "layer/cloud_tiles.glsl"

#ifdef BLEND_VOLUME
#include "layer/blend_state.glsl"

struct PagedPixel {
  vec4 open, extent, committed;
};
layout(scalar, set = 0, binding = 14) buffer PagedPixels { PagedPixel paged_pixels[]; };

// Blends the page's places; true when the ray is done.
bool blend_page(uint slot, uvec2 range, vec3 direction, float limit_m, out vec4 color, out float first_m,
                inout uint shaded) {
  const uint past = range.y - page * kPagePlaces;
  const uint first = max(past, range.x + kPagePlaces) - kPagePlaces;
  BlendState state = blend_empty();
  if (page > 0u)
    state = unpack_blend_state(paged_pixels[slot].open, paged_pixels[slot].extent, paged_pixels[slot].committed);
  for (uint place = past; place-- > first;) {
    if (!place_covers(place, gl_LocalInvocationID.xy)) continue;
    BlendSegment segment;
    if (!shade_particle(draw_particle_at(draw_particles, word_at(list, place)), direction, limit_m, segment)) continue;
    blend_add(state, segment);
    ++shaded;
  }
  if (first == range.x) blend_finish(state);
  pack_blend_state(state, paged_pixels[slot].open, paged_pixels[slot].extent, paged_pixels[slot].committed);
  color = vec4(state.committed, state.transmittance);
  first_m = state.first_m;
  return first == range.x;
}

#else

struct PagedPixel {
  vec3 radiance;
  float transmittance, first_m, cursor_m;
  BlendSegment waiting[kExactSlots];
};
layout(scalar, set = 0, binding = 14) buffer PagedPixels { PagedPixel paged_pixels[]; };

ExactState load_state(uint slot) {
  ExactState state = exact_empty();
  state.merges = true;
  if (page == 0u) return state;
  state.radiance = paged_pixels[slot].radiance;
  state.transmittance = paged_pixels[slot].transmittance;
  state.first_m = paged_pixels[slot].first_m;
  state.cursor_m = paged_pixels[slot].cursor_m;
  for (int k = 0; k < kExactSlots; ++k) state.waiting[k] = paged_pixels[slot].waiting[k];
  return state;
}

void store_state(uint slot, ExactState state) {
  paged_pixels[slot].radiance = state.radiance;
  paged_pixels[slot].transmittance = state.transmittance;
  paged_pixels[slot].first_m = state.first_m;
  paged_pixels[slot].cursor_m = state.cursor_m;
  for (int k = 0; k < kExactSlots; ++k) paged_pixels[slot].waiting[k] = state.waiting[k];
}

// Blends the page's places; true when the ray is done.
bool blend_page(uint slot, uvec2 range, vec3 direction, float limit_m, out vec4 color, out float first_m,
                inout uint shaded) {
  const uint first = range.x + page * kPagePlaces;
  const uint past = min(first + kPagePlaces, range.y);
  ExactState state = load_state(slot);
  for (uint place = first; place < past && state.transmittance >= kOpaqueTransmittance; ++place) {
    exact_advance(state, float_at(begins_m, place));
    if (!place_covers(place, gl_LocalInvocationID.xy)) continue;
    BlendSegment segment;
    if (!shade_particle(draw_particle_at(draw_particles, word_at(list, place)), direction, limit_m, segment)) continue;
    exact_add(state, segment);
    ++shaded;
  }
  if (past == range.y) exact_advance(state, kNoMatterM);
  store_state(slot, state);
  color = vec4(state.radiance, state.transmittance);
  first_m = state.first_m;
  return past == range.y;
}

#endif

void main() {
  uvec2 tile, range;
  if (!find_tile(tile, range) || page * kPagePlaces >= range.y - range.x) return;
  const uvec2 pixel = tile * kScreenTilePx + gl_LocalInvocationID.xy;
  if (any(greaterThanEqual(pixel, frame.layer_size_px))) return;
  // No two lists of more than a page begin within the same page's length of the list of all.
  const uint slot = range.x / kPagePlaces * (kScreenTilePx * kScreenTilePx) + gl_LocalInvocationIndex;
  const vec3 direction = pixel_direction((vec2(pixel) + 0.5) * float(frame.scale), frame.image_size_px);
  uint shaded = 0u;
  vec4 color;
  float first_m;
  if (blend_page(slot, range, direction, texelFetch(layer_scene, ivec2(pixel), 0).x, color, first_m, shaded)) {
    imageStore(layer_color, ivec2(pixel), color);
    imageStore(layer_depth, ivec2(pixel), first_matter(first_m));
  }
  count_work(shaded);
}
