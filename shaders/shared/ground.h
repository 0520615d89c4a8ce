// The ground that stands in for a host's: land cover as a function of place, tied to the world. Fields lie in blocks
// whose direction changes from district to district, with woods, hedges, tracks, lanes, rivers and lakes between them.
// Albedo is relative to the scene's, with mean 1 over the land. Every part fades to its mean as a pixel's footprint
// outgrows it, so nothing shimmers.
#ifndef NEPHELE_SHARED_GROUND_H
#define NEPHELE_SHARED_GROUND_H

#include "noise.h"
#include "world.h"

NEPHELE_SHARED_BEGIN

struct GroundCover {
  vec3 albedo_factor;  // of the land in the footprint, relative to the scene's albedo
  float water;         // share of the footprint, in [0, 1]
};

// Noise of the country: octaves from 11.8 km, each turned and 1 / sqrt(10) as wide as the one before. Multiplying a
// place by the Gaussian integer 3 - i does both and takes whole cells to whole cells, so octaves stay exact at any
// origin.
NEPHELE_CONST(uint, kCountryCells, 8u);  // a unit of kOriginUnitM
NEPHELE_CONST(float, kOctaveRatio, 3.1622777f);
NEPHELE_CONST(int, kCountryOctaves, 5);  // down to 118 m
NEPHELE_CONST(int, kTuftOctaves, 7);     // from there down to 4 cm
NEPHELE_CONST(uint, kEstateCells, 11u);  // with an axis kEstateAxis long: estates of 1.2 km, cut up into fields
NEPHELE_CONST(float, kEstateAxis, 7.18f);
NEPHELE_CONST(float, kWoodLevel, 0.22f);
NEPHELE_CONST(float, kLaneLevel, 0.35f);  // of the river's noise: a lane there, and another district behind it
NEPHELE_CONST(uint, kGroundSeed, 4u);

NEPHELE_FN vec2 complex_product(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }
NEPHELE_FN vec2 next_octave(vec2 p) { return vec2(3.0f * p.x + p.y, 3.0f * p.y - p.x); }
NEPHELE_FN uvec2 next_octave(uvec2 p) { return uvec2(3u * p.x + p.y, 3u * p.y - p.x); }

// The share of a pattern's contrast that is left when a footprint averages over it.
NEPHELE_FN float ground_fade(float footprint_over_size) { return 1.0f - smoothstep(0.35f, 1.5f, footprint_over_size); }

// Half of noise_mix: spread indices need no more.
NEPHELE_FN uint ground_mix(uint x) {
  x = (x ^ (x >> 16u)) * 0x7feb352du;
  return x ^ (x >> 15u);
}

// Share of a pixel that a strip around a line covers: distances in pixels, from the line and from there to its edge.
NEPHELE_FN float strip_cover(float distance, float half_width) {
  return clamp(half_width - distance + 0.5f, 0.0f, 1.0f) - clamp(0.5f - half_width - distance, 0.0f, 1.0f);
}

NEPHELE_FN uint ground_hash(uint x, uint y) {
  return ground_mix((x * kNoiseSpreadX) ^ (y * kNoiseSpreadY) ^ kGroundSeed);
}

NEPHELE_FN float hash_byte(uint h, uint shift) { return float((h >> shift) & 255u) * (1.0f / 255.0f); }

// Bytes of a hash, in [0, 255].
NEPHELE_FN vec2 lower_bytes(uint h) { return vec2(float(h & 255u), float((h >> 8u) & 255u)); }
NEPHELE_FN vec2 upper_bytes(uint h) { return vec2(float((h >> 16u) & 255u), float(h >> 24u)); }
NEPHELE_CONST(float, kPerByte, 2.0f / 255.0f);

// Hashes of a cell's corners: lower left, lower right, upper left, upper right.
NEPHELE_FN uvec4 corner_hashes(uvec2 cell) {
  uint x0 = (cell.x * kNoiseSpreadX) ^ kGroundSeed;
  uint x1 = ((cell.x + 1u) * kNoiseSpreadX) ^ kGroundSeed;
  uint y0 = cell.y * kNoiseSpreadY;
  uint y1 = y0 + kNoiseSpreadY;
  return uvec4(ground_mix(x0 ^ y0), ground_mix(x1 ^ y0), ground_mix(x0 ^ y1), ground_mix(x1 ^ y1));
}

