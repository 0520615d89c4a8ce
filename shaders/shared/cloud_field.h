// Where cumulus clouds stand and how high they reach: a height field over the plane, anchored in the world.
//
// Near a feature d falls from 1 in its core to 0 at its edge; warp and lobes break the ellipse. The cloud's height
// grows with its size and vigour, is rounded off at the edge and broken into towers, domes and bumps. Everything is a
// function of place and seed alone.
#ifndef NEPHELE_SHARED_CLOUD_FIELD_H
#define NEPHELE_SHARED_CLOUD_FIELD_H

#include "cloud_features.h"

// A shader that has the features in a buffer defines these before including the file. A *place* is how it finds a
// lattice cell.
#ifndef NEPHELE_CLOUD_FEATURE
#define NEPHELE_FEATURE_PLACE ivec2
#define NEPHELE_FEATURE_PLACE_OF(lattice, cell) (cell)
// The features of the 3 x 3 neighbourhood that reach into the cell, or more, one bit each, row by row.
#define NEPHELE_FEATURES_NEAR(lattice, place) kWholeNeighbourhood
#define NEPHELE_CLOUD_FEATURE(params, lattice, place, i) \
  pack_feature(cloud_feature(params, lattice, neighbour_cell(place, i)))
#endif

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(float, kLargestRadiusM, 0.75f * kOriginUnitM / float(kFeatureCells0));

struct CloudSample {
  float d;       // 0 at the edge .. 1 in the core; 0 outside
  float edge_m;  // distance to the edge
  float size;    // 0 fragment .. 1 the largest clouds
  float vigour;
  vec2 warp_m;  // of the place, for the domes
};

// Outline of the clouds at a place.
NEPHELE_FN CloudSample cloud_sample(CloudParams params, vec2 p_m) {
  CloudSample result;
  result.d = 0.0f;
  result.edge_m = 0.0f;
  result.size = 0.0f;
  result.vigour = 0.0f;
  result.warp_m = vec2(kWarpM * world_fbm(params, p_m, kWarpCells, kSeedWarpX, 3),
                       kWarpM * world_fbm(params, p_m, kWarpCells, kSeedWarpY, 3));
  vec2 q = p_m + result.warp_m;
  float nearest = 0.0f;
  float weights = 0.0f;
  float radius = 0.0f;
  float vigour = 0.0f;
  float deck = params.deck;
  float deck_vigour = 0.3f;
  if (has_weather_map(params.weather)) {
    vec2 weather = weather_at(params.weather, q);
    deck = deck_for(weather.x);
    deck_vigour = mix(kHumilisVigour, deck_vigour, weather.y);
  }
  if (deck > -1.0f) {
    nearest = max(0.0f, deck + 0.7f * world_fbm(params, q, kDeckCells, kSeedDeck, 2));
    weights = nearest * nearest * kDeckRadiusM;
    radius = weights * kDeckRadiusM;
    vigour = weights * deck_vigour;
  }
  NEPHELE_FEATURE_PLACE place0 = NEPHELE_FEATURE_PLACE_OF(0u, ivec2(floor(lattice_position(q, kFeatureCells0))));
  NEPHELE_FEATURE_PLACE place1 = NEPHELE_FEATURE_PLACE_OF(1u, ivec2(floor(lattice_position(q, kFeatureCells1))));
  NEPHELE_FEATURE_PLACE place2 = NEPHELE_FEATURE_PLACE_OF(2u, ivec2(floor(lattice_position(q, kFeatureCells2))));
  uint left = NEPHELE_FEATURES_NEAR(0u, place0) | (NEPHELE_FEATURES_NEAR(1u, place1) << 9u) |
              (NEPHELE_FEATURES_NEAR(2u, place2) << 18u);
  while (left != 0u) {
    uint bit = uint(findLSB(left));
    left &= left - 1u;
    uint lattice = bit < 9u ? 0u : (bit < 18u ? 1u : 2u);
    NEPHELE_FEATURE_PLACE place = bit < 9u ? place0 : (bit < 18u ? place1 : place2);
    CloudFeature f = unpack_feature(NEPHELE_CLOUD_FEATURE(params, lattice, place, bit - 9u * lattice));
    if (f.radius_m <= 0.0f) continue;
    float dx = q.x - f.center_m.x;
    float dy = q.y - f.center_m.y;
    float axis_y = sqrt(max(0.0f, 1.0f - f.axis_x * f.axis_x));
    float along = (f.axis_x * dx + axis_y * dy) / f.stretch;
    float across = f.axis_x * dy - axis_y * dx;
    float d = 1.0f - sqrt(along * along + across * across) / f.radius_m;
    if (d <= 0.0f) continue;
    nearest = max(nearest, d);
    // Where clouds merge, their size and vigour blend, so that no wall stands between them.
    float w = d * d * f.radius_m;
    weights += w;
    radius += w * f.radius_m;
    vigour += w * f.vigour;
  }
  if (nearest <= 0.0f) return result;
  radius /= weights;
  float lobes = 0.45f * world_fbm(params, p_m, kLobeCells, kSeedLobes, 3) * (1.15f - nearest) - 0.08f;
  result.d = clamp(nearest + lobes, 0.0f, 1.0f);
  result.edge_m = result.d * radius;
  result.size = saturate(radius / kLargestRadiusM);
  result.vigour = vigour / weights;
  return result;
}

