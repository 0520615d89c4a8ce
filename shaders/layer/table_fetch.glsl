// Fetches from the baked tables (axes: shared/table_axes.h). Samplers: linear, clamped to the edge. Packed tables:
// words as texels.
#ifndef NEPHELE_TABLE_FETCH_GLSL
#define NEPHELE_TABLE_FETCH_GLSL

#include "shared/table_axes.h"

// The noisy reference particle along the chord from S to E, unit vectors in its own frame: x = mean extinction divided
// by the peak extinction, y = fraction of the chord in front of the first matter (1 when there is none).
vec2 fetch_optical_depth(sampler3D table, vec3 entry, vec3 exit) {
  OpticalDepthCoordinates at = optical_depth_coordinates(entry, exit, float(textureSize(table, 0).x));
  vec2 texel = mix(textureLod(table, vec3(at.exit_uv, at.z0), 0.0).xy,
                   textureLod(table, vec3(at.exit_uv, at.z1), 0.0).xy, at.weight);
  return vec2(mean_density_from_texel(texel.x), texel.y);
}

layout(constant_id = 10) const uint kDepthVertices = 32u;  // along a side of an octahedral map of the packed table

vec2 neighbours_of(uint word, uint shift) {
  const uint bytes = word >> shift;
  return vec2(float(bytes & 255u), float((bytes >> 8u) & 255u));
}

// A packed table over n vertices along each axis, from the word `first` on: linear between the sixteen vertices about a
// place given in vertices (E.u, E.v, S.u, S.v).
float fetch_packed(usamplerBuffer table, uint first, uint n, vec4 place) {
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
      rows[j] = mix(neighbours_of(texelFetch(table, int(y[0] + z[j] + w[k])).x, shift),
                    neighbours_of(texelFetch(table, int(y[1] + z[j] + w[k])).x, shift), f.y);
    slices[k] = mix(rows[0], rows[1], f.z);
  }
  const vec2 both = mix(slices[0], slices[1], f.w);
  return mix(both.x, both.y, f.x) * (1.0 / 256.0);
}

// The same from the packed table. A chord has the same density both ways: of its two ways the one is taken that enters
// at the lower map coordinate, so that half the table is read and stays in the cache.
vec2 fetch_optical_depth(usamplerBuffer table, vec3 entry, vec3 exit) {
  const uint n = kDepthVertices;
  const vec2 s = octahedral_encode(entry) * float(n - 1u), e = octahedral_encode(exit) * float(n - 1u);
  const float root = fetch_packed(table, 0u, n, e.y > s.y ? vec4(s, e) : vec4(e, s));
  const vec4 coarse = vec4(coarse_place(e.x, n), coarse_place(e.y, n), coarse_place(s.x, n), coarse_place(s.y, n));
  return vec2(mean_density_from_texel(root), fetch_packed(table, packed_words(n), coarse_vertices(n), coarse));
}

// Radiance of orders >= 2 leaving the homogeneous sphere per unit irradiance, per sr. Variables: shared/scattering.h.
float fetch_multiple(sampler3D table, float c, float h, float mu, float sigma, float g) {
  vec3 at = multiple_scattering_coordinates(c, h, sigma, g, vec3(textureSize(table, 0)));
  return multiple_scattering_radiance(textureLod(table, at, 0.0), c, h, mu, sigma, g);
}

#endif
