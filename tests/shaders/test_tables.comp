// The tables' fetches and the shared maths below them, one ray a thread, for tests.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PACKED_TABLE 4
#include "layer/packed_table_fetch.glsl"
#include "layer/table_fetch.glsl"
#include "shared/reference_particle.h"

layout(local_size_x = 64) in;

struct TableQuery {
  vec3 entry;  // unit vectors
  vec3 exit;
  vec3 light;  // direction light travels
  float sigma;
  float g;
};

struct TableAnswer {
  vec2 optical_depth;
  vec2 packed_optical_depth;
  float single;
  float multiple;
  float phase;
  float density;  // of the reference particle, halfway along the chord
  float noise;
  uint hash;
};

layout(scalar, set = 0, binding = 0) readonly buffer Queries { TableQuery queries[]; };
layout(scalar, set = 0, binding = 1) writeonly buffer Answers { TableAnswer answers[]; };
layout(set = 0, binding = 2) uniform sampler3D optical_depth_table;
layout(set = 0, binding = 3) uniform sampler3D multiple_scattering_table;

layout(push_constant, scalar) uniform Push { uint count; }
push;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= push.count) return;
  TableQuery q = queries[i];
  vec3 chord = q.exit - q.entry;
  // A chord of no length has any direction: straight in.
  float span = length(chord);
  vec3 omega = span > 1e-6 ? -chord / span : q.entry;
  float c = dot(q.entry, q.light);
  float h = 0.5 * span;
  float mu = dot(omega, q.light);

  TableAnswer a;
  a.optical_depth = fetch_optical_depth(optical_depth_table, q.entry, q.exit);
  a.packed_optical_depth = fetch_packed_optical_depth(q.entry, q.exit);
  a.single = single_scattering(c, h, mu, q.sigma);
  a.multiple = fetch_multiple(multiple_scattering_table, c, h, mu, q.sigma, q.g);
  a.phase = phase_henyey_greenstein(mu, q.g);
  a.density = reference_particle_density(0.5 * (q.entry + q.exit), 5u);
  a.noise = fbm3(10.0 * q.entry, uvec3(0xfffffffeu, 3u, i), 9u, 3);
  a.hash = hash_ivec3(ivec3(floor(100.0 * q.entry)), i);
  answers[i] = a;
}
