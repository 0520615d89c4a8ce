// OCCLUDERS(binding, name) declares a buffer of PackedOccluder as kit/texels.glsl does; occluder_at reads it.
#ifndef NEPHELE_OCCLUDERS_GLSL
#define NEPHELE_OCCLUDERS_GLSL

#include "shared/light.h"
#include "kit/texels.glsl"

#define OCCLUDERS(at, name)                                                                             \
  TEXELS(at, name)                                                                                      \
  Occluder name##_occluder(uint i) {                                                                    \
    return unpack_occluder(                                                                             \
        PackedOccluder(vec4_at(name, 3u * i), vec4_at(name, 3u * i + 1u), vec4_at(name, 3u * i + 2u))); \
  }
#define occluder_at(name, i) name##_occluder(i)

#endif
