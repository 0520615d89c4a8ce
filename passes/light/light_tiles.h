// Light-space tile lists ([Yusov14] 5.3 step 1): for every tile of a grid across the sun's rays, the particles that a
// ray through it may meet, in order from the sun. Every generated particle is in, visible or not.
//
// Deviates from the paper: one 192^2 grid in logarithmic coordinates (shared/light.h) instead of 64^2 over a view
// volume, so that tiles match the particles from 100 m to 100 km; and lists are contiguous runs of one sorted array
// instead of linked lists, which need ordered pixel access.
//
// reads -> writes: frame constants, particles, counters -> occluders, tile lists; in counters tile_pair_*
// cost: a 16-bit sort of the particles and a 14-bit sort of the (tile, particle) pairs, some five a particle.
#pragma once

#include <cstdint>

#include "passes/kit/tile_pairs.h"

namespace nephele {

// What occlusion and cloud shadows read: TileLists of particle indices.
struct LightTileLists {
  const Buffer& occluders;  // PackedOccluder per particle
  const Buffer& ranges;
  const Buffer& list;
};

class LightTiles {
 public:
  // Pairs past pair_capacity are left out, those of the particles farthest from the sun, and counted in
  // FrameCounters.tile_pair_demand.
  LightTiles(Workshop& make, std::uint32_t particle_capacity, std::uint32_t pair_capacity);

  // constants is a FrameConstants, counters a FrameCounters whose particle_count and particle_groups are filled.
  LightTileLists add(FrameBuilder& frame, const Buffer& constants, const Buffer& particles, const Buffer& counters);

 private:
  const ComputeKernel& occluders_kernel_;
  RadixSort sun_sort_;
  TilePairs pairs_;
  Buffer& occluders_;
  Buffer& rectangles_;
};

}  // namespace nephele
