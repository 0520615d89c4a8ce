// Terrain: rays through a lattice of heights, the horizon of a place, and what the ground is made of.
// Based on: Tevs, Ihrke and Seidel, Maximum Mipmaps for Fast, Accurate, and Scalable Dynamic Height Field Rendering,
// 2008 (descent through a pyramid of maxima).
//
// *Terrain space*: x and y in the lattice's spacings from its south-west vertex, z = altitude. A ray keeps its azimuth
// over the ground (world.h measures places by azimuth and arc from the camera), so in terrain space it is a straight
// line in x and y, and its altitude is a convex function of the arc in closed form. Between four vertices the surface
// is bilinear.
//
// A shader that has the arrays in buffers defines NEPHELE_TERRAIN_HEIGHT(i) and NEPHELE_TERRAIN_HIGHEST(i) before
// including the file.
#ifndef NEPHELE_SHARED_HEIGHTFIELD_H
#define NEPHELE_SHARED_HEIGHTFIELD_H

#include "ground.h"
#include "noise.h"
#include "world.h"

NEPHELE_SHARED_BEGIN

// A view of the terrain, from a buffer.
struct TerrainConstants {
  vec2 camera;           // terrain space
  vec2 per_m;            // spacings a metre, east and north
  vec2 camera_ground_m;  // in the world's grid (not the clouds'), for patterns
  ivec2 ground_origin_index;
  ivec2 vertices;  // of the lattice; it has a patch less a side
  float highest_m;
  uint levels;  // of the pyramid of maxima; level 0 has a node a patch, the last a single one
  float camera_altitude_m;
  uint has_host;         // a host has drawn a scene of its own
  uint shadow_stride;    // vertices from one of the sun's horizon to the next
  uint openness_stride;  // likewise of the sky's openness
};

struct Terrain {
  TerrainConstants at;
#ifdef __cplusplus
  const float* heights = nullptr;  // as in the buffers
  const float* highest = nullptr;
#endif
};

#ifdef __cplusplus
#define NEPHELE_TERRAIN_HEIGHT(terrain, i) terrain.heights[i]
#define NEPHELE_TERRAIN_HIGHEST(terrain, i) terrain.highest[i]
#elif !defined(NEPHELE_TERRAIN_HEIGHT)
#define NEPHELE_TERRAIN_HEIGHT(terrain, i) 0.0
#define NEPHELE_TERRAIN_HIGHEST(terrain, i) 0.0
#endif

// Nodes of a level along both sides.
NEPHELE_FN ivec2 terrain_nodes(ivec2 patches, uint level) { return (patches + ((1 << level) - 1)) >> int(level); }

// Samples along both sides of what is kept for every n-th vertex: the last is the lattice's last vertex.
NEPHELE_FN ivec2 terrain_samples(ivec2 vertices, uint stride) { return (vertices + int(stride) - 2) / int(stride) + 1; }

NEPHELE_FN float terrain_height(Terrain terrain, ivec2 vertex) {
  return NEPHELE_TERRAIN_HEIGHT(terrain, uint(vertex.y * terrain.at.vertices.x + vertex.x));
}

// Bilinear: h = x + y * u + z * v + w * u * v over the patch.
NEPHELE_FN vec4 terrain_patch(Terrain terrain, ivec2 cell) {
  float h00 = terrain_height(terrain, cell);
  float h10 = terrain_height(terrain, cell + ivec2(1, 0));
  float h01 = terrain_height(terrain, cell + ivec2(0, 1));
  float h11 = terrain_height(terrain, cell + ivec2(1, 1));
  return vec4(h00, h10 - h00, h01 - h00, h11 - h10 - h01 + h00);
}

// --- A camera's ray over the arc s ---

struct TerrainRay {
  vec2 start;        // terrain space
  vec2 per_arc_m;    // terrain space a metre of arc
  float altitude_m;  // of the camera
  float slope;       // tangent of the elevation
  float cosine;      // of the elevation
};

// A vertical ray is tilted by a millionth, so that its arc grows: by 2 cm on the way down from 20 km.
NEPHELE_FN TerrainRay terrain_ray(TerrainConstants at, vec3 direction) {
  float across = length(vec2(direction.x, direction.y));
  vec2 azimuth = across > 1e-6f ? vec2(direction.x, direction.y) / across : vec2(1.0f, 0.0f);
  across = max(across, 1e-6f);
  TerrainRay ray;
  ray.start = at.camera;
  ray.per_arc_m = azimuth * at.per_m;
  ray.altitude_m = at.camera_altitude_m;
  ray.slope = direction.z / across;
  ray.cosine = across / length(vec2(across, direction.z));
  return ray;
}

