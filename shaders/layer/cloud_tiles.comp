// Shades and blends one screen tile's particles, a pixel a thread, no shared memory: all short lists on a GPU, long
// ones on a CPU as well (short ones there: cloud_columns.comp).
// variants: volume=BLEND_VOLUME exact=BLEND_EXACT exact_long=BLEND_EXACT,EXACT_LONG_LISTS
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifdef EXACT_LONG_LISTS
#define EXACT_SLOTS 32
#endif
#include "shared/exact_blend.h"
#include "shared/screen_bounds.h"
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kExactPlaces =
    1u;  // that a pixel of the exact blend may go through, before it merges
#include "layer/cloud_tiles.glsl"

// A pixel's walk through its tile's list. walk_next steps to the next place to shade, false when the pixel is done;
// walk_take takes what was shaded there.
#ifdef BLEND_VOLUME

// blend.h folds from back to front, so segments are kept on the way forward and folded on the way back. The way ends
// where all that is left begins behind opaque matter. Past kKept segments the rest is only measured on the way forward
// and shaded once more on the way back, and past kMeasured places not even measured.
const uint kKept = 32u;
const uint kMeasured = 1024u;
BlendSegment kept[kKept];

struct Walk {
  uvec2 range;
  uint place, kept_count;
  uint again_first, again_end;  // places to be shaded again
  bool started, backward;
  OpaqueFront front;
  BlendState state;
};

Walk walk_begin(uvec2 range) {
  return Walk(range, range.x, 0u, 0u, 0u, false, false, opaque_front_empty(), blend_empty());
}

bool walk_next(inout Walk walk, uvec2 in_tile) {
  if (!walk.backward) {
    walk.place = next_place(walk.started ? walk.place + 1u : walk.place, walk.range.y, in_tile);
    walk.started = true;
    if (walk.place - walk.range.x > kMeasured && walk.again_end > 0u) {
      walk.again_end = walk.range.y;
    } else if (walk.place < walk.range.y && !opaque_front_hides(walk.front, float_at(begins_m, walk.place))) {
      return true;
    }
    walk.backward = true;
    walk.place = walk.again_end;
  }
  while (walk.place > walk.again_first) {
    --walk.place;
    if (place_covers(walk.place, in_tile)) return true;
  }
  while (walk.kept_count > 0u) blend_add(walk.state, kept[--walk.kept_count]);
  blend_finish(walk.state);
  return false;
}

void walk_take(inout Walk walk, BlendSegment segment) {
  if (walk.backward) {
    blend_add(walk.state, segment);
    return;
  }
  opaque_front_add(walk.front, segment);
  if (walk.kept_count < kKept) {
    kept[walk.kept_count++] = segment;
  } else {
    if (walk.again_end == 0u) walk.again_first = walk.place;
    walk.again_end = walk.place + 1u;
  }
}

vec4 walk_color(Walk walk) { return vec4(walk.state.committed, walk.state.transmittance); }
float walk_first_m(Walk walk) { return walk.state.first_m; }

#else

// exact_blend.h: the list runs by nearest points, so what is in front of the next one's is final.
struct Walk {
  uvec2 range;
  uint place, passed;  // places of earlier stretches
  bool started;
  ExactState state;
};

Walk walk_begin(uvec2 range) { return Walk(range, range.x, 0u, false, exact_empty()); }

bool walk_next(inout Walk walk, uvec2 in_tile) {
  walk.place = next_place(walk.started ? walk.place + 1u : walk.place, walk.range.y, in_tile);
  walk.started = true;
  const float begin_m = walk.place < walk.range.y ? float_at(begins_m, walk.place) : kNoMatterM;
  exact_advance(walk.state, begin_m);
  if (walk.state.transmittance < kOpaqueTransmittance) return false;
  if (begin_m < walk.state.horizon_m) return true;
  if (!exact_next_stretch(walk.state)) return false;
  walk.passed += walk.place - walk.range.x;
  walk.state.merges = walk.passed + 2u * (walk.range.y - walk.range.x) > kExactPlaces;
  walk.place = next_place(walk.range.x, walk.range.y, in_tile);
  return true;
}

void walk_take(inout Walk walk, BlendSegment segment) { exact_add(walk.state, segment); }

vec4 walk_color(Walk walk) { return vec4(walk.state.radiance, walk.state.transmittance); }
float walk_first_m(Walk walk) { return walk.state.first_m; }

#endif

void main() {
  uvec2 tile, range;
  if (!find_tile(tile, range)) return;
  const uvec2 in_tile = uvec2(gl_LocalInvocationID.x % kScreenTilePx, gl_LocalInvocationID.x / kScreenTilePx);
  const uvec2 pixel = tile * kScreenTilePx + in_tile;
  if (any(greaterThanEqual(pixel, frame.layer_size_px))) return;
  const vec3 direction = pixel_direction((vec2(pixel) + 0.5) * float(frame.scale), frame.image_size_px);
  const float limit_m = texelFetch(layer_scene, ivec2(pixel), 0).x;
  uint shaded = 0u;
  Walk walk = walk_begin(range);
  while (walk_next(walk, in_tile)) {
    BlendSegment segment;
    if (shade_particle(draw_particle_at(draw_particles, word_at(list, walk.place)), direction, limit_m, segment)) {
      walk_take(walk, segment);
      ++shaded;
    }
  }
  imageStore(layer_color, ivec2(pixel), walk_color(walk));
  imageStore(layer_depth, ivec2(pixel), first_matter(walk_first_m(walk)));
  count_work(shaded);
}
