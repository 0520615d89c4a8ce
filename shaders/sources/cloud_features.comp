#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// Evaluates every feature that the frame's particles can ask for, once: each is looked up some hundred times.
layout(local_size_x = 64) in;

#define FIELD_IN_STORAGE
#define WRITES_FEATURES
#define READS_WEATHER 2
#include "sources/cloud_features.glsl"
layout(scalar, set = 0, binding = 1) writeonly buffer Features { PackedFeature features[]; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  uint lattice;
  ivec2 cell;
  if (!cell_of_slot(constants.windows, i, lattice, cell)) return;
  features[i] = pack_feature(cloud_feature(cloud_params(constants.frame.field), lattice, cell));
}