// What grows on a field, by its hash.
NEPHELE_CONST(float, kGreenShare, 0.52f);
NEPHELE_CONST(float, kRipeShare, 0.26f);  // the rest is bare soil
NEPHELE_FN vec3 field_color(uint h) {
  float kind = hash_byte(h, 0u);
  float tone = hash_byte(h, 8u);
  bool is_green = kind < kGreenShare;
  bool is_ripe = kind < kGreenShare + kRipeShare;
  vec3 dark = is_green ? vec3(0.0620f, 0.0860f, 0.0400f)
                       : (is_ripe ? vec3(0.1900f, 0.1890f, 0.1320f) : vec3(0.1280f, 0.1170f, 0.0910f));
  vec3 light = is_green ? vec3(0.1210f, 0.1460f, 0.0740f)
                        : (is_ripe ? vec3(0.2880f, 0.2720f, 0.2000f) : vec3(0.2120f, 0.1900f, 0.1520f));
  return mix(dark, light, tone);
}
NEPHELE_FN vec3 mean_field_color() {
  return kGreenShare * vec3(0.0915f, 0.1160f, 0.0570f) + kRipeShare * vec3(0.2390f, 0.2305f, 0.1660f) +
         (1.0f - kGreenShare - kRipeShare) * vec3(0.1700f, 0.1535f, 0.1215f);
}
NEPHELE_FN vec3 wood_color() { return vec3(0.0360f, 0.0480f, 0.0240f); }
NEPHELE_FN vec3 bank_color() { return vec3(0.0800f, 0.1060f, 0.0540f); }
NEPHELE_FN vec3 track_color() { return vec3(0.2300f, 0.2200f, 0.1850f); }
NEPHELE_FN vec3 mean_land_color() { return vec3(0.1227f, 0.1308f, 0.0833f); }  // measured (ground_test)
NEPHELE_CONST(float, kMeanWater, 0.007f);                                      // measured (ground_test)

// A rectangle of an estate, in units of the estate's side, and its hash.
struct Plot {
  vec2 low;
  vec2 high;
  uint hash;
};

// The half of a plot that p is in, the longer side cut more often.
NEPHELE_FN Plot half_plot(Plot plot, vec2 p) {
  vec2 size = plot.high - plot.low;
  bool cut_x = size.x * (0.5f + hash_byte(plot.hash, 0u)) > size.y;
  vec2 at = plot.low + size * (0.34f + 0.32f * hash_byte(plot.hash, 8u));
  bool beyond = cut_x ? p.x > at.x : p.y > at.y;
  if (cut_x && beyond) plot.low.x = at.x;
  if (cut_x && !beyond) plot.high.x = at.x;
  if (!cut_x && beyond) plot.low.y = at.y;
  if (!cut_x && !beyond) plot.high.y = at.y;
  plot.hash = ground_mix(plot.hash + (beyond ? 0x9e3779b9u : 0x7f4a7c15u));
  return plot;
}

// Contrast that a plot keeps at p: it gives way to the mean towards its borders, where a pixel sees the next one too,
// and as a whole where a pixel is as wide as the plot.
NEPHELE_FN float plot_contrast(Plot plot, vec2 p, vec2 pixels) {
  vec2 inside = 2.0f * pixels * min(p - plot.low, plot.high - p);
  vec2 left = 0.9f * pixels * (plot.high - plot.low) - 0.5f;
  vec2 share = clamp(inside, vec2(0.0f), vec2(1.0f)) * clamp(left, vec2(0.0f), vec2(1.0f));
  return share.x * share.y;
}

// Share of a pixel covered by a strip on one side of a border; none at the border itself, where the other side may have
// no strip.
NEPHELE_FN float border_cover(float distance_m, float strip_m, float width_m) {
  float over = 1.0f / (strip_m + width_m);
  return min(1.0f, 2.0f * strip_m * over * max(0.0f, 1.0f - abs(2.0f * distance_m * over - 1.0f)));
}

// Noise of the country at a place.
struct Country {
  float river;       // rivers run where it is 0, lanes at +-kLaneLevel; districts lie between them
  vec2 slope_per_m;  // of river
  float wood;        // woods stand where it is high
  float lost;        // of wood's range to the filter, at least what an edge is wide
  vec2 bend;         // of the fields; x also dries them, y broadens rivers
  float tufts;       // structure below the country's octaves, about 0
};

