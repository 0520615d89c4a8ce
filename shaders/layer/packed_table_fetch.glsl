// The optical depth table packed to bytes (axes: shared/table_axes.h). The including shader defines PACKED_TABLE
// before, as the binding of its words.
#ifndef NEPHELE_PACKED_TABLE_FETCH_GLSL
#define NEPHELE_PACKED_TABLE_FETCH_GLSL

#include "kit/texels.glsl"
#include "shared/table_axes.h"

WORDS(PACKED_TABLE, packed_table);
layout(constant_id = 10) const uint kDepthVertices = 32u;  // along a side of an octahedral map of the packed table

vec2 neighbours_of(uint word, uint shift) {
  const uint bytes = word >> shift;
  return vec2(float(bytes & 255u), float((bytes >> 8u) & 255u));
}

// A table over n vertices along each axis, from the word `first` of the packed ones on: linear between the sixteen
// vertices about a place given in vertices (E.u, E.v, S.u, S.v).
float fetch_packed(uint first, uint n, vec4 place) {
  const vec4 low = clamp(floor(place), vec4(0.0), vec4(float(n) - 2.0));
  const vec4 f = place - low;
  const uvec4 at = uvec4(low);
  const uint group = packed_group(at.x), shift = 8u * (at.x - 3u * group);
  const uint row = first + packed_along_exit_u(group, n);
  const uint y[2] = {row + packed_along_exit_v(at.y), row + packed_along_exit_v(at.y + 1u)};
  const uint z[2] = {packed_along_entry_u(at.z, n), packed_along_entry_u(at.z + 1u, n)};
  const uint w[2] = {packed_along_entry_v(at.w, n), packed_along_entry_v(at.w + 1u, n)};
  vec2 slices[2];
  for (uint k = 0u; k < 2u; ++k) {
    vec2 rows[2];
    for (uint j = 0u; j < 2u; ++j)
      rows[j] = mix(neighbours_of(word_at(packed_table, y[0] + z[j] + w[k]), shift),
                    neighbours_of(word_at(packed_table, y[1] + z[j] + w[k]), shift), f.y);
    slices[k] = mix(rows[0], rows[1], f.z);
  }
  const vec2 both = mix(slices[0], slices[1], f.w);
  return mix(both.x, both.y, f.x) * (1.0 / 256.0);
}

// What fetch_optical_depth gives, from the packed table. A chord has the same density both ways: of its two ways the
// one is taken that enters at the lower map coordinate, so that half the table is read and stays in the cache.
vec2 fetch_packed_optical_depth(vec3 entry, vec3 exit) {
  const uint n = kDepthVertices;
  const vec2 s = octahedral_encode(entry) * float(n - 1u), e = octahedral_encode(exit) * float(n - 1u);
  const float root = fetch_packed(0u, n, e.y > s.y ? vec4(s, e) : vec4(e, s));
  const vec4 coarse = vec4(coarse_place(e.x, n), coarse_place(e.y, n), coarse_place(s.x, n), coarse_place(s.y, n));
  return vec2(mean_density_from_texel(root), fetch_packed(packed_words(n), coarse_vertices(n), coarse));
}

#endif
