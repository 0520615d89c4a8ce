// How far the rays of a tile of pixels go before any of them may meet the terrain: an arc, or kNoTerrainM.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "sky/terrain_arrays.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kTileRows = 4u;  // of pixels; a tile is 8 wide, as many as a CPU's batch
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(scalar, set = 0, binding = 4) writeonly buffer Begins { float begins[]; };

#include "kit/camera_rays.glsl"

// The rays between the corners of a tile. Along a border of it the elevation is no lower than at the corners but for a
// term of the second order, for which there is room.
TerrainBundle bundle_of(vec2 low_px, vec2 high_px) {
  const vec3 middle = pixel_direction(0.5 * (low_px + high_px), frame.image_size_px);
  TerrainBundle bundle;
  bundle.spread = -1.0;
  const float across = length(middle.xy);
  const vec2 azimuth = middle.xy / max(across, 1e-6);
  float lowest = 1e30, radius = 0.0, spread = 0.0, narrowest = 1.0;
  for (int i = 0; i < 4; ++i) {
    const vec3 corner = pixel_direction(mix(low_px, high_px, vec2(i & 1, i >> 1)), frame.image_size_px);
    const float corner_across = length(corner.xy);
    const vec2 turned = corner.xy / max(corner_across, 1e-6);
    lowest = min(lowest, corner.z / max(corner_across, 1e-6));
    radius = max(radius, length(corner - middle));
    spread = max(spread, length(turned - azimuth));
    narrowest = min(narrowest, corner_across);
  }
  // Next to the nadir azimuths are all over the place.
  if (narrowest < 8.0 * radius) return bundle;
  bundle.spread = 1.05 * spread + 1e-6;
  lowest -= radius * radius * (1.0 + lowest * lowest) * (1.0 + abs(lowest)) + 1e-6;
  bundle.lowest = terrain_ray(view, normalize(vec3(azimuth, lowest)));
  return bundle;
}

void main() {
  const uvec2 tiles = uvec2((frame.image_size_px.x + 7u) / 8u, (frame.image_size_px.y + kTileRows - 1u) / kTileRows);
  const uint i = gl_GlobalInvocationID.x;
  if (i >= tiles.x * tiles.y) return;
  const vec2 low_px = vec2(i % tiles.x, i / tiles.x) * vec2(8.0, float(kTileRows));
  begins[i] = bundle_begin_arc_m(Terrain(view), bundle_of(low_px, low_px + vec2(8.0, float(kTileRows))));
}
