#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Each cell's source after a sweep: what its matter scatters of the light of all ordinates.
#include "light/light_lattice_buffer.glsl"
#include "light/light_source.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
layout(scalar, set = 0, binding = 1) readonly buffer Count {
  uvec3 groups;
  uint listed_count;
};
layout(scalar, set = 0, binding = 2) readonly buffer Pairs { LightPair pairs[]; };
WORDS(3, mean);
TEXELS(4, before);
layout(scalar, set = 0, binding = 5) buffer Source { uvec4 source[]; };  // of the sweep before, and of the next
layout(push_constant, scalar) uniform Push {
  uint cell_count;
  float step, again;  // weights of Chebyshev's method (light_solver.cpp)
};

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= listed_count) return;
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
  const LightSource old = unpack_light_source(texel_at(before, 2u * i), texel_at(before, 2u * i + 1u));
  // Before the first sweep there is no older source: `again` is 1, and what the buffer holds drops out.
  LightSource older = old;
  if (again != 1.0) older = unpack_light_source(source[2u * i], source[2u * i + 1u]);
  s.even = again * (step * (s.even - old.even) + old.even - older.even) + older.even;
  s.x = again * (step * (s.x - old.x) + old.x - older.x) + older.x;
  s.y = again * (step * (s.y - old.y) + old.y - older.y) + older.y;
  s.z = again * (step * (s.z - old.z) + old.z - older.z) + older.z;
  source[2u * i] = pack_light_low(s);
  source[2u * i + 1u] = pack_light_high(s);
}
