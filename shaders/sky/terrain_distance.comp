// Where each pixel's ray meets the terrain, or what the host has drawn before it.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "sky/terrain_arrays.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(constant_id = 0) const uint kTileRows = 4u;  // as in terrain_begin.comp
layout(set = 0, binding = 4) uniform sampler2D host_distance;
layout(set = 0, binding = 5, r32f) writeonly uniform image2D distance_m;  // along the ray, +inf without a surface

WORDS(6, begins);  // arcs before which no ray of a tile meets anything

#include "kit/camera_rays.glsl"

void main() {
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(pixel, frame.image_size_px))) return;
  const uint columns = (frame.image_size_px.x + 7u) / 8u;
  const float begin_m = float_at(begins, pixel.y / kTileRows * columns + pixel.x / 8u);
  float nearest_m = uintBitsToFloat(0x7f800000u);
  if (begin_m < kNoTerrainM) {
    const TerrainRay ray = terrain_ray(view, pixel_direction(vec2(pixel) + 0.5, frame.image_size_px));
    const float arc_m = terrain_hit_arc_m(Terrain(view), ray, begin_m);
    if (arc_m >= 0.0) nearest_m = ray_distance_at_arc(ray, arc_m);
  }
  if (view.has_host != 0u) {
    const float host_m = texelFetch(host_distance, ivec2(pixel), 0).x;
    if (host_m >= 0.0) nearest_m = min(nearest_m, host_m);
  }
  imageStore(distance_m, ivec2(pixel), vec4(nearest_m));
}
