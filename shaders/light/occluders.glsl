// Occluders read as texels (PackedOccluder).
#ifndef NEPHELE_OCCLUDERS_GLSL
#define NEPHELE_OCCLUDERS_GLSL

#include "shared/light.h"
#include "kit/texels.glsl"

Occluder occluder_at(usamplerBuffer texels, uint i) {
  return unpack_occluder(
      PackedOccluder(texel_at(texels, 3u * i), texel_at(texels, 3u * i + 1u), texel_at(texels, 3u * i + 2u)));
}

#endif
