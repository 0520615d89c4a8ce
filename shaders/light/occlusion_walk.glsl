// Traversal of the light tiles' lists ([Yusov14] 5.3 step 2). The including shader declares, before this:
// FrameConstants frame; OCCLUDERS occluders; WORDS ranges, list.
#ifndef NEPHELE_OCCLUSION_WALK_GLSL
#define NEPHELE_OCCLUSION_WALK_GLSL

#include "light/occluders.glsl"

uint light_tile_at(vec3 at_m) { return light_tile_index(light_tile(at_m.xy, frame.view_distance_m)); }

// The element of a small array, without memory: eight threads of a CPU index it differently.
uint pick(uint values[4], uint k) {
  uint value = values[0];
  for (uint j = 1u; j < 4u; ++j) value = k == j ? values[j] : value;
  return value;
}
float pick(float values[4], uint k) {
  float value = values[0];
  for (uint j = 1u; j < 4u; ++j) value = k == j ? values[j] : value;
  return value;
}

// Optical depths towards the sun from four points of a particle through all others, each at most kMaxSunOpticalDepth;
// 0 where they are not wanted.
// One loop for all points, which goes from a list to the next: eight threads of a CPU run in step, and with a loop a
// list all would wait for the longest of each. Points that share a tile share the walk through its list. What the next
// list needs is at hand before, since every round pays for the step to it.
float[4] depths_to_sun(vec3 points_m[4], uint except, bool wanted) {
  const vec3 up = frame.light_from_render[2];
  vec3 at_m[4];
  uint tiles[4], begins[4], ends[4], sharers[4];  // the last: bits of the points that walk along
  float stops_m[4], depths[4];
  for (uint j = 0u; j < 4u; ++j) {
    at_m[j] = frame.light_from_render * points_m[j];
    tiles[j] = light_tile_at(at_m[j]);
    stops_m[j] = sun_stop_m(at_m[j].z, frame.view_distance_m);
    depths[j] = 0.0;
  }
  uint left = 0u;  // bits of the points that begin a list
  for (uint k = 0u; k < 4u; ++k) {
    const uvec2 range = two_words_at(ranges, tiles[k]);
    begins[k] = range.x;
    ends[k] = range.y;
    sharers[k] = 0u;
    bool first = wanted && range.x < range.y;
    for (uint j = 0u; j < 4u; ++j) {
      const bool same = tiles[j] == tiles[k];
      if (j < k) first = first && !same;
      sharers[k] |= same ? 1u << j : 0u;
      if (j > k) stops_m[k] = same ? min(stops_m[k], stops_m[j]) : stops_m[k];
    }
    left |= first ? 1u << k : 0u;
  }

  uint here = 0u, i = 0u, end = 0u;
  float stop_m = 0.0;
  for (;;) {
    if (i >= end && left != 0u) {
      const uint k = uint(findLSB(left));
      left &= left - 1u;
      here = pick(sharers, k);
      stop_m = pick(stops_m, k);
      i = pick(begins, k);
      end = pick(ends, k);
    }
    if (i >= end) break;
    const uint index = word_at(list, i++);
    const Occluder occluder = occluder_at(occluders, index);
    if (occluder.top_m < stop_m) end = i;  // and so are all that follow
    if (occluder.top_m < stop_m || index == except) continue;
    float least = kMaxSunOpticalDepth;
    for (uint j = 0u; j < 4u; ++j)
      if ((here & (1u << j)) != 0u) {
        depths[j] += occluder_depth(occluder, at_m[j], up);
        least = min(least, depths[j]);
      }
    if (least >= kMaxSunOpticalDepth) end = i;
  }
  for (uint j = 0u; j < 4u; ++j) depths[j] = min(depths[j], kMaxSunOpticalDepth);
  return depths;
}

#endif
