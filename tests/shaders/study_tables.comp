// What a table look-up costs, one ray a thread, for the study in tests/study/paper_tables_test.cpp.
// variants: - packed=PACKED_TABLE=2
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#ifdef PACKED_TABLE
#include "layer/packed_table_fetch.glsl"
#endif
#include "layer/table_fetch.glsl"
#include "paper_tables.glsl"

layout(local_size_x = 64) in;

// 0 nothing, 1 all of the paper's, 2 all of ours, 3 the paper's optical depth, 4 ours, 5 the paper's two scattering
// fetches, 6 single scattering by the formula, 7 one fetch of multiple scattering. Of a packed table 2 or 4 alone.
layout(constant_id = 0) const uint kWhat = 0u;

struct Query {
  vec3 entry;  // unit vectors
  vec3 exit;
  vec3 light;  // direction light travels
  float sigma;
};

layout(scalar, set = 0, binding = 0) readonly buffer Queries { Query queries[]; };
layout(scalar, set = 0, binding = 1) writeonly buffer Answers { vec3 answers[]; };  // mean density, single, multiple
#ifndef PACKED_TABLE
layout(set = 0, binding = 2) uniform sampler3D optical_depth_table;
#endif
layout(set = 0, binding = 3) uniform sampler3D single_table;
layout(set = 0, binding = 4) uniform sampler3D multiple_table;

layout(push_constant, scalar) uniform Push {
  uint count;
  float g;
  vec4 optical_depth_size;  // of the paper's tables
  vec4 scattering_size;
}
push;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= push.count) return;
  Query q = queries[i];
  vec3 chord = q.exit - q.entry;
  float span = length(chord);
  float c = dot(q.entry, q.light);
  float h = 0.5 * span;
  float mu = -dot(chord, q.light) / max(span, 1e-6);
  vec3 answer = vec3(c, h, mu);
#ifndef PACKED_TABLE
  if (kWhat == 1u || kWhat == 3u) {
    vec4 at = paper_chord_axes(q.entry, q.exit);
    answer.x = fetch_paper(optical_depth_table, at, push.optical_depth_size).x;
  }
  if (kWhat == 2u || kWhat == 4u) answer.x = fetch_optical_depth(optical_depth_table, q.entry, q.exit).x;
#else
  if (kWhat == 2u || kWhat == 4u) answer.x = fetch_packed_optical_depth(q.entry, q.exit).x;
#endif
  if (kWhat == 1u || kWhat == 5u) {
    // Both tables are read at the same angles; single scattering in a sphere as dense as the chord.
    vec4 at = paper_scattering_axes(c, h, mu, q.sigma);
    answer.z = fetch_paper(multiple_table, at, push.scattering_size).x;
    at.w = paper_scattering_axes(c, h, mu, q.sigma * (kWhat == 1u ? answer.x : 1.0)).w;
    answer.y = fetch_paper(single_table, at, push.scattering_size).x;
  }
  if (kWhat == 2u || kWhat == 6u) answer.y = single_scattering(c, h, mu, q.sigma * (kWhat == 2u ? answer.x : 1.0));
  if (kWhat == 2u || kWhat == 7u) answer.z = fetch_multiple(multiple_table, c, h, mu, q.sigma, push.g);
  answers[i] = answer;
}