// tan(s / 2R), exact to float up to 1 000 km.
NEPHELE_FN float half_arc_tangent(float arc_m) {
  float x = arc_m * (0.5f / kPlanetRadiusM);
  float x2 = x * x;
  return x * (1.0f + x2 * (1.0f / 3.0f + x2 * (2.0f / 15.0f)));
}

// The horizontal distance of the ray from the camera where it is over the arc, by the law of sines; and its altitude,
// which is the camera's plus that distance times the mean of the slopes: no large numbers cancel. A ray so steep that
// it never comes over the arc is far away.
NEPHELE_FN float ray_across_m(TerrainRay ray, float half_tangent) {
  float turned = 1.0f - half_tangent * (half_tangent + 2.0f * ray.slope);
  return turned > 1e-6f ? (kPlanetRadiusM + ray.altitude_m) * 2.0f * half_tangent / turned : 1e12f;
}
NEPHELE_FN float ray_altitude_at_arc(TerrainRay ray, float arc_m) {
  float half_tangent = half_arc_tangent(arc_m);
  return ray.altitude_m + ray_across_m(ray, half_tangent) * (half_tangent + ray.slope);
}
NEPHELE_FN float ray_distance_at_arc(TerrainRay ray, float arc_m) {
  return ray_across_m(ray, half_arc_tangent(arc_m)) / ray.cosine;
}
NEPHELE_FN float ray_arc_at_distance(TerrainRay ray, float distance_m) {
  float t = distance_m * ray.cosine / (kPlanetRadiusM + ray.altitude_m + distance_m * ray.cosine * ray.slope);
  float t2 = t * t;
  return kPlanetRadiusM * t * (1.0f - t2 * (1.0f / 3.0f - t2 * (1.0f / 5.0f - t2 * (1.0f / 7.0f))));
}

// How far a ray may sink below both ends of a stretch of arc: its altitude curves upwards by 1/R, and by more only
// where it is so steep that it is lowest at an end.
NEPHELE_FN float ray_sag_m(float stretch_m) { return stretch_m * stretch_m * (1.25f / (8.0f * kPlanetRadiusM)); }

// Where a ray from above the highest place comes down to it: the arc, 0 for a ray from below, or -1.
NEPHELE_FN float arc_below_m(TerrainRay ray, float highest_m) {
  float above_m = ray.altitude_m - highest_m;
  if (above_m <= 0.0f) return 0.0f;
  float r = kPlanetRadiusM + ray.altitude_m;
  float power = above_m * (2.0f * kPlanetRadiusM + ray.altitude_m + highest_m);
  float down = -r * ray.cosine * ray.slope;
  float discriminant = down * down - power;
  if (down <= 0.0f || discriminant < 0.0f) return -1.0f;
  // A shade before it, for rounding.
  return 0.999998f * ray_arc_at_distance(ray, power / (down + sqrt(discriminant)));
}

// --- The walk through the pyramid ---

// The stretch of a line over one node, and what follows.
struct TerrainWalk {
  vec2 start;
  vec2 per_m, m_per;   // terrain space a metre of the line, and inversely
  ivec2 positive;      // 1 where the line goes that way
  float arc_m, end_m;  // where it is, where it ends
  ivec2 patches;
  ivec2 node, nodes;  // here, and how many the level has
  uint level, levels, first;
};

NEPHELE_FN ivec2 walk_node(TerrainWalk walk) {
  vec2 p = (walk.start + walk.per_m * walk.arc_m) * (1.0f / float(1 << walk.level));
  return clamp(ivec2(floor(p)), ivec2(0), walk.nodes - 1);
}

