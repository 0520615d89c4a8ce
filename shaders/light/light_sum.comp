#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Each cell's source after a sweep: what its matter scatters of the light of all ordinates and of the beam.
#include "light/light_lattice_buffer.glsl"
#include "light/light_source.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 1) readonly buffer Count {
  uvec3 groups;
  uint listed_count;
};
layout(scalar, set = 0, binding = 2) readonly buffer Pairs { LightPair pairs[]; };
WORDS(3, depths);
WORDS(4, mean);
TEXELS(5, before);
layout(scalar, set = 0, binding = 6) writeonly buffer Source { uvec4 source[]; };
WORDS(7, sigma);
layout(push_constant, scalar) uniform Push {
  uint cell_count;
  float weight;  // of the step from the source before
};

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= listed_count) return;
  const float scale = 1.0 - lattice.forward;
  LightSource s = LightSource(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
  const float odd = 3.0 * lattice.scaled_asymmetry * kLightOrdinateShare;
  for (uint pair = 0u; pair < kLightPairs; ++pair) {
    const vec4 up = unpack_light(two_words_at(mean, 2u * pair * cell_count + i));
    const vec4 down = unpack_light(two_words_at(mean, (2u * pair + 1u) * cell_count + i));
    const vec3 d = odd * pairs[pair].direction;
    const vec4 net = up - down;
    s.even += kLightOrdinateShare * (up + down);
    s.x += d.x * net;
    s.y += d.y * net;
    s.z += d.z * net;
  }
  add_beam(s, mean_beam(scale * float_at(depths, i), scale * float_at(sigma, i) * lattice.beam_way_m),
           -lattice.sun_direction, lattice.scaled_asymmetry);
  const LightSource old = unpack_light_source(texel_at(before, 2u * i), texel_at(before, 2u * i + 1u));
  s.even = mix(old.even, s.even, weight);
  s.x = mix(old.x, s.x, weight);
  s.y = mix(old.y, s.y, weight);
  s.z = mix(old.z, s.z, weight);
  source[2u * i] = pack_light_low(s);
  source[2u * i + 1u] = pack_light_high(s);
}
