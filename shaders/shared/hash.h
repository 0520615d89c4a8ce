// Integer hashes: everything random is a hash of integer cell indices and a seed, the same on every device.
// Based on: O'Neill, PCG, 2014; Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 9(3), 2020.
#ifndef NEPHELE_SHARED_HASH_H
#define NEPHELE_SHARED_HASH_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

// One step of the generator with the RXS-M-XS output permutation: a bijection of 32 bits.
NEPHELE_FN uint hash_uint(uint x) {
  uint state = x * 747796405u + 2891336453u;
  uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

// Chained, so that no two cells within 2^32 of each other share a sequence by construction.
NEPHELE_FN uint hash_uvec2(uvec2 cell, uint seed) { return hash_uint(cell.y + hash_uint(cell.x + hash_uint(seed))); }

NEPHELE_FN uint hash_uvec3(uvec3 cell, uint seed) {
  return hash_uint(cell.z + hash_uint(cell.y + hash_uint(cell.x + hash_uint(seed))));
}

NEPHELE_FN uint hash_ivec2(ivec2 cell, uint seed) { return hash_uvec2(uvec2(cell), seed); }

NEPHELE_FN uint hash_ivec3(ivec3 cell, uint seed) { return hash_uvec3(uvec3(cell), seed); }

// The next value of a sequence: successive calls on one state give independent numbers.
NEPHELE_FN uint hash_next(NEPHELE_INOUT(uint) state) {
  state = hash_uint(state);
  return state;
}

// The upper 24 bits as a float in [0, 1): exact, never 1.
NEPHELE_FN float unit_float(uint hash) { return float(hash >> 8u) * (1.0f / 16777216.0f); }

// Uniform in [low, high).
NEPHELE_FN float uniform_float(NEPHELE_INOUT(uint) state, float low, float high) {
  return low + (high - low) * unit_float(hash_next(state));
}

NEPHELE_SHARED_END

#endif
