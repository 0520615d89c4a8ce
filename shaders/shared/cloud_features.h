// The clouds' centres: elliptical *features* on jittered lattices of three spacings, anchored in the world, fuller or
// emptier with the weather. cloud_field.h makes outlines and heights of them.
#ifndef NEPHELE_SHARED_CLOUD_FEATURES_H
#define NEPHELE_SHARED_CLOUD_FEATURES_H

#include "noise.h"
#include "ring_grid.h"
#include "weather.h"

NEPHELE_SHARED_BEGIN

// Lattices, in cells per kOriginUnitM.
NEPHELE_CONST(uint, kFeatureCells0, 39u);   // 2416 m
NEPHELE_CONST(uint, kFeatureCells1, 90u);   // 1047 m
NEPHELE_CONST(uint, kFeatureCells2, 208u);  //  453 m
NEPHELE_CONST(uint, kWeatherCells, 7u);     // 13.5 km: where the sky is fuller or emptier
NEPHELE_CONST(uint, kWarpCells, 105u);      //  897 m
NEPHELE_CONST(uint, kLobeCells, 152u);      //  620 m
NEPHELE_CONST(uint, kTowerCells, 54u);      // 1745 m
NEPHELE_CONST(uint, kDomeCells, 131u);      //  719 m
NEPHELE_CONST(uint, kBumpCells, 317u);      //  297 m
NEPHELE_CONST(uint, kBaseCells, 67u);       // 1406 m
NEPHELE_CONST(uint, kDeckCells, 48u);       // 1963 m
NEPHELE_CONST(float, kDeckRadiusM, 900.0f);

NEPHELE_CONST(float, kGrowth, 0.6f);   // of a feature's area over its cycle; its mean is the area without growth
NEPHELE_CONST(float, kWarpM, 260.0f);  // amplitude; noise reaches 1

// What a weather map makes of the clouds at type 0, humilis: as many in all, but mostly of the finer lattices, and
// flat.
NEPHELE_CONST(float, kHumilisVigour, -0.4f);
// Clouds come and go over this much of their likelihood as they drift through a map: they fade in instead of popping
// up.
NEPHELE_CONST(float, kWeatherFade, 0.1f);

// Independent streams of the seed.
NEPHELE_CONST(uint, kSeedFeature, 0x1000u);  // + lattice
NEPHELE_CONST(uint, kSeedWeather, 0x2000u);
NEPHELE_CONST(uint, kSeedWarpX, 0x3000u);
NEPHELE_CONST(uint, kSeedWarpY, 0x4000u);
NEPHELE_CONST(uint, kSeedLobes, 0x5000u);
NEPHELE_CONST(uint, kSeedDomes, 0x6000u);
NEPHELE_CONST(uint, kSeedBumps, 0x7000u);
NEPHELE_CONST(uint, kSeedBase, 0x8000u);
NEPHELE_CONST(uint, kSeedDeck, 0x9000u);
NEPHELE_CONST(uint, kSeedTowers, 0xb000u);

struct CloudParams {
  ivec2 origin_index;
  uint seed;           // hashed
  float fullness;      // the c that gives the asked-for area fraction
  float deck;          // above -1: a closed layer grows between the clouds
  float growth_turns;  // CloudField
  float base_m;
  float thickness_m;
  Weather weather;
};

struct CloudFeature {
  vec2 center_m;   // grid space
  float radius_m;  // 0: none here
  float stretch;   // long over short axis
  float axis_x;    // of the unit vector along the long axis; its y is positive
  float vigour;    // 0 flat .. 1 towering for its size; below 0 only where a weather map asks for humilis
};

// As it is kept in a buffer; everyone sees features with this precision. What changes while clouds grow keeps the
// precision of a float, so that nothing that follows from it moves in steps.
struct PackedFeature {
  vec2 center_m;
  float radius_m;
  uint character;  // from the lowest bit: stretch - 1 in 6 bits, axis_x in 12, vigour in 14
};

