// One tile of the air's structure (shared/structure.h), once.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/structure.h"

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(set = 0, binding = 0, r8) writeonly uniform image3D tile;

void main() {
  const ivec3 at = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(at, ivec3(kStructureTexels)))) return;
  imageStore(tile, at, vec4(structure_tile((vec3(at) + 0.5) * (float(kStructureCells) / float(kStructureTexels)))));
}
