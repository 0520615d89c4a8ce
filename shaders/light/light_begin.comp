#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// The beam's first scattering in each cell; and the source that the first sweep starts from, the mean radiance from
// outside, which is all there is in a white furnace.
#include "light/light_lattice_buffer.glsl"
#include "light/light_source.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 1) readonly buffer Count {
  uvec3 groups;
  uint listed_count;
};
WORDS(2, depths);
layout(scalar, set = 0, binding = 3) readonly buffer Boundary { vec4 boundary[]; };
layout(scalar, set = 0, binding = 4) writeonly buffer Source { uvec4 source[]; };
WORDS(5, sigma);
layout(scalar, set = 0, binding = 6) writeonly buffer Beam { float beam[]; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= listed_count) return;
  const float scale = 1.0 - lattice.forward;
  vec4 mean = vec4(0.0);
  for (uint k = 0u; k < kLightOrdinates; ++k) mean += kLightOrdinateShare * boundary[k];
  LightSource s = LightSource(mean, vec4(0.0), vec4(0.0), vec4(0.0));
  beam[i] = mean_beam(scale * float_at(depths, i), scale * float_at(sigma, i) * lattice.beam_way_m) * (0.25 / kPi);
  source[2u * i] = pack_light_low(s);
  source[2u * i + 1u] = pack_light_high(s);
}
