// The ground's albedo: a mosaic of fields and woods in dry and lush country, tied to the world, with mean 1 relative
// to the scene's albedo. Every part fades to its mean as a pixel's footprint outgrows it, so nothing shimmers.
#ifndef NEPHELE_SHARED_GROUND_H
#define NEPHELE_SHARED_GROUND_H

#include "noise.h"
#include "world.h"

NEPHELE_SHARED_BEGIN

// Lattices, in cells a unit of kOriginUnitM.
NEPHELE_CONST(uint, kCountryCells, 7u);    // 13.5 km
NEPHELE_CONST(uint, kDistrictCells, 29u);  // 3.2 km
NEPHELE_CONST(uint, kWoodCells, 61u);      // 1.5 km, and three octaves below
NEPHELE_CONST(uint, kFieldCells, 311u);    // 300 m
NEPHELE_CONST(uint, kTuftCells, 3511u);    // 27 m, and its octaves down to centimetres
NEPHELE_CONST(float, kHedgeM, 10.0f);
NEPHELE_CONST(uint, kGroundSeed, 0x67726e64u);

// The share of a pattern's contrast that is left when a footprint averages over it.
NEPHELE_FN float ground_fade(float size_m, float footprint_m) {
  return 1.0f - smoothstep(0.25f, 0.9f, footprint_m / size_m);
}

// How many octaves, each `ratio` times as fine as the one before, are left under a footprint. Loops end there: on a CPU
// an octave without weight costs as much as any other.
NEPHELE_FN int octaves_left(float size_m, float footprint_m, float ratio, int most) {
  return int(clamp(ceil(log(0.9f * size_m / footprint_m) / log(ratio)), 0.0f, float(most)));
}

NEPHELE_FN float ground_noise(vec2 ground_m, ivec2 origin_index, uint cells, uint salt) {
  return gradient_noise2(lattice_position(ground_m, cells), lattice_base(origin_index, cells), kGroundSeed + salt);
}

// Fields: a soft Voronoi mosaic whose seams are as wide as the footprint. x: brightness, y: ripeness, both in [-1, 1]
// with mean 0; z: nearness of a hedge, 1 on the seam. All 0 where the footprint has outgrown them.
NEPHELE_FN vec3 ground_fields(vec2 ground_m, ivec2 origin_index, float footprint_m) {
  vec2 p = lattice_position(ground_m, kFieldCells);
  vec2 cell = floor(p);
  vec2 f = p - cell;
  uvec2 base = lattice_base(origin_index, kFieldCells) + uvec2(ivec2(cell));
  float softness = 0.004f + 0.5f * footprint_m / lattice_cell_m(kFieldCells);
  float nearest = 9.0f;
  float second = 9.0f;
  vec2 sum = vec2(0.0f);
  float weights = 0.0f;
  int neighbours = ground_fade(lattice_cell_m(kFieldCells), footprint_m) > 0.0f ? 9 : 0;
  for (int i = 0; i < neighbours; ++i) {
    int x = i % 3 - 1;
    int y = i / 3 - 1;
    uint h = noise_mix(((base.x + uint(x)) * kNoiseSpreadX) ^ ((base.y + uint(y)) * kNoiseSpreadY) ^ kGroundSeed);
    float dx = abs(float(x) + 0.1f + 0.8f * float(h & 255u) * (1.0f / 255.0f) - f.x);
    float dy = abs(float(y) + 0.1f + 0.8f * float((h >> 8u) & 255u) * (1.0f / 255.0f) - f.y);
    float d = max(dx, dy) + 0.35f * min(dx, dy);  // between a square and a circle: fields have straight sides
    // Weights are relative to the nearest so far, so that they cannot all vanish.
    float less = exp(-min(60.0f, abs(d - nearest) / softness));
    float kept = d < nearest ? less : 1.0f;
    float w = d < nearest ? 1.0f : less;
    sum = kept * sum +
          w * vec2(float((h >> 16u) & 255u) * (2.0f / 255.0f) - 1.0f, float(h >> 24u) * (2.0f / 255.0f) - 1.0f);
    weights = kept * weights + w;
    second = min(second, max(nearest, d));
    nearest = min(nearest, d);
  }
  float hedge = kHedgeM / lattice_cell_m(kFieldCells);
  float seam = (1.0f - smoothstep(0.0f, hedge + 2.0f * softness, second - nearest)) * hedge / (hedge + 2.0f * softness);
  return neighbours > 0 ? vec3(sum / weights, seam) : vec3(0.0f);
}

// ground_m: place in the world's grid (not the clouds'), relative to origin_index units. footprint_m: the longer side
// of the pixel on the ground.
NEPHELE_FN vec3 ground_variation(vec2 ground_m, ivec2 origin_index, float footprint_m) {
  float dryness = 0.0f;
  float fade = ground_fade(lattice_cell_m(kCountryCells), footprint_m);
  if (fade > 0.0f) dryness += 0.8f * fade * ground_noise(ground_m, origin_index, kCountryCells, 1u);
  fade = ground_fade(lattice_cell_m(kDistrictCells), footprint_m);
  if (fade > 0.0f) dryness += 0.7f * fade * ground_noise(ground_m, origin_index, kDistrictCells, 2u);

  // Woods: where a noise of six octaves is high. The threshold widens by what the filter has taken from the noise,
  // which keeps their share near 0.3.
  float wood_noise = 0.0f;
  float lost = 0.02f;
  float gain = 1.0f;
  uint cells = kWoodCells;
  int octaves = octaves_left(lattice_cell_m(cells), footprint_m, 2.0f, 6);
  for (int i = 0; i < octaves; ++i) {
    fade = ground_fade(lattice_cell_m(cells), footprint_m);
    wood_noise += gain * fade * ground_noise(ground_m, origin_index, cells, 3u + uint(i));
    lost += 0.33f * gain * (1.0f - fade);
    gain *= 0.55f;
    cells *= 2u;
  }
  lost += 0.33f * (gain - 0.0276806f) / 0.45f;  // of the octaves left out: a geometric series up to 0.55^6
  float wood = smoothstep(0.17f - lost, 0.17f + lost, wood_noise - 0.3f * dryness);

  vec3 field =
      ground_fade(lattice_cell_m(kFieldCells), footprint_m) * ground_fields(ground_m, origin_index, footprint_m);

  float tuft = 0.0f;
  cells = kTuftCells;
  octaves = octaves_left(lattice_cell_m(cells), footprint_m, 3.0f, 7);
  for (int i = 0; i < octaves; ++i) {
    fade = ground_fade(lattice_cell_m(cells), footprint_m);
    tuft += 0.28f * fade * ground_noise(ground_m, origin_index, cells, 13u + uint(i));
    cells *= 3u;
  }

  vec3 open_land = vec3(1.0f) + dryness * vec3(0.40f, 0.16f, 0.10f) + field.x * vec3(0.20f, 0.19f, 0.16f) +
                   field.y * vec3(0.18f, 0.04f, -0.06f) - vec3(0.35f * field.z);
  vec3 color = mix(open_land, vec3(0.58f, 0.66f, 0.62f), wood) * (1.0f + tuft * (0.6f + 0.6f * wood));
  return max(vec3(0.05f), color * vec3(1.15f, 1.125f, 1.135f));  // back to a mean of 1, measured (ground_test)
}

NEPHELE_SHARED_END

#endif
