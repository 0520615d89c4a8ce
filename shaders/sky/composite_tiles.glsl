// The image's tiles of 8 x 8 pixels, sorted by what they may show: composite_tiles.comp makes the lists, composite.comp
// has a kernel for each kind.
#ifndef NEPHELE_COMPOSITE_TILES_GLSL
#define NEPHELE_COMPOSITE_TILES_GLSL

const uint kCompositeTilePx = 8u;
const uint kTileKinds = 5u;  // sky, sky with clouds, ground, ground with clouds, mixed
const uint kMixedKind = 4u;

struct CompositeGrid {
  uint columns, rows;
  uint groups_across;  // of a dispatch over a list; 1 unless the image is huge
};

// groups: indirect dispatches, one a kind.
#ifdef WRITES_COMPOSITE_TILES
layout(scalar, set = 0, binding = 19) buffer CompositeTiles {
#else
layout(scalar, set = 0, binding = 19) readonly buffer CompositeTiles {
#endif
  uvec3 tile_groups[kTileKinds];
  uint tile_counts[kTileKinds];
  vec3 sun_at_lens;     // the sun's irradiance at the camera, through air and clouds
  uint listed_tiles[];  // a kind after the other, room for all tiles each
};

bool find_composite_tile(CompositeGrid grid, uint kind, out uvec2 tile) {
  const uint place = gl_WorkGroupID.y * grid.groups_across + gl_WorkGroupID.x;
  const bool found = place < tile_counts[kind];
  const uint index = found ? listed_tiles[kind * grid.columns * grid.rows + place] : 0u;
  tile = uvec2(index % grid.columns, index / grid.columns);
  return found;
}

#endif