// Domes: rounded caps on a jittered lattice, the highest of the neighbourhood, in [0, 1].
NEPHELE_FN float cloud_caps(CloudParams params, vec2 p_m, uint cells, uint stream) {
  vec2 p = lattice_position(p_m, cells);
  vec2 cell = floor(p);
  uvec2 base = lattice_base(params.origin_index, cells) + uvec2(ivec2(cell));
  vec2 f = p - cell;
  float top = 0.0f;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x) {
      uint h = hash_uvec2(base + uvec2(ivec2(x, y)), params.seed + stream);
      float cx = float(x) + float(h & 255u) * (1.0f / 256.0f);
      float cy = float(y) + float((h >> 8u) & 255u) * (1.0f / 256.0f);
      float b = 0.55f + 0.45f * float((h >> 16u) & 255u) * (1.0f / 256.0f);
      float v = 0.45f + 0.55f * float(h >> 24u) * (1.0f / 256.0f);
      float dx = f.x - cx;
      float dy = f.y - cy;
      float inside = 1.0f - (dx * dx + dy * dy) / (b * b);
      if (inside > 0.0f) top = max(top, v * sqrt(inside));
    }
  return top;
}

// Height of the cloud's top above its base.
NEPHELE_FN float cloud_height_m(CloudParams params, vec2 p_m, CloudSample s) {
  if (s.d <= 0.0f) return 0.0f;
  vec2 q = p_m + 0.5f * s.warp_m;
  float towers = cloud_caps(params, p_m + s.warp_m, kTowerCells, kSeedTowers);
  float domes = cloud_caps(params, q, kDomeCells, kSeedDomes);
  float bumps = cloud_caps(params, p_m, kBumpCells, kSeedBumps);
  float relief = 0.5f * towers + 0.4f * domes + 0.18f * bumps;
  float rim = 1.0f - s.d;
  float profile = pow(max(0.0f, 1.0f - rim * rim), 0.75f);
  float growth = mix(0.22f, 1.0f, pow(s.size, 0.9f)) * mix(0.65f, 1.25f, s.vigour);
  // A fragment is hardly taller than it is wide.
  float tallest_m = min(params.thickness_m * growth, 100.0f + 2.0f * kLargestRadiusM * s.size);
  return min(params.thickness_m, tallest_m * profile * (0.1f + 0.95f * relief));
}

// Altitude of the flat base.
NEPHELE_FN float cloud_base_m(CloudParams params, vec2 p_m) {
  return params.base_m + 20.0f + 20.0f * world_fbm(params, p_m, kBaseCells, kSeedBase, 2) +
         50.0f * world_fbm(params, p_m, kWeatherCells, kSeedBase + 1u, 1);
}

NEPHELE_SHARED_END

#endif