// False where the line misses the lattice after begin_m.
NEPHELE_FN bool begin_walk(TerrainConstants at, vec2 start, vec2 per_m, float begin_m, uint level,
                           NEPHELE_OUT(TerrainWalk) walk) {
  walk.start = start;
  walk.per_m = vec2(abs(per_m.x) < 1e-12f ? 1e-12f : per_m.x, abs(per_m.y) < 1e-12f ? 1e-12f : per_m.y);
  walk.m_per = 1.0f / walk.per_m;
  walk.positive = ivec2(walk.per_m.x > 0.0f ? 1 : 0, walk.per_m.y > 0.0f ? 1 : 0);
  walk.patches = at.vertices - 1;
  vec2 low = -start * walk.m_per;
  vec2 high = (vec2(walk.patches) - start) * walk.m_per;
  walk.arc_m = max(max(min(low.x, high.x), min(low.y, high.y)), begin_m);
  walk.end_m = min(max(low.x, high.x), max(low.y, high.y));
  walk.levels = at.levels;
  walk.level = min(level, at.levels - 1u);
  walk.first = 0u;
  for (uint i = 0u; i < walk.level; ++i) {
    ivec2 nodes = terrain_nodes(walk.patches, i);
    walk.first += uint(nodes.x * nodes.y);
  }
  walk.nodes = terrain_nodes(walk.patches, walk.level);
  walk.node = walk_node(walk);
  return walk.arc_m < walk.end_m;
}

// Where the line leaves the node; x or y says through which side.
NEPHELE_FN vec2 walk_exits_m(TerrainWalk walk) {
  vec2 border = vec2((walk.node + walk.positive) << int(walk.level));
  return (border - walk.start) * walk.m_per;
}

NEPHELE_FN float walk_exit_m(TerrainWalk walk, vec2 exits_m) {
  return max(min(min(exits_m.x, exits_m.y), walk.end_m), walk.arc_m);
}

// On to the next node, of the level above where a node of that has been left.
NEPHELE_FN void walk_on(NEPHELE_INOUT(TerrainWalk) walk, vec2 exits_m, float exit_m) {
  bool in_x = exits_m.x < exits_m.y;
  ivec2 way = 2 * walk.positive - 1;
  ivec2 next = walk.node + ivec2(in_x ? way.x : 0, in_x ? 0 : way.y);
  ivec2 above = next >> 1;
  bool up = walk.level + 1u < walk.levels && (above.x != walk.node.x >> 1 || above.y != walk.node.y >> 1);
  walk.first += up ? uint(walk.nodes.x * walk.nodes.y) : 0u;
  walk.level += up ? 1u : 0u;
  walk.nodes = up ? (walk.nodes + 1) >> 1 : walk.nodes;
  walk.node = clamp(up ? above : next, ivec2(0), walk.nodes - 1);
  walk.arc_m = exit_m;
}

NEPHELE_FN void walk_down(NEPHELE_INOUT(TerrainWalk) walk) {
  ivec2 low = walk.node << 1;
  walk.level -= 1u;
  walk.nodes = terrain_nodes(walk.patches, walk.level);
  walk.first -= uint(walk.nodes.x * walk.nodes.y);
  vec2 p = (walk.start + walk.per_m * walk.arc_m) * (1.0f / float(1 << walk.level));
  walk.node = min(clamp(ivec2(floor(p)), low, low + 1), walk.nodes - 1);
}

NEPHELE_FN float walk_highest_m(Terrain terrain, TerrainWalk walk) {
  return NEPHELE_TERRAIN_HIGHEST(terrain, walk.first + uint(walk.node.y * walk.nodes.x + walk.node.x));
}

// Share of the stretch after which the ray is at or below the patch, above 1 where it stays above it. Over a patch both
// are quadratic in the arc, but for terms far below a millimetre.
NEPHELE_FN float patch_crossing(vec4 patch_m, vec2 enter, vec2 leave, float begin_m, float end_m, float stretch_m) {
  vec2 along = leave - enter;
  float rise_m = end_m - begin_m;
  float per_m = rise_m / max(stretch_m, 1e-3f);
  float bend_m = stretch_m * stretch_m * (0.5f + per_m * per_m) * (1.0f / kPlanetRadiusM);
  float c = begin_m - (patch_m.x + patch_m.y * enter.x + patch_m.z * enter.y + patch_m.w * enter.x * enter.y);
  float b = rise_m - bend_m -
            (patch_m.y * along.x + patch_m.z * along.y + patch_m.w * (enter.x * along.y + enter.y * along.x));
  float a = bend_m - patch_m.w * along.x * along.y;
  if (c <= 0.0f) return 0.0f;
  float discriminant = b * b - 4.0f * a * c;
  float down = sqrt(max(discriminant, 0.0f)) - b;
  return discriminant >= 0.0f && down > 0.0f ? 2.0f * c / down : 2.0f;
}

