// Source radiance of scattering in a cell, linear in the direction: even + x dx + y dy + z dz. Channels: sunlight per
// unit irradiance; red, green and blue of sky and ground in units of frame.light_unit.
#ifndef NEPHELE_LIGHT_SOURCE_GLSL
#define NEPHELE_LIGHT_SOURCE_GLSL

#include "shared/light_lattice.h"

struct LightSource {
  vec4 even, x, y, z;
};

uvec2 pack_light(vec4 v) { return uvec2(packHalf2x16(v.xy), packHalf2x16(v.zw)); }
vec4 unpack_light(uvec2 v) { return vec4(unpackHalf2x16(v.x), unpackHalf2x16(v.y)); }

uvec4 pack_light_low(LightSource s) { return uvec4(pack_light(s.even), pack_light(s.x)); }
uvec4 pack_light_high(LightSource s) { return uvec4(pack_light(s.y), pack_light(s.z)); }
LightSource unpack_light_source(uvec4 low, uvec4 high) {
  return LightSource(unpack_light(low.xy), unpack_light(low.zw), unpack_light(high.xy), unpack_light(high.zw));
}

// Mean over a cell of what is left of the beam, light in the forward peak included. scaled_depth: towards the sun, at
// the cell's middle; own: the cell's own along a sun ray.
float mean_beam(float scaled_depth, float own) { return exp(0.5 * own - scaled_depth) * mean_transmittance(own); }

#endif