NEPHELE_FN uint pack_bits(float x, float low, float high, uint bits) {
  float steps = float((1u << bits) - 1u);
  return uint(clamp((x - low) / (high - low), 0.0f, 1.0f) * steps + 0.5f);
}
NEPHELE_FN float unpack_bits(uint word, float low, float high, uint bits) {
  uint most = (1u << bits) - 1u;
  return low + (high - low) * float(word & most) / float(most);
}

NEPHELE_FN PackedFeature pack_feature(CloudFeature f) {
  PackedFeature result;
  result.center_m = f.center_m;
  result.radius_m = f.radius_m;
  result.character = pack_bits(f.stretch, 1.0f, 2.0f, 6u) | (pack_bits(f.axis_x, -1.0f, 1.0f, 12u) << 6u) |
                     (pack_bits(f.vigour, -1.0f, 1.0f, 14u) << 18u);
  return result;
}

NEPHELE_FN CloudFeature unpack_feature(PackedFeature packed) {
  CloudFeature f;
  f.center_m = packed.center_m;
  f.radius_m = packed.radius_m;
  f.stretch = unpack_bits(packed.character, 1.0f, 2.0f, 6u);
  f.axis_x = unpack_bits(packed.character >> 6u, -1.0f, 1.0f, 12u);
  f.vigour = unpack_bits(packed.character >> 18u, -1.0f, 1.0f, 14u);
  return f;
}

NEPHELE_FN float smooth_ramp(float low, float high, float x) {
  float t = saturate((x - low) / (high - low));
  return t * t * (3.0f - 2.0f * t);
}

NEPHELE_FN float world_fbm(CloudParams params, vec2 p_m, uint cells, uint stream, int octaves) {
  return fbm2(lattice_position(p_m, cells), lattice_base(params.origin_index, cells), params.seed + stream, octaves);
}

NEPHELE_FN uint feature_cells(uint lattice) {
  return lattice == 0u ? kFeatureCells0 : (lattice == 1u ? kFeatureCells1 : kFeatureCells2);
}

// y on the line through (x0, y0) and (x1, y1).
NEPHELE_FN float on_line(float x, float x0, float y0, float x1, float y1) { return mix(y0, y1, (x - x0) / (x1 - x0)); }

// The fullness that covers this fraction of the sky, measured over 120 km and six seeds. Clouds alone close at most
// four fifths of it; beyond, a layer grows between them (deck_for).
NEPHELE_FN float fullness_for(float coverage) {
  if (coverage <= 0.0f) return -10.0f;  // no feature exists
  if (coverage < 0.0135f) return on_line(coverage, 0.0f, -0.3f, 0.0135f, -0.1f);
  if (coverage < 0.0494f) return on_line(coverage, 0.0135f, -0.1f, 0.0494f, 0.0f);
  if (coverage < 0.126f) return on_line(coverage, 0.0494f, 0.0f, 0.126f, 0.1f);
  if (coverage < 0.249f) return on_line(coverage, 0.126f, 0.1f, 0.249f, 0.2f);
  if (coverage < 0.5715f) return on_line(coverage, 0.249f, 0.2f, 0.5715f, 0.4f);
  if (coverage < 0.7056f) return on_line(coverage, 0.5715f, 0.4f, 0.7056f, 0.5f);
  return on_line(min(coverage, 0.797f), 0.7056f, 0.5f, 0.797f, 0.6f);
}

// The same under a weather map: at coverage 0 no sky is full enough for a cloud (the noise stays below 1), and there is
// no jump on the way there.
NEPHELE_FN float mapped_fullness_for(float coverage) {
  return coverage < 0.0135f ? on_line(coverage, 0.0f, -0.7f, 0.0135f, -0.1f) : fullness_for(coverage);
}

NEPHELE_FN float deck_for(float coverage) {
  if (coverage < 0.79f) return -1.0f;
  if (coverage < 0.8065f) return on_line(coverage, 0.79f, -0.45f, 0.8065f, -0.2f);
  if (coverage < 0.854f) return on_line(coverage, 0.8065f, -0.2f, 0.854f, 0.0f);
  if (coverage < 0.937f) return on_line(coverage, 0.854f, 0.0f, 0.937f, 0.2f);
  if (coverage < 0.9885f) return on_line(coverage, 0.937f, 0.2f, 0.9885f, 0.4f);
  return on_line(min(coverage, 1.0f), 0.9885f, 0.4f, 1.0f, 0.75f);
}

