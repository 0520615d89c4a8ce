#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Sorts the image's tiles by what they may show: sky or ground alone or anything, clouds or none. One thread a tile.
// The order within a list is free; no pixel depends on it.
#include "shared/atmosphere_tables.h"
#include "shared/ground.h"
#include "shared/types.h"
#define WRITES_COMPOSITE_TILES
#include "sky/composite_tiles.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 2) const bool kClouds = true;  // as in composite.comp
layout(set = 0, binding = 0, scalar) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 9) uniform sampler2D layer_depth;  // a dummy without clouds
layout(push_constant, scalar) uniform Push { CompositeGrid grid; };

#include "kit/camera_rays.glsl"

// Whether clouds may show in the tile: in any pixel of the layer that one of the image's draws upon.
bool has_clouds(uvec2 tile) {
  if (!kClouds) return false;
  const int scale = int(frame.scale);
  const int from_neighbour = scale > 1 ? 1 : 0;
  const ivec2 first = ivec2(tile * kCompositeTilePx) / scale - from_neighbour;
  const int side = int(kCompositeTilePx) / scale + 2 * from_neighbour;  // even
  float nearest_m = uintBitsToFloat(0x7f800000u);
  for (int y = 1; y < side; y += 2)
    for (int x = 1; x < side; x += 2) {
      const vec4 four_m = textureGather(layer_depth, vec2(first + ivec2(x, y)) / vec2(frame.layer_size_px));
      nearest_m = min(nearest_m, min(min(four_m.x, four_m.y), min(four_m.z, four_m.w)));
    }
  return !isinf(nearest_m);
}

// Sky or ground alone, with what a pixel blurs and what the upscaling takes for an edge kept off the horizon; where the
// sun's disc may be, mixed.
uint ground_or_sky(uvec2 tile) {
  const vec2 center_px = (vec2(tile) + 0.5) * float(kCompositeTilePx);
  const vec3 center = pixel_direction(center_px, frame.image_size_px);
  float radius = 0.0;  // of the tile, as a chord of the unit sphere
  for (int i = 0; i < 4; ++i) {
    const vec2 corner_px = center_px + (vec2(i & 1, i >> 1) - 0.5) * float(kCompositeTilePx);
    radius = max(radius, length(pixel_direction(corner_px, frame.image_size_px) - center));
  }
  const float edge = (frame.scale > 1u ? 0.5 * float(frame.scale) : 0.25) * radius;
  const float over = center.z - horizon_cosine(max(0.0, frame.camera_grid_m.z));
  if (over > radius + edge)
    return length(center - frame.sun_direction) < frame.sun_angular_radius_rad + 2.0 * radius ? kMixedKind : 0u;
  return over < -(radius + edge) && frame.ground_enabled != 0u ? 2u : kMixedKind;
}

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= grid.columns * grid.rows) return;
  const uvec2 tile = uvec2(i % grid.columns, i / grid.columns);
  uint kind = frame.host_scene != 0u ? kMixedKind : ground_or_sky(tile);
  if (kind != kMixedKind && has_clouds(tile)) ++kind;
  const uint place = atomicAdd(tile_counts[kind], 1u);
  listed_tiles[kind * grid.columns * grid.rows + place] = i;
  atomicMax(tile_groups[kind].y, place / grid.groups_across + 1u);
}
