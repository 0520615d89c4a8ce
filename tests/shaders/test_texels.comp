// Engine test: records read as texels are what was written as structures.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "kit/texels.glsl"

layout(local_size_x = 64) in;
PARTICLES(0, particles);
PARTICLE_LIGHTS(1, lights);
DRAW_PARTICLES(2, draw_particles);
WORDS(3, words);
layout(scalar, set = 0, binding = 4) writeonly buffer ParticlesOut { Particle particles_out[]; };
layout(scalar, set = 0, binding = 5) writeonly buffer LightsOut { ParticleLight lights_out[]; };
layout(scalar, set = 0, binding = 6) writeonly buffer DrawParticlesOut { DrawParticle draw_particles_out[]; };
layout(scalar, set = 0, binding = 7) writeonly buffer WordsOut { uint words_out[]; };
layout(push_constant, scalar) uniform Push { uint count; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  particles_out[i] = particle_at(particles, i);
  lights_out[i] = particle_light_at(lights, i);
  draw_particles_out[i] = draw_particle_at(draw_particles, i);
  words_out[i] = word_at(words, i);
}
