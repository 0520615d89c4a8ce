#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// Each listed cell's light after the last sweep: the mean over the sphere of radiance times the spherical harmonics up
// to degree 2, red, green and blue of sun, sky and ground together, in units of frame.light_unit. Four texels of halves
// a cell.
#include "light/light_lattice_buffer.glsl"
#include "light/light_source.glsl"
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const bool kAir = true;  // false: a dummy is bound as the table
layout(scalar, set = 0, binding = 1) readonly buffer Count {
  uvec3 groups;
  uint listed_count;
};
layout(scalar, set = 0, binding = 2) readonly buffer Pairs { LightPair pairs[]; };
WORDS(3, listed);
WORDS(4, mean);
layout(scalar, set = 0, binding = 5) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 6) uniform sampler2D transmittance;
layout(scalar, set = 0, binding = 7) writeonly buffer Moments { uvec4 moments[]; };
layout(push_constant, scalar) uniform Push {
  uint cell_count;
  uint level;
};

#include "kit/light_lattice.glsl"

#include "light/light_sun.glsl"

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= listed_count) return;
  const vec3 sun = sun_irradiance(light_cell_middle(level, light_cell_place(word_at(listed, i)))) / frame.light_unit;
  vec3 m[kLightMoments];
  for (uint k = 0u; k < kLightMoments; ++k) m[k] = vec3(0.0);
  for (uint pair = 0u; pair < kLightPairs; ++pair) {
    const vec4 up = unpack_light(two_words_at(mean, 2u * pair * cell_count + i));
    const vec4 down = unpack_light(two_words_at(mean, (2u * pair + 1u) * cell_count + i));
    const LightHarmonics h = light_harmonics(pairs[pair].direction);
    const vec3 a = up.yzw + up.x * sun, b = down.yzw + down.x * sun;
    const vec3 even = kLightOrdinateShare * (a + b), odd = kLightOrdinateShare * (a - b);
    m[0] += even;
    for (uint k = 1u; k < 4u; ++k) m[k] += h.y[k] * odd;
    for (uint k = 4u; k < kLightMoments; ++k) m[k] += h.y[k] * even;
  }
  uint words[16];
  for (uint k = 0u; k < 13u; ++k) {  // channel by channel, two values a word
    const uint a = 2u * k, b = 2u * k + 1u;
    words[k] = packHalf2x16(vec2(m[a / 3u][a % 3u], m[b / 3u][b % 3u]));
  }
  words[13] = packHalf2x16(vec2(m[8].z, 0.0));
  words[14] = words[15] = 0u;
  for (uint k = 0u; k < 4u; ++k)
    moments[4u * i + k] = uvec4(words[4u * k], words[4u * k + 1u], words[4u * k + 2u], words[4u * k + 3u]);
}
