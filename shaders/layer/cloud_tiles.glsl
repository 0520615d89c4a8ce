// What the shaders of a screen tile share: bindings, and the search through the tile's list. The including shader
// includes exact_blend.h or blend.h, screen_bounds.h and types.h before.
#ifndef NEPHELE_CLOUD_TILES_GLSL
#define NEPHELE_CLOUD_TILES_GLSL

#include "kit/texels.glsl"

layout(constant_id = 1) const bool kListed = false;  // work on the tiles of TileRows; otherwise on all with short lists
layout(constant_id = 2) const uint kShortList = kColumnPlaces;  // the longest of these
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
DRAW_PARTICLES(1, draw_particles);
layout(scalar, set = 0, binding = 5) readonly buffer Ranges { uvec2 ranges[]; };
WORDS(6, list);  // particles, a tile's after the other's
WORDS(7, begins_m);
layout(scalar, set = 0, binding = 8) buffer Counters { FrameCounters counters; };
layout(set = 0, binding = 9, rgba32f) writeonly uniform image2D layer_color;  // premultiplied radiance, transmittance
layout(set = 0, binding = 10, r32f) writeonly uniform image2D layer_depth;    // metres to the first matter, +inf
layout(set = 0, binding = 11) uniform sampler2D layer_scene;                  // metres to what stands behind
// Written by screen_begins.comp.
layout(scalar, set = 0, binding = 12) readonly buffer TileRows {
  uvec3 tile_groups;
  uint tile_rows[];
};
WORDS(13, masks);  // two words a place: the pixels that it may show in

#include "layer/cloud_shade.glsl"
#include "layer/driver_limit.glsl"

bool place_covers(uint place, uvec2 in_tile) {
  return ((word_at(masks, 2u * place + (in_tile.y >> 2u)) >> (kScreenTilePx * (in_tile.y & 3u) + in_tile.x)) & 1u) !=
         0u;
}

// The first place from `at` on whose particle may cover the pixel: one load a place. Eight threads that a CPU runs in
// step each find their next particle this way, one place at a time, and then shade all eight particles together.
uint next_place(uint at, uint end, uvec2 in_tile) {
  while (at < end && !place_covers(at, in_tile)) ++at;
  return at;
}

// The tile of this workgroup and its list; false when there is nothing for it to do. A CPU goes through all of a
// shader's code even then, so tiles with long lists, mostly few, have a dispatch of just as many groups.
bool find_tile(out uvec2 tile, out uvec2 range) {
  tile = gl_WorkGroupID.xy;
  range = uvec2(0u);
  const uint columns = (frame.layer_size_px.x + kScreenTilePx - 1u) / kScreenTilePx;
  if (kListed) {
    if (tile.x >= tile_rows[tile.y]) return false;
    tile.x = tile_rows[gl_NumWorkGroups.y + tile.y * columns + tile.x];
  }
  range = ranges[tile.y * columns + tile.x];
  return kListed || range.y - range.x <= kShortList;
}

// To be called last, with the (pixel, particle) pairs that this thread has shaded. Lists are cut into pages so that the
// driver's limit is not reached; should it be, it is counted.
void count_work(uint shaded) {
  if (shaded > 0u) atomicAdd(counters.pairs_shaded, shaded);
  if (loops_were_ended(1u + frame.scale)) atomicAdd(counters.rays_cut_short, 1u);
}

// The metres to the first matter as the layer holds them: +inf without.
vec4 first_matter(float first_m) { return vec4(first_m < kNoMatterM ? first_m : uintBitsToFloat(0x7f800000u)); }

#endif
