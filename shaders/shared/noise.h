// Gradient noise (after Perlin, Improving Noise, 2002) and cellular noise (Worley 1996) over lattices whose cells are
// numbered by wrapping 32-bit integers. A position is given in lattice cells, p, relative to the cell with index
// `base`: noise anchored in the world passes base = uint(n * origin_index) and stays exact however far the origin is.
// Octaves double both. The periodic variants repeat after `period` cells along each axis.
#ifndef NEPHELE_SHARED_NOISE_H
#define NEPHELE_SHARED_NOISE_H

#include "hash.h"

NEPHELE_SHARED_BEGIN

// Multipliers that spread a cell index before mixing; the octave's is the golden ratio's.
NEPHELE_CONST(uint, kNoiseSpreadX, 0x8da6b343u);
NEPHELE_CONST(uint, kNoiseSpreadY, 0xd8163841u);
NEPHELE_CONST(uint, kNoiseSpreadZ, 0xcb1ab31fu);
NEPHELE_CONST(uint, kNoiseOctaveSeed, 0x9e3779b9u);

// A full avalanche of the xor of spread indices: cheaper than a chained hash, 8 to 27 of which a noise value needs.
NEPHELE_FN uint noise_mix(uint x) {
  x = (x ^ (x >> 16u)) * 0x7feb352du;
  x = (x ^ (x >> 15u)) * 0x846ca68bu;
  return x ^ (x >> 16u);
}

NEPHELE_FN float noise_fade(float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }

NEPHELE_FN uint noise_seed(uint seed, int octave) { return noise_mix(seed + uint(octave) * kNoiseOctaveSeed); }

// Dot product with a direction of length about sqrt(2) from the hash: a parabolic sine of a uniform angle.
NEPHELE_FN float noise_gradient2(uint hash, float x, float y) {
  float t = float(hash >> 8u) * (2.0f / 16777216.0f) - 1.0f;
  float q = t + (t < 0.5f ? 0.5f : -1.5f);
  float sine = 4.0f * t * (1.0f - abs(t));
  float cosine = 4.0f * q * (1.0f - abs(q));
  return 1.41421356f * (sine * y + cosine * x);
}

// Dot product with one of the twelve edge directions of a cube (four of them twice).
NEPHELE_FN float noise_gradient3(uint hash, float x, float y, float z) {
  uint h = hash >> 28u;
  float u = h < 8u ? x : y;
  float v = h < 4u ? y : ((h == 12u || h == 14u) ? x : z);
  return ((h & 1u) == 0u ? u : -u) + ((h & 2u) == 0u ? v : -v);
}

// Noise inside the cell whose corners have indices lower and upper; f in [0, 1] is the place in the cell.
NEPHELE_FN float gradient_noise2_cell(uvec2 lower, uvec2 upper, vec2 f, uint seed) {
  uint x0 = lower.x * kNoiseSpreadX ^ seed;
  uint x1 = upper.x * kNoiseSpreadX ^ seed;
  uint y0 = lower.y * kNoiseSpreadY;
  uint y1 = upper.y * kNoiseSpreadY;
  float wx = noise_fade(f.x);
  float bottom =
      mix(noise_gradient2(noise_mix(x0 ^ y0), f.x, f.y), noise_gradient2(noise_mix(x1 ^ y0), f.x - 1.0f, f.y), wx);
  float top = mix(noise_gradient2(noise_mix(x0 ^ y1), f.x, f.y - 1.0f),
                  noise_gradient2(noise_mix(x1 ^ y1), f.x - 1.0f, f.y - 1.0f), wx);
  return mix(bottom, top, noise_fade(f.y));
}

NEPHELE_FN float gradient_noise3_cell(uvec3 lower, uvec3 upper, vec3 f, uint seed) {
  uint x0 = lower.x * kNoiseSpreadX ^ seed;
  uint x1 = upper.x * kNoiseSpreadX ^ seed;
  uint y0 = lower.y * kNoiseSpreadY;
  uint y1 = upper.y * kNoiseSpreadY;
  uint z0 = lower.z * kNoiseSpreadZ;
  uint z1 = upper.z * kNoiseSpreadZ;
  float gx = f.x - 1.0f;
  float gy = f.y - 1.0f;
  float gz = f.z - 1.0f;
  float wx = noise_fade(f.x);
  float n00 = mix(noise_gradient3(noise_mix(x0 ^ y0 ^ z0), f.x, f.y, f.z),
                  noise_gradient3(noise_mix(x1 ^ y0 ^ z0), gx, f.y, f.z), wx);
  float n10 = mix(noise_gradient3(noise_mix(x0 ^ y1 ^ z0), f.x, gy, f.z),
                  noise_gradient3(noise_mix(x1 ^ y1 ^ z0), gx, gy, f.z), wx);
  float n01 = mix(noise_gradient3(noise_mix(x0 ^ y0 ^ z1), f.x, f.y, gz),
                  noise_gradient3(noise_mix(x1 ^ y0 ^ z1), gx, f.y, gz), wx);
  float n11 = mix(noise_gradient3(noise_mix(x0 ^ y1 ^ z1), f.x, gy, gz),
                  noise_gradient3(noise_mix(x1 ^ y1 ^ z1), gx, gy, gz), wx);
  float wy = noise_fade(f.y);
  return mix(mix(n00, n10, wy), mix(n01, n11, wy), noise_fade(f.z));
}

