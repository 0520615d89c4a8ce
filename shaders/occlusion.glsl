// Traversal of the light tiles' lists ([Yusov14] 5.3 step 2). The including shader declares, before this:
// FrameConstants frame; Occluder occluders[]; uvec2 ranges[]; uint list[].
#ifndef NEPHELE_OCCLUSION_GLSL
#define NEPHELE_OCCLUSION_GLSL

#include "shared/light.h"

const uint kNoParticle = 0xFFFFFFFFu;

// Optical depths towards the sun at four points of render space, through every particle but one, at most
// kMaxSunOpticalDepth. Points that share a tile share one walk through its list.
void sun_depths(vec3 points_m[4], uint except, out float depths[4]) {
  const vec3 up = frame.light_from_render[2];
  vec3 at_m[4];
  uint tiles[4];
  float stops_m[4];
  for (uint j = 0u; j < 4u; ++j) {
    at_m[j] = frame.light_from_render * points_m[j];
    tiles[j] = light_tile_index(light_tile(at_m[j].xy, frame.view_distance_m));
    stops_m[j] = sun_stop_m(at_m[j].z, frame.view_distance_m);
    depths[j] = 0.0;
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
          least = min(least, depths[j]);
        }
      if (least >= kMaxSunOpticalDepth) break;
    }
  }
  for (uint j = 0u; j < 4u; ++j) depths[j] = min(depths[j], kMaxSunOpticalDepth);
}

// The cloud around a point of render space along the sun's ray, without one particle: its optical depth towards the sun
// and away from it. What is far off fades out.
vec2 near_column(vec3 p_render_m, uint except) {
  const vec3 up = frame.light_from_render[2];
  const vec3 at_m = frame.light_from_render * p_render_m;
  const float stop_m = sun_stop_m(at_m.z - kColumnReachM, frame.view_distance_m);
  const uvec2 range = ranges[light_tile_index(light_tile(at_m.xy, frame.view_distance_m))];
  vec2 column = vec2(0.0);
  for (uint i = range.x; i < range.y; ++i) {
    const uint index = list[i];
    if (occluders[index].top_m < stop_m) break;
    const Occluder occluder = occluders[index];
    const float weight = 1.0 - smoothstep(0.5, 1.0, abs(occluder.center_m.z - at_m.z) / kColumnReachM);
    if (index == except || weight <= 0.0) continue;
    const float sunward = occluder_depth(occluder, at_m, up);
    const float whole = occluder_depth(occluder, vec3(at_m.xy, occluder.center_m.z - 1.0e6), up);
    column += weight * vec2(sunward, max(whole - sunward, 0.0));
  }
  return min(column, vec2(kMaxSunOpticalDepth));
}

// Extinction of all particles at a point of render space.
float extinction_at(vec3 p_render_m) {
  const vec3 up = frame.light_from_render[2];
  const vec3 at_m = frame.light_from_render * p_render_m;
  const float stop_m = sun_stop_m(at_m.z, frame.view_distance_m);
  const uvec2 range = ranges[light_tile_index(light_tile(at_m.xy, frame.view_distance_m))];
  float extinction = 0.0;
  for (uint i = range.x; i < range.y; ++i) {
    const uint index = list[i];
    if (occluders[index].top_m < stop_m) break;
    extinction += occluder_extinction(occluders[index], at_m, up);
  }
  return extinction;
}

// How much of what is around a particle is cloud, kLeastEnclosure .. 1: mean opacity of a short way at four points about it.
float enclosure(Particle particle) {
  const float way_m = kNeighbourWay * pow(particle.radius_m.x * particle.radius_m.y * particle.radius_m.z, 1.0 / 3.0);
  float sum = 0.0;
  for (uint j = 0u; j < 4u; ++j)
    sum += 1.0 - exp(-way_m * extinction_at(particle_point(particle, -kNeighbourRadius * tetrahedron_corner(j))));
  return mix(kLeastEnclosure, 1.0, 0.25 * sum);
}

#endif