// The share of a lattice's cells that hold a cloud where the sky is fullest; over the lattices it sums to the same for
// every type, and so does the area under clouds.
NEPHELE_FN float likeliest_feature(uint lattice, float type) {
  float humilis = lattice == 0u ? 0.3f : (lattice == 1u ? 0.8f : 0.7f);
  float congestus = lattice == 0u ? 1.0f : (lattice == 1u ? 0.5f : 0.3f);
  return mix(humilis, congestus, type);
}

// The feature of a lattice cell, counted from the grid origin.
NEPHELE_FN CloudFeature cloud_feature(CloudParams params, uint lattice, ivec2 cell) {
  uint n = feature_cells(lattice);
  float spacing = lattice_cell_m(n);
  uint h = hash_uvec2(lattice_base(params.origin_index, n) + uvec2(cell), params.seed + kSeedFeature + lattice);
  float jx = uniform_float(h, -0.425f, 0.425f);
  float jy = uniform_float(h, -0.425f, 0.425f);
  float presence = unit_float(hash_next(h));
  CloudFeature f;
  f.center_m = vec2((float(cell.x) + 0.5f + jx) * spacing, (float(cell.y) + 0.5f + jy) * spacing);
  f.radius_m = 0.0f;
  f.stretch = 1.0f;
  f.axis_x = 0.0f;
  f.vigour = 0.0f;
  bool mapped = has_weather_map(params.weather);
  float likeliest = likeliest_feature(lattice, kCongestus);
  float bound = mapped ? (1.0f + kWeatherFade) * max(likeliest, likeliest_feature(lattice, 0.0f)) : likeliest;
  if (presence >= bound) return f;  // whatever the weather: most of the fine lattice's cells
  float u = unit_float(hash_next(h));
  float axis_x = cos(kPi * unit_float(hash_next(h)));
  float stretch = uniform_float(h, 1.0f, 1.6f);
  float vigour = unit_float(hash_next(h));
  float turn = params.growth_turns + unit_float(hash_next(h));
  float fullness = params.fullness;
  if (mapped) {
    vec2 weather = weather_at(params.weather, f.center_m);
    fullness = mapped_fullness_for(weather.x);
    likeliest = likeliest_feature(lattice, weather.y);
    vigour = mix(kHumilisVigour, vigour, weather.y);
  }
  float e = fullness + 0.5f * world_fbm(params, f.center_m, kWeatherCells, kSeedWeather, 2);
  float chance = saturate(1.6f * e + 0.15f) * likeliest;
  float radius = mix(0.18f, 0.75f, pow(u, 1.6f)) * sqrt(clamp(e, 0.05f, 1.2f) / 0.45f);
  if (params.growth_turns >= 0.0f) radius *= sqrt(1.0f + kGrowth * cos(2.0f * kPi * turn));
  bool present = presence < chance;
  if (mapped) {
    // Half the area where the cloud would appear, and as much beyond as is lost before: the mean area stays.
    float room = min(1.6f * e + 0.15f, 1.0f) - presence / likeliest;
    float share = saturate(0.5f + room / kWeatherFade);
    radius *= sqrt(share);
    present = share > 0.0f;
  }
  // Centres keep 0.075 cells off their cell's border, so what lies beyond the 3 x 3 neighbourhood is 1.075 cells away.
  f.radius_m = present ? min(radius, 1.05f / stretch) * spacing : 0.0f;
  f.stretch = stretch;
  f.axis_x = axis_x;
  f.vigour = vigour;
  return f;
}

NEPHELE_FN CloudParams cloud_params(CloudField field) {
  CloudParams params;
  params.origin_index = field.origin_index;
  params.seed = hash_uint(field.seed);
  params.fullness = fullness_for(field.coverage);
  params.deck = deck_for(field.coverage);
  params.growth_turns = field.growth_turns;
  params.base_m = field.base_m;
  params.thickness_m = field.thickness_m;
  params.weather.placement = field.weather;
  params.weather.coverage = field.coverage;
  return params;
}