// Gradient noise, zero at every lattice point, nearly all within [-1, 1], standard deviation about 0.3.
// |p| < 2^23, beyond which a float has no fraction.
NEPHELE_FN float gradient_noise2(vec2 p, uvec2 base, uint seed) {
  vec2 cell = floor(p);
  uvec2 lower = base + uvec2(ivec2(cell));
  return gradient_noise2_cell(lower, lower + uvec2(1u), p - cell, seed);
}

NEPHELE_FN float gradient_noise3(vec3 p, uvec3 base, uint seed) {
  vec3 cell = floor(p);
  uvec3 lower = base + uvec3(ivec3(cell));
  return gradient_noise3_cell(lower, lower + uvec3(1u), p - cell, seed);
}

// Repeats after `period` cells; 0 <= p < 2^23.
NEPHELE_FN float gradient_noise3_periodic(vec3 p, uint period, uint seed) {
  vec3 cell = floor(p);
  uvec3 lower = uvec3(ivec3(cell)) % period;
  return gradient_noise3_cell(lower, (lower + uvec3(1u)) % period, p - cell, seed);
}

// `octaves` octaves, frequency doubling, gain 0.5, divided by the sum of gains.
NEPHELE_FN float fbm2(vec2 p, uvec2 base, uint seed, int octaves) {
  float sum = 0.0f;
  float gains = 0.0f;
  float gain = 1.0f;
  for (int i = 0; i < octaves; ++i) {
    sum += gain * gradient_noise2(p, base, noise_seed(seed, i));
    gains += gain;
    gain *= 0.5f;
    p = p * 2.0f;
    base = base * 2u;
  }
  return sum / gains;
}

NEPHELE_FN float fbm3(vec3 p, uvec3 base, uint seed, int octaves) {
  float sum = 0.0f;
  float gains = 0.0f;
  float gain = 1.0f;
  for (int i = 0; i < octaves; ++i) {
    sum += gain * gradient_noise3(p, base, noise_seed(seed, i));
    gains += gain;
    gain *= 0.5f;
    p = p * 2.0f;
    base = base * 2u;
  }
  return sum / gains;
}

NEPHELE_FN float fbm3_periodic(vec3 p, uint period, uint seed, int octaves) {
  float sum = 0.0f;
  float gains = 0.0f;
  float gain = 1.0f;
  for (int i = 0; i < octaves; ++i) {
    sum += gain * gradient_noise3_periodic(p, period, noise_seed(seed, i));
    gains += gain;
    gain *= 0.5f;
    p = p * 2.0f;
    period = period * 2u;
  }
  return sum / gains;
}

// Squared distance from f, a place in cell 0, to the feature of the neighbour cell at `offset`.
NEPHELE_FN float worley_distance2(uvec3 cell, vec3 offset, vec3 f, uint seed) {
  uint h = noise_mix(cell.x * kNoiseSpreadX ^ cell.y * kNoiseSpreadY ^ cell.z * kNoiseSpreadZ ^ seed);
  vec3 feature = (vec3(float(h & 1023u), float((h >> 10u) & 1023u), float(h >> 22u)) + 0.5f) * (1.0f / 1024.0f);
  vec3 d = offset + feature - f;
  return dot(d, d);
}

// F1: the distance in cells to the nearest feature, one uniform feature a cell. Mean 0.52; the 27 nearest cells
// decide every distance below 1, and larger ones are rare. Repeats after `period` cells; 0 <= p < 2^23.
NEPHELE_FN float worley_f1_periodic(vec3 p, uint period, uint seed) {
  vec3 cell = floor(p);
  vec3 f = p - cell;
  uvec3 center = uvec3(ivec3(cell)) + uvec3(period);
  float nearest = 1e9f;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        nearest =
            min(nearest, worley_distance2((center + uvec3(ivec3(x, y, z))) % period, vec3(ivec3(x, y, z)), f, seed));
  return sqrt(nearest);
}

// Octaves of 1 - min(1, F1), gain 0.5, divided by the sum of gains: in [0, 1], high near features.
NEPHELE_FN float worley_fbm_periodic(vec3 p, uint period, uint seed, int octaves) {
  float sum = 0.0f;
  float gains = 0.0f;
  float gain = 1.0f;
  for (int i = 0; i < octaves; ++i) {
    sum += gain * (1.0f - min(1.0f, worley_f1_periodic(p, period, noise_seed(seed, i))));
    gains += gain;
    gain *= 0.5f;
    p = p * 2.0f;
    period = period * 2u;
  }
  return sum / gains;
}

// Round lumps, one around each cell's feature: the sum of (1 - d^2)^3 over features nearer than one cell. Twice
// differentiable; the 27 nearest cells hold every feature that counts.
NEPHELE_CONST(float, kBillowMean, 0.638f);  // of the noise: 64 pi / 315

NEPHELE_FN float billow_noise3(vec3 p, uvec3 base, uint seed) {
  vec3 cell = floor(p);
  vec3 f = p - cell;
  uvec3 center = base + uvec3(ivec3(cell));
  float sum = 0.0f;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        float near = max(0.0f, 1.0f - worley_distance2(center + uvec3(ivec3(x, y, z)), vec3(ivec3(x, y, z)), f, seed));
        sum += near * near * near;
      }
  return sum;
}

NEPHELE_SHARED_END

#endif