NEPHELE_FN Country country_at(vec2 ground_m, ivec2 origin_index, float long_m) {
  Country country;
  country.bend = vec2(0.0f);
  country.slope_per_m = vec2(0.0f);
  country.lost = 0.515f;  // 0.4 times the sum of the woods' gains; what is found below goes off
  vec2 value = vec2(0.0f);
  vec2 gain = vec2(kPerByte, 0.42f * kPerByte);  // of rivers and of woods
  float footprint = long_m / lattice_cell_m(kCountryCells);
  vec2 turn_per_m = vec2(1.0f / lattice_cell_m(kCountryCells), 0.0f);
  vec2 p = lattice_position(ground_m, kCountryCells);
  uvec2 base = lattice_base(origin_index, kCountryCells);
  // Loops end where nothing is left: on a CPU an octave without weight costs as much as any other.
  for (int i = 0; i < kCountryOctaves && (i == 0 || footprint < 1.5f); ++i) {
    vec2 cell = floor(p);
    vec2 f = p - cell;
    base = base + uvec2(ivec2(cell));
    uvec4 h = corner_hashes(base);
    vec2 s = f * f * (3.0f - 2.0f * f);
    float fade = ground_fade(footprint);
    vec2 v00 = lower_bytes(h.x);
    vec2 v10 = lower_bytes(h.y);
    vec2 v01 = lower_bytes(h.z);
    vec2 v11 = lower_bytes(h.w);
    vec2 lower = mix(v00, v10, s.x);
    vec2 upper = mix(v01, v11, s.x);
    vec2 ds = 6.0f * f * (1.0f - f) * vec2(mix(v10.x - v00.x, v11.x - v01.x, s.y), upper.x - lower.x);
    vec2 weight = fade * gain;
    if (i == 0) weight.x = gain.x;  // so that river and slope are never both nothing
    value += weight * (mix(lower, upper, s.y) - 127.5f);
    country.slope_per_m += weight.x * complex_product(vec2(turn_per_m.x, -turn_per_m.y), ds);
    country.lost -= (0.4f / kPerByte) * weight.y;
    for (float w = i < 2 ? fade * gain.x : 0.0f; w > 0.0f; w = 0.0f)
      country.bend +=
          w * (mix(mix(upper_bytes(h.x), upper_bytes(h.y), s.x), mix(upper_bytes(h.z), upper_bytes(h.w), s.x), s.y) -
               127.5f);
    gain = gain * vec2(0.27f, 0.74f);
    p = next_octave(f);
    base = next_octave(base);
    turn_per_m = next_octave(turn_per_m);
    footprint *= kOctaveRatio;
  }
  country.river = value.x;
  country.wood = value.y;
  // And what the octaves found change across a pixel.
  country.lost = min(0.53f, country.lost + min(0.0015f * long_m, 0.03f + 0.0001f * min(long_m, 500.0f)));
  country.tufts = 0.0f;
  for (int i = 0; i < kTuftOctaves && footprint < 1.5f; ++i) {
    vec2 cell = floor(p);
    vec2 f = p - cell;
    base = base + uvec2(ivec2(cell));
    uvec4 h = corner_hashes(base);
    vec2 s = f * f * (3.0f - 2.0f * f);
    country.tufts +=
        0.3f * kPerByte * ground_fade(footprint) *
        (mix(mix(float(h.x >> 24u), float(h.y >> 24u), s.x), mix(float(h.z >> 24u), float(h.w >> 24u), s.x), s.y) -
         127.5f);
    p = next_octave(f);
    base = next_octave(base);
    footprint *= kOctaveRatio;
  }
  return country;
}

struct Fields {
  vec3 color;
  float hedge;  // share of the pixel
  float track;
  float thinned;   // what a field takes from or adds to the woods' noise, so that woods end at fields
  float contrast;  // of the field to its neighbours and mean, thinned's as well
};

