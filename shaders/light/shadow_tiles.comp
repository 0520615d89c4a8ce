#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Lists the light tiles that a look-up from the camera's view can reach: those whose sun rays cross the view's cone,
// and the grid's border, which stands for everything beyond it. One thread a tile; the order is free.
#include "shared/light.h"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kTexelsPerTile = 2u;  // as in cloud_shadow.comp

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(scalar, set = 0, binding = 1) buffer ShadowTiles {
  uvec3 tile_groups;
  uint tile_count;
  uint shadow_tiles[];
};

#include "kit/camera_rays.glsl"

float cross2(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// Across the sun's rays the view is a wedge at the origin, between two of the image's corners, or the whole plane when
// the sun's axis is in view. A tile is out of it where all of it, and a tile around, lies beyond one of the wedge's
// sides.
bool in_view(uvec2 tile) {
  const vec2 size = vec2(frame.image_size_px);
  vec2 view[4], corner[4];
  for (int k = 0; k < 4; ++k) {
    const vec2 unit = vec2(k & 1, k >> 1);
    view[k] = (frame.light_from_render * pixel_direction(unit * size, frame.image_size_px)).xy;
    corner[k] = light_across((vec2(tile) - 1.0 + 3.0 * unit) / float(kLightTiles), frame.view_distance_m);
  }
  bool out_of_view = false;
  for (int k = 0; k < 4; ++k) {
    bool first = true, last = true;     // all of the view lies to the left of this corner, or to the right
    bool before = true, behind = true;  // so does the tile
    for (int j = 0; j < 4; ++j) {
      first = first && cross2(view[k], view[j]) >= 0.0;
      last = last && cross2(view[k], view[j]) <= 0.0;
      before = before && cross2(view[k], corner[j]) < 0.0;
      behind = behind && cross2(view[k], corner[j]) > 0.0;
    }
    out_of_view = out_of_view || (first && before) || (last && behind);
  }
  return !out_of_view;
}

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= kLightTiles * kLightTiles) return;
  const uvec2 tile = uvec2(i % kLightTiles, i / kLightTiles);
  const bool border = any(equal(tile, uvec2(0u))) || any(equal(tile, uvec2(kLightTiles - 1u)));
  if (frame.culling_enabled != 0u && !border && !in_view(tile)) return;
  const uint place = atomicAdd(tile_count, 1u);
  shadow_tiles[place] = i;
  atomicMax(tile_groups.x, place * kTexelsPerTile * kTexelsPerTile / 64u + 1u);
}