NEPHELE_CONST(uint, kMostTerrainRounds, 8192u);

// The arc at which the ray first is at or below the surface, -1 where it never is. A camera below the surface sees it
// at once. from_m: up to there it is known to be above.
NEPHELE_FN float terrain_hit_arc_m(Terrain terrain, TerrainRay ray, float from_m) {
  float begin_m = arc_below_m(ray, terrain.at.highest_m);
  TerrainWalk walk;
  if (!begin_walk(terrain.at, ray.start, ray.per_arc_m, max(begin_m, from_m), 2u, walk) || begin_m < 0.0f) return -1.0f;
  float altitude_m = ray_altitude_at_arc(ray, walk.arc_m);
  if (walk.arc_m > 0.0f && altitude_m < 0.0f) return -1.0f;  // it has met the plain before the lattice begins
  float hit_m = -1.0f;
  bool missed = false;  // the patch at hand has been looked at
  vec2 exits_m = vec2(0.0f);
  float exit_m = walk.arc_m;
  float exit_altitude_m = altitude_m;
  uint rounds = 0u;
  while (rounds < kMostTerrainRounds && walk.arc_m < walk.end_m) {
    // To the next patch that the ray may meet.
    bool look = false;
    while (rounds < kMostTerrainRounds && !look && walk.arc_m < walk.end_m) {
      ++rounds;
      exits_m = walk_exits_m(walk);
      exit_m = walk_exit_m(walk, exits_m);
      exit_altitude_m = ray_altitude_at_arc(ray, exit_m);
      float lowest_m = min(altitude_m, exit_altitude_m) - ray_sag_m(exit_m - walk.arc_m);
      if (missed || lowest_m > walk_highest_m(terrain, walk)) {
        missed = false;
        // A ray that climbs above everything meets nothing more.
        if (exit_altitude_m > terrain.at.highest_m && exit_altitude_m > altitude_m) exit_m = walk.end_m;
        walk_on(walk, exits_m, exit_m);
        altitude_m = exit_altitude_m;
      } else if (walk.level == 0u) {
        look = true;
      } else {
        walk_down(walk);
      }
    }
    if (!look) break;
    vec2 enter = walk.start + walk.per_m * walk.arc_m - vec2(walk.node);
    float stretch_m = exit_m - walk.arc_m;
    float share = patch_crossing(terrain_patch(terrain, walk.node), enter, enter + walk.per_m * stretch_m, altitude_m,
                                 exit_altitude_m, stretch_m);
    if (share <= 1.0f) {
      hit_m = walk.arc_m + share * stretch_m;
      break;
    }
    missed = true;
  }
  return hit_m;
}

// --- A bundle of rays ---

// Rays that differ little in azimuth and elevation.
struct TerrainBundle {
  TerrainRay lowest;  // in the bundle's middle azimuth, no higher than any of its rays
  float spread;       // between the azimuths of a ray and of the middle, radians at most; below 0: no bundle
};

NEPHELE_CONST(float, kNoTerrainM, 1e30f);

// Highest of the 2 x 2 nodes of a level about a place, which lies half a node within them at least.
NEPHELE_FN float highest_about_m(Terrain terrain, vec2 place, uint level, uint first) {
  ivec2 nodes = terrain_nodes(terrain.at.vertices - 1, level);
  ivec2 low = ivec2(floor(place * (1.0f / float(1 << level)) - 0.5f));
  float most = -1e30f;
  for (int i = 0; i < 4; ++i) {
    ivec2 node = low + ivec2(i & 1, i >> 1);
    bool inside = node.x >= 0 && node.y >= 0 && node.x < nodes.x && node.y < nodes.y;
    ivec2 at = clamp(node, ivec2(0), nodes - 1);
    float m = NEPHELE_TERRAIN_HIGHEST(terrain, first + uint(at.y * nodes.x + at.x));
    most = max(most, inside ? m : -1e30f);
  }
  return most;
}