// Estates in rows that are shifted against each other, each cut in two again and again. Every district has its own
// direction. settled: contrast that is left near the district's border.
NEPHELE_FN Fields fields_at(vec2 ground_m, ivec2 origin_index, Country country, float settled, vec2 along, float long_m,
                            float short_m) {
  bool outer = abs(country.river) > kLaneLevel;
  ivec2 axis = country.river > 0.0f ? (outer ? ivec2(7, 1) : ivec2(4, 6)) : (outer ? ivec2(6, 4) : ivec2(2, 7));
  float estate_m = lattice_cell_m(kEstateCells) * (1.0f / kEstateAxis);
  vec2 turned = complex_product(vec2(axis), along) * (1.0f / kEstateAxis);
  vec2 width_m = abs(turned) * long_m + abs(vec2(turned.y, turned.x)) * short_m;
  vec2 pixels = estate_m / width_m;  // across an estate
  vec2 q = complex_product(vec2(axis), lattice_position(ground_m, kEstateCells)) + 1.1f * country.bend;
  uvec2 base = lattice_base(origin_index, kEstateCells);
  base = uvec2(uint(axis.x) * base.x - uint(axis.y) * base.y, uint(axis.x) * base.y + uint(axis.y) * base.x);
  uint row = base.y + uint(int(floor(q.y)));
  q.x += hash_byte(ground_hash(row, 1u), 0u);
  uint column = base.x + uint(int(floor(q.x)));
  q = q - floor(q);
  Plot plot;
  plot.low = vec2(0.0f);
  plot.high = vec2(1.0f);
  plot.hash = ground_hash(column, row);
  Fields fields;
  fields.color = mean_field_color();
  float fewest = min(pixels.x, pixels.y);
  for (int i = 0; i < 2 && fewest > 0.8f; ++i) plot = half_plot(plot, q);
  float contrast = fewest > 0.8f ? settled * plot_contrast(plot, q, pixels) : 0.0f;
  fields.color += contrast * (hash_byte(plot.hash, 16u) - 0.5f) * vec3(0.085f, 0.065f, 0.05f);
  for (int i = 0; i < 2 && fewest > 1.2f; ++i) plot = half_plot(plot, q);
  contrast = fewest > 1.2f ? settled * plot_contrast(plot, q, pixels) : 0.0f;
  fields.color += 0.65f * contrast * (field_color(plot.hash) - mean_field_color());
  fields.contrast = contrast;
  fields.thinned = 0.22f * (hash_byte(plot.hash, 24u) - 0.5f);

  vec2 from_low = q - plot.low;
  vec2 from_high = plot.high - q;
  vec2 to_border_m = min(from_low, from_high) * estate_m;
  bool hedge_x = ((plot.hash >> (from_low.x < from_high.x ? 16u : 18u)) & 3u) == 0u;
  bool hedge_y = ((plot.hash >> (from_low.y < from_high.y ? 20u : 22u)) & 3u) == 0u;
  vec2 ends = min(vec2(1.0f), to_border_m / width_m);
  fields.hedge = settled * min(1.0f, (hedge_x ? ends.y * border_cover(to_border_m.x, 5.0f, width_m.x) : 0.0f) +
                                         (hedge_y ? ends.x * border_cover(to_border_m.y, 5.0f, width_m.y) : 0.0f));
  fields.track = settled * strip_cover(min(q.y, 1.0f - q.y) * pixels.y, 2.0f / width_m.y);
  bool upright = plot.high.x - plot.low.x < plot.high.y - plot.low.y;
  float furrow_m = upright ? to_border_m.x : to_border_m.y;
  float furrows = ground_fade(0.1f * (upright ? width_m.x : width_m.y));
  fields.color *= 1.0f + 0.06f * furrows * (4.0f * abs(fract(furrow_m * 0.05f) - 0.5f) - 1.0f);
  return fields;
}

// ground_m: place in the world's grid (not the clouds'), relative to origin_index units. The pixel's footprint is
// long_m in the direction `along` (a unit vector) and short_m across it.
NEPHELE_FN GroundCover ground_cover(vec2 ground_m, ivec2 origin_index, vec2 along, float long_m, float short_m) {
  long_m = max(long_m, 0.001f);
  short_m = max(short_m, 0.001f);
  Country country = country_at(ground_m, origin_index, long_m);
  // The way to a level of the noise is its difference over its slope.
  float steepness = length(country.slope_per_m) + 1.0e-5f;
  vec2 downhill = country.slope_per_m / steepness;
  float seen_m = long_m * abs(dot(along, downhill)) + short_m * abs(along.x * downhill.y - along.y * downhill.x);
  float per_m = 1.0f / max(seen_m, 0.001f);
  float per_noise = per_m / steepness;
  float river_px = abs(country.river) * per_noise;
  float lane_px = abs(abs(country.river) - kLaneLevel) * per_noise;
  float broad = max(0.0f, country.bend.y - 0.45f);
  float shore_px = (16.0f + 9.0f * country.bend.x + 1500.0f * broad * broad) * per_m;
  float bank = strip_cover(river_px, shore_px + 40.0f * per_m);
  // Pixels that see two districts see the mean of their fields.
  Fields fields = fields_at(ground_m, origin_index, country, min(1.0f, min(river_px, lane_px)), along, long_m, short_m);

  vec3 land = fields.color * (vec3(1.0f) + country.bend.x * vec3(0.24f, 0.10f, 0.22f));
  land = mix(land, bank_color(), 0.7f * bank) * (1.0f + 0.35f * country.tufts);
  land = mix(land, track_color(), fields.track);
  float edge = country.wood - kWoodLevel + 0.4f * bank + 0.12f * country.tufts;
  float wood = mix(smoothstep(-country.lost, country.lost, edge),
                   smoothstep(-country.lost, country.lost, edge + fields.thinned), fields.contrast);
  float trees = max(fields.hedge, wood);
  land = mix(land, wood_color() * (1.0f + 0.8f * country.tufts), trees);
  land = mix(land, track_color(), strip_cover(lane_px, 3.0f * per_m));

  GroundCover cover;
  cover.albedo_factor = max(vec3(0.02f), land / mean_land_color());
  cover.water =
      mix(kMeanWater, strip_cover(river_px, shore_px), ground_fade(long_m / (0.6f * lattice_cell_m(kCountryCells))));
  return cover;
}

// The same of a round footprint, and of the land alone.
NEPHELE_FN vec3 ground_variation(vec2 ground_m, ivec2 origin_index, float footprint_m) {
  return ground_cover(ground_m, origin_index, vec2(1.0f, 0.0f), footprint_m, footprint_m).albedo_factor;
}

NEPHELE_SHARED_END

#endif
