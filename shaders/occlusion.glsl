// Traversal of the light tiles' lists ([Yusov14] 5.3 step 2). The including shader declares, before this:
// FrameConstants frame; Occluder occluders[]; uvec2 ranges[]; uint list[].
#ifndef NEPHELE_OCCLUSION_GLSL
#define NEPHELE_OCCLUSION_GLSL

#include "shared/light.h"

const uint kNoParticle = 0xFFFFFFFFu;

// Optical depths towards the sun at four points of render space, through every particle but one, at most
// kMaxSunOpticalDepth; and the extinctions there, which are incomplete where the depth has reached that end.
// Points that share a tile share one walk through its list.
void sun_depths(vec3 points_m[4], uint except, out float depths[4], out float extinctions_per_m[4]) {
  const vec3 up = frame.light_from_render[2];
  vec3 at_m[4];
  uint tiles[4];
  float stops_m[4];
  for (uint j = 0u; j < 4u; ++j) {
    at_m[j] = frame.light_from_render * points_m[j];
    tiles[j] = light_tile_index(light_tile(at_m[j].xy, frame.view_distance_m));
    stops_m[j] = sun_stop_m(at_m[j].z, frame.view_distance_m);
    depths[j] = 0.0;
    extinctions_per_m[j] = 0.0;
  }

  uint walked = 0u;  // one bit a point
  for (uint k = 0u; k < 4u; ++k) {
    if ((walked & (1u << k)) != 0u) continue;
    float stop_m = stops_m[k];
    bool here[4];
    for (uint j = 0u; j < 4u; ++j) {
      here[j] = tiles[j] == tiles[k];
      stop_m = here[j] ? min(stop_m, stops_m[j]) : stop_m;
      walked |= here[j] ? 1u << j : 0u;
    }
    const uvec2 range = ranges[tiles[k]];
    for (uint i = range.x; i < range.y; ++i) {
      const uint index = list[i];
      if (occluders[index].top_m < stop_m) break;
      if (index == except) continue;
      const Occluder occluder = occluders[index];
      float least = kMaxSunOpticalDepth;
      for (uint j = 0u; j < 4u; ++j)
        if (here[j]) {
          depths[j] += occluder_depth(occluder, at_m[j], up);
          extinctions_per_m[j] += occluder_extinction(occluder, at_m[j], up);
          least = min(least, depths[j]);
        }
      if (least >= kMaxSunOpticalDepth) break;
    }
  }
  for (uint j = 0u; j < 4u; ++j) depths[j] = min(depths[j], kMaxSunOpticalDepth);
}

#endif