// An arc up to which no ray of the bundle meets the terrain; kNoTerrainM where none does at all. Walks in steps of
// about half a node's width, at levels whose nodes are wider than the bundle.
NEPHELE_FN float bundle_begin_arc_m(Terrain terrain, TerrainBundle bundle) {
  if (bundle.spread < 0.0f) return 0.0f;
  float arc_m = arc_below_m(bundle.lowest, terrain.at.highest_m);
  if (arc_m < 0.0f) return kNoTerrainM;
  vec2 far = max(abs(bundle.lowest.start), abs(bundle.lowest.start - vec2(terrain.at.vertices))) / terrain.at.per_m;
  float end_m = length(far);
  float spacing_m = 1.0f / max(terrain.at.per_m.x, terrain.at.per_m.y);
  float altitude_m = ray_altitude_at_arc(bundle.lowest, arc_m);
  uint level = 0u;
  uint first = 0u;
  for (uint rounds = 0u; rounds < 512u; ++rounds) {
    if (arc_m >= end_m) return kNoTerrainM;
    float half_m = 0.5f * spacing_m * float(1 << level);
    float wide_m = bundle.spread * (arc_m + half_m);
    float step_m = half_m - wide_m;
    bool clear = false;
    if (step_m > 0.5f * half_m) {
      vec2 place = bundle.lowest.start + bundle.lowest.per_arc_m * arc_m;
      float there_m = ray_altitude_at_arc(bundle.lowest, arc_m + step_m);
      clear = min(altitude_m, there_m) - ray_sag_m(step_m) > highest_about_m(terrain, place, level, first);
      if (clear) {
        if (there_m > terrain.at.highest_m && there_m > altitude_m) return kNoTerrainM;
        arc_m += step_m;
        altitude_m = there_m;
      }
    } else {
      clear = true;  // the nodes are too small: try larger ones
      if (level + 1u >= terrain.at.levels) break;
    }
    if (clear) {
      if (level + 1u < terrain.at.levels) {
        ivec2 nodes = terrain_nodes(terrain.at.vertices - 1, level);
        first += uint(nodes.x * nodes.y);
        ++level;
      }
    } else {
      // Not clear here, and nodes half as wide would be too small.
      float less_m = 0.5f * half_m;
      if (level == 0u || less_m - bundle.spread * (arc_m + less_m) <= 0.5f * less_m) break;
      --level;
      ivec2 nodes = terrain_nodes(terrain.at.vertices - 1, level);
      first -= uint(nodes.x * nodes.y);
    }
  }
  return max(0.9999f * arc_m - 1.0f, 0.0f);
}

// --- The horizon of a place ---

// How steeply one looks up from a place to what stands highest above the horizontal there, as a tangent; no less than
// `least`. Seen along the arc in a direction (terrain space a metre). What lies within skip_m is left out: how the
// surface itself is tilted is its normal's to say. Heights count where the line crosses from patch to patch.
NEPHELE_FN float terrain_horizon(Terrain terrain, vec2 place, float altitude_m, vec2 per_m, float least, float skip_m) {
  float steepest = least;
  TerrainWalk walk;
  if (!begin_walk(terrain.at, place, per_m, skip_m, 3u, walk)) return steepest;
  uint rounds = 0u;
  while (rounds < kMostTerrainRounds && walk.arc_m < walk.end_m) {
    bool look = false;
    vec2 exits_m = vec2(0.0f);
    float exit_m = walk.arc_m;
    while (rounds < kMostTerrainRounds && !look && walk.arc_m < walk.end_m) {
      ++rounds;
      exits_m = walk_exits_m(walk);
      exit_m = walk_exit_m(walk, exits_m);
      float sunk_m = altitude_m + walk.arc_m * walk.arc_m * (0.5f / kPlanetRadiusM);
      float rise_m = walk_highest_m(terrain, walk) - sunk_m;
      if (rise_m <= steepest * (rise_m > 0.0f ? walk.arc_m : exit_m)) {
        float most_m = terrain.at.highest_m - sunk_m;
        if (most_m <= steepest * (most_m > 0.0f ? walk.arc_m : walk.end_m)) exit_m = walk.end_m;
        walk_on(walk, exits_m, exit_m);
      } else if (walk.level == 0u) {
        look = true;
      } else {
        walk_down(walk);
      }
    }
    if (!look) break;
    vec2 leave = walk.start + walk.per_m * exit_m - vec2(walk.node);
    vec4 patch_m = terrain_patch(terrain, walk.node);
    float there_m = patch_m.x + patch_m.y * leave.x + patch_m.z * leave.y + patch_m.w * leave.x * leave.y;
    float over_m = there_m - altitude_m - exit_m * exit_m * (0.5f / kPlanetRadiusM);
    steepest = max(steepest, over_m / max(exit_m, 1e-3f));
    walk_on(walk, exits_m, exit_m);
  }
  return steepest;
}

