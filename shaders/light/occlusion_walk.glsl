// Traversal of the light tiles' lists ([Yusov14] 5.3 step 2). The including shader declares, before this:
// FrameConstants frame; OCCLUDERS occluders; WORDS ranges, list.
#ifndef NEPHELE_OCCLUSION_WALK_GLSL
#define NEPHELE_OCCLUSION_WALK_GLSL

#include "light/occluders.glsl"

uint light_tile_at(vec3 at_m) { return light_tile_index(light_tile(at_m.xy, frame.view_distance_m)); }

// The element of a small array, without memory: eight threads of a CPU index it differently.
uint pick(uint values[5], uint k) {
  uint value = values[0];
  for (uint j = 1u; j < 5u; ++j) value = k == j ? values[j] : value;
  return value;
}
float pick(float values[5], uint k) {
  float value = values[0];
  for (uint j = 1u; j < 5u; ++j) value = k == j ? values[j] : value;
  return value;
}

// What lies towards the sun from a particle, itself left out.
struct SunColumn {
  float depths[4];  // optical depth from four points, each at most kMaxSunOpticalDepth
  float near;       // of the cloud around the centre, towards the sun; what is far off fades out
  float behind;     // the same on the side away from the sun
};

// One loop for all points, which goes from a list to the next: eight threads of a CPU run in step, and with a loop a
// list all would wait for the longest of each. Points that share a tile share the walk through its list. What the next
// list needs is at hand before, since every round pays for the step to it.
SunColumn sun_column(vec3 points_m[4], vec3 center_m, uint except) {
  const uint kCenter = 4u;
  const vec3 up = frame.light_from_render[2];
  vec3 at_m[5];
  uint tiles[5], begins[5], ends[5], sharers[5];  // the last: bits of the points that walk along
  float stops_m[5];
  SunColumn column;
  for (uint j = 0u; j < 5u; ++j) {
    at_m[j] = frame.light_from_render * (j == kCenter ? center_m : points_m[j]);
    tiles[j] = light_tile_at(at_m[j]);
    stops_m[j] = sun_stop_m(at_m[j].z - (j == kCenter ? kColumnReachM : 0.0), frame.view_distance_m);
    if (j < kCenter) column.depths[j] = 0.0;
  }
  column.near = column.behind = 0.0;
  uint left = 0u;  // bits of the points that begin a list
  for (uint k = 0u; k < 5u; ++k) {
    const uvec2 range = two_words_at(ranges, tiles[k]);
    begins[k] = range.x;
    ends[k] = range.y;
    sharers[k] = 0u;
    bool first = range.x < range.y;
    for (uint j = 0u; j < 5u; ++j) {
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
    for (uint j = 0u; j < kCenter; ++j)
      if ((here & (1u << j)) != 0u) {
        column.depths[j] += occluder_depth(occluder, at_m[j], up);
        least = min(least, column.depths[j]);
      }
    if ((here & (1u << kCenter)) == 0u) {
      if (least >= kMaxSunOpticalDepth) end = i;
    } else {
      const float weight = 1.0 - smoothstep(0.5, 1.0, abs(occluder.center_m.z - at_m[kCenter].z) / kColumnReachM);
      const float sunward = occluder_depth(occluder, at_m[kCenter], up);
      const float whole = occluder_depth(occluder, vec3(at_m[kCenter].xy, occluder.center_m.z - 1.0e6), up);
      column.near += weight * sunward;
      column.behind += weight * max(whole - sunward, 0.0);
    }
  }
  for (uint j = 0u; j < kCenter; ++j) column.depths[j] = min(column.depths[j], kMaxSunOpticalDepth);
  column.near = min(column.near, kMaxSunOpticalDepth);
  column.behind = min(column.behind, kMaxSunOpticalDepth);
  return column;
}

// What is around a particle: opacities of a short way at four points about it.
struct Neighbourhood {
  float enclosure;  // how much of it is cloud, kLeastEnclosure .. 1
  vec3 openness;    // as in ParticleLight: minus the gradient of those opacities
};

Neighbourhood neighbourhood(Particle particle) {
  const vec3 up = frame.light_from_render[2];
  float extinction[4];
  vec3 points_m[4];
  float stops_m[5];
  uint begins[5], ends[5];
  uint left = 0u;
  begins[4] = ends[4] = 0u;
  stops_m[4] = 0.0;
  for (uint j = 0u; j < 4u; ++j) {
    points_m[j] = frame.light_from_render * particle_point(particle, -kNeighbourRadius * tetrahedron_corner(j));
    stops_m[j] = sun_stop_m(points_m[j].z, frame.view_distance_m);
    const uvec2 range = two_words_at(ranges, light_tile_at(points_m[j]));
    begins[j] = range.x;
    ends[j] = range.y;
    left |= range.x < range.y ? 1u << j : 0u;
    extinction[j] = 0.0;
  }
  uint point = 0u, i = 0u, end = 0u;
  float stop_m = 0.0;
  vec3 at_m = vec3(0.0);
  for (;;) {  // one loop for all lists, as above
    if (i >= end && left != 0u) {
      point = uint(findLSB(left));
      left &= left - 1u;
      for (uint j = 0u; j < 4u; ++j) at_m = point == j ? points_m[j] : at_m;
      stop_m = pick(stops_m, point);
      i = pick(begins, point);
      end = pick(ends, point);
    }
    if (i >= end) break;
    const Occluder occluder = occluder_at(occluders, word_at(list, i++));
    if (occluder.top_m < stop_m) end = i;
    const float more = occluder.top_m < stop_m ? 0.0 : occluder_extinction(occluder, at_m, up);
    for (uint j = 0u; j < 4u; ++j) extinction[j] += point == j ? more : 0.0;
  }
  const float way_m = kNeighbourWay * pow(particle.radius_m.x * particle.radius_m.y * particle.radius_m.z, 1.0 / 3.0);
  float sum = 0.0;
  vec3 away = vec3(0.0);
  for (uint j = 0u; j < 4u; ++j) {
    const float opacity = 1.0 - exp(-way_m * extinction[j]);
    sum += opacity;
    away += opacity * tetrahedron_corner(j);
  }
  return Neighbourhood(mix(kLeastEnclosure, 1.0, 0.25 * sum), render_from_local(0.75 * away, particle.yaw_rad));
}

#endif
