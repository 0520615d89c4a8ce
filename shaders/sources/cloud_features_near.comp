#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// For each cell of the features' lattices, where many places are looked at, the features around it that reach into it:
// the cells of the grid ask for these alone.
layout(local_size_x = 64) in;

#include "sources/cloud_features.glsl"
layout(scalar, set = 0, binding = 2) writeonly buffer Near { uint features_near[]; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  uint lattice;
  ivec2 cell;
  if (!cell_of_slot(constants.near_windows, i, lattice, cell)) return;
  const FeatureWindow window = window_of(constants.windows, lattice);
  uint bits = 0u;
  for (uint k = 0u; k < 9u; ++k) {
    const CloudFeature f = unpack_feature(feature_in(feature_slot(window, neighbour_cell(cell, k))));
    bits |= feature_reaches(f, lattice, cell) ? 1u << k : 0u;
  }
  features_near[i] = bits;
}
