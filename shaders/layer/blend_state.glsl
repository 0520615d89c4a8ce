// A pixel's blend state as three RGBA32F texels. Distances need 32 bits: rounded to half floats, segments
// that overlap would be taken for separate ones and the other way round.
#ifndef NEPHELE_BLEND_STATE_GLSL
#define NEPHELE_BLEND_STATE_GLSL

#include "shared/blend.h"

BlendState unpack_blend_state(vec4 open, vec4 extent, vec4 committed) {
  BlendState state;
  state.open.radiance = open.rgb;
  state.open.extinction_per_m = open.a;
  state.open.near_m = extent.x;
  state.open.far_m = extent.y;
  state.first_m = extent.z;
  state.committed = committed.rgb;
  state.transmittance = committed.a;
  return state;
}

void pack_blend_state(BlendState state, out vec4 open, out vec4 extent, out vec4 committed) {
  open = vec4(state.open.radiance, state.open.extinction_per_m);
  extent = vec4(state.open.near_m, state.open.far_m, state.first_m, 0.0);
  committed = vec4(state.committed, state.transmittance);
}

#endif