// How far from the middle of the camera's finest cell the field is looked at, in rings up to the last one: inside cells
// whose centre is within reach; the warp moves by kWarpM.
NEPHELE_FN float looked_at_m(CloudField field, uint last_ring) {
  float reach_m = min(cloud_reach_m(field), ring_reach_m(field, last_ring));
  return reach_m + ring_cell_m(field, 0u) + 0.5f * ring_cell_m(field, last_ring) + 1.5f * kWarpM;
}

// The cells of a lattice in a square of half side `reach` around the camera, and one more all round.
NEPHELE_FN FeatureWindow window_within(CloudField field, uint lattice, float reach, uint first) {
  float finest_m = ring_cell_m(field, 0u);
  vec2 middle_m = vec2((float(field.camera_cell.x) + 0.5f) * finest_m, (float(field.camera_cell.y) + 0.5f) * finest_m);
  float n = float(feature_cells(lattice));
  FeatureWindow window;
  window.corner = ivec2(floor((middle_m - vec2(reach)) * (n / kOriginUnitM))) - ivec2(1);
  window.side = 2 * int(ceil(reach * (n / kOriginUnitM))) + 4;
  window.first = first;
  return window;
}
NEPHELE_FN uint end_of(FeatureWindow window) { return window.first + uint(window.side * window.side); }

NEPHELE_FN FeatureWindow feature_window(CloudField field, uint lattice) {
  float reach = looked_at_m(field, last_ring(field));
  FeatureWindow window = window_within(field, 0u, reach, 0u);
  for (uint i = 1u; i <= lattice; ++i) window = window_within(field, i, reach, end_of(window));
  return window;
}

// Whether the features that reach into a cell of the lattice are listed beforehand. That pays where the field is asked
// at several places of the cell: in rings whose cells are no larger than the lattice's.
NEPHELE_FN float near_reach_m(CloudField field, uint lattice) {
  uint ring = 0u;
  while (ring < last_ring(field) && ring_cell_m(field, ring + 1u) <= lattice_cell_m(feature_cells(lattice))) ++ring;
  return looked_at_m(field, ring);
}

NEPHELE_FN FeatureWindow near_window(CloudField field, uint lattice) {
  FeatureWindow window = window_within(field, 0u, near_reach_m(field, 0u), 0u);
  for (uint i = 1u; i <= lattice; ++i) window = window_within(field, i, near_reach_m(field, i), end_of(window));
  return window;
}

NEPHELE_FN uint feature_count(CloudField field) { return end_of(feature_window(field, kCloudLattices - 1u)); }
NEPHELE_FN uint near_count(CloudField field) { return end_of(near_window(field, kCloudLattices - 1u)); }

// A cell of the 3 x 3 neighbourhood, counted row by row.
NEPHELE_CONST(uint, kWholeNeighbourhood, 0x1ffu);
NEPHELE_FN ivec2 neighbour_cell(ivec2 cell, uint i) { return cell + ivec2(int(i % 3u) - 1, int(i / 3u) - 1); }

// Whether some place in a lattice cell may lie in the feature's ellipse.
NEPHELE_FN bool feature_reaches(CloudFeature f, uint lattice, ivec2 cell) {
  float spacing = lattice_cell_m(feature_cells(lattice));
  vec2 lower_m = vec2(float(cell.x), float(cell.y)) * spacing;
  float dx = f.center_m.x - clamp(f.center_m.x, lower_m.x, lower_m.x + spacing);
  float dy = f.center_m.y - clamp(f.center_m.y, lower_m.y, lower_m.y + spacing);
  float reach_m = f.radius_m * f.stretch + 1.0f;  // rounding
  return f.radius_m > 0.0f && dx * dx + dy * dy < reach_m * reach_m;
}

// Where a feature is kept; features outside the window, which no particle needs, alias those at its border.
NEPHELE_FN uint feature_slot(FeatureWindow window, ivec2 cell) {
  ivec2 at = clamp(cell - window.corner, ivec2(0), ivec2(window.side - 1));
  return window.first + uint(at.y * window.side + at.x);
}

#ifdef __cplusplus
static_assert(sizeof(PackedFeature) == 16);
#endif

NEPHELE_SHARED_END

#endif