// Share of the sun's disc above a horizon; both as tangents of the elevation. As soft as sun_visibility (air.h).
NEPHELE_FN float sun_above_horizon(float sun_tangent, float horizon_tangent, float sun_radius_rad) {
  float apart = (sun_tangent - horizon_tangent) / max(1.0f + sun_tangent * horizon_tangent, 1e-3f);
  return smoothstep(-sun_radius_rad, sun_radius_rad, apart);
}

NEPHELE_CONST(float, kHorizonSkip, 1.5f);  // spacings within which the surface shades itself by its normal alone

// --- What the ground is made of ---

// Lattices of the noise that moves the limits between kinds of ground, in cells a unit of kOriginUnitM.
NEPHELE_CONST(uint, kReliefCells, 83u);  // 1.1 km, and four times finer each
NEPHELE_CONST(uint, kReliefSeed, 0x726f636bu);

// Octaves of that noise, from coarse to fine; each fades as the footprint outgrows it. Those without weight are left
// out: on a CPU they cost as much as any other.
NEPHELE_FN vec4 relief_noise(vec2 ground_m, ivec2 origin_index, float footprint_m) {
  vec4 noise = vec4(0.0f);
  uint cells = kReliefCells;
  int octaves = int(clamp(ceil(log(0.9f * lattice_cell_m(cells) / footprint_m) / log(4.0f)), 0.0f, 4.0f));
  for (int i = 0; i < octaves; ++i) {
    noise[i] =
        (1.0f - smoothstep(0.25f, 0.9f, footprint_m / lattice_cell_m(cells))) *
        gradient_noise2(lattice_position(ground_m, cells), lattice_base(origin_index, cells), kReliefSeed + uint(i));
    cells *= 4u;
  }
  return noise;
}

NEPHELE_CONST(float, kCountryTopM, 1600.0f);  // altitude above which nothing is left of the plain's country

// The share of the plain's rivers and lakes that lies on terrain: they end where it rises. slope_squared: the land's
// steepness (terrain_steepness).
NEPHELE_FN float terrain_water_share(float altitude_m, float slope_squared) {
  return (1.0f - smoothstep(0.0004f, 0.003f, slope_squared)) * (1.0f - smoothstep(500.0f, 1250.0f, altitude_m));
}

// Albedo of land at an altitude with a slope (tangent): the country of the plain (its albedo, pattern included) where
// it is low and gentle; higher up meadows, scree and rock, snow on what is high and not too steep. Limits are soft and
// moved by noise.
NEPHELE_FN vec3 terrain_albedo(vec3 country, float altitude_m, float slope, vec4 noise) {
  float drift = clamp(noise.x + 0.5f * noise.y + 0.3f * noise.z, -1.0f, 1.0f);
  float grain = 0.35f * noise.y + 0.6f * noise.z + 0.9f * noise.w;
  vec3 meadow = vec3(0.110f, 0.122f, 0.056f) * (1.0f + 0.18f * grain + 0.25f * noise.x);
  vec3 scree = vec3(0.235f, 0.220f, 0.200f) * (1.0f + 0.12f * grain);
  vec3 rock = vec3(0.175f, 0.160f, 0.145f) * (1.0f + 0.14f * grain + 0.2f * noise.x);
  vec3 snow = vec3(0.80f, 0.82f, 0.85f) * (1.0f + 0.04f * grain);
  float high_m = altitude_m + 320.0f * drift;
  vec3 land = mix(country, meadow, smoothstep(500.0f, 1250.0f, high_m));
  land = mix(land, meadow, 0.7f * smoothstep(0.15f, 0.5f, slope) * smoothstep(150.0f, 600.0f, high_m));
  land = mix(land, scree, smoothstep(1500.0f, 2100.0f, high_m + 300.0f * (slope - 0.5f)));
  land = mix(land, rock,
             smoothstep(0.50f, 0.90f, slope + 0.12f * grain + 0.12f * drift + 0.00006f * (altitude_m - 1000.0f)));
  float lies = 1.0f - smoothstep(0.80f, 1.20f, slope + 0.1f * grain);
  return clamp(mix(land, snow, lies * smoothstep(2050.0f, 2500.0f, high_m + 80.0f * grain)), 0.0f, 1.0f);
}

NEPHELE_SHARED_END

#ifdef __cplusplus
static_assert(sizeof(nephele::shared::TerrainConstants) == 64);
#endif

#endif
