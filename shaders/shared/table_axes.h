// The axes of the baked tables, each beside its inverse. Every axis is vertex-centred: value 0 is the centre of the
// first texel, value 1 the centre of the last, so that linear filtering reaches both ends exactly.
//
// Multiple scattering, one RGBA16F 3D texture: x = cosine c, y = half chord h, z = density axis of sigma (variables of
// scattering.h). A texel holds a0..a3; with x = cosine of the azimuth between view ray and light around the normal
//   radiance of orders >= 2 per unit irradiance = max(0, a0 + a1 x + a2 x^2 + a3 x^3) * multiple_scattering_scale(...).
//
// Optical depth, one RG16F 3D texture of N x N x N^2: entry point S and exit point E of a chord of the unit sphere,
// each on an octahedral map of N x N vertices; x = E.u, y = E.v, z = N * S.v + S.u. The maps' folds run along cell
// edges, so no interpolation crosses a seam. A texel holds the square root of the chord's mean density, which fades
// towards the rim about linearly, and the fraction of the chord before the first matter. Both are whole 256ths, at most
// 255, kept in half floats: devices may filter eight bits in eight bits, which errs more than the axes do. The fraction
// is given at every other vertex and the last (*coarse* vertices) and linear between them, so that it can be kept at
// those alone.
//
// The same packed for devices whose time goes to cache misses: a buffer of words, four bytes each, for which a look-up
// touches twice 3 cache lines instead of 8, in a table of 1.6 MiB instead of 4. First the density over all vertices,
// then the fraction over the coarse ones, each as blocks of words (packed_along_exit_u and so on).
#ifndef NEPHELE_SHARED_TABLE_AXES_H
#define NEPHELE_SHARED_TABLE_AXES_H

#include "ellipsoid.h"
#include "phase.h"
#include "scattering.h"

NEPHELE_SHARED_BEGIN

// Vertex-centred texture coordinate of the axis value t in [0, 1], n texels; and back.
NEPHELE_FN float texture_from_axis(float t, float n) { return (t * (n - 1.0f) + 0.5f) / n; }

NEPHELE_FN float axis_from_texture(float u, float n) { return (u * n - 0.5f) / (n - 1.0f); }

// c in [-1, 1]: finer around the terminator, c = 0.
NEPHELE_FN float axis_from_normal_cosine(float c) {
  return 0.5f + 0.5f * sign_not_zero(c) * pow(min(abs(c), 1.0f), 0.7f);
}

NEPHELE_FN float normal_cosine_from_axis(float t) {
  float s = 2.0f * t - 1.0f;
  return sign_not_zero(s) * pow(min(abs(s), 1.0f), 1.0f / 0.7f);
}

// The optical radius half way along the density axis: grows with the asymmetry of the phase function.
NEPHELE_FN float density_axis_middle(float g) {
  float a = abs(g);
  return 4.0f + 2.0f * clamp(a / 0.6f, 0.0f, 1.0f) + 2.0f * clamp((a - 0.85f) / 0.05f, 0.0f, 1.0f);
}

// sigma in [0, inf) on [0, 1].
NEPHELE_FN float axis_from_optical_radius(float sigma, float middle) { return sigma / (sigma + middle); }

NEPHELE_FN float optical_radius_from_axis(float t, float middle) { return middle * t / max(1.0f - t, 1e-6f); }

// Cosine of the azimuth between the light and the view ray around the normal; any value will do at the poles.
NEPHELE_FN float azimuth_cosine(float c, float h, float mu) {
  float scale = (1.0f - c * c) * (1.0f - h * h);
  return scale > 1e-12f ? clamp((mu - c * h) / sqrt(scale), -1.0f, 1.0f) : 0.0f;
}

// What is divided out of multiple scattering before it is stored: opacity of the chord, the density's overall effect,
// and the forward peak of the first few orders, which widens with the chord's optical length. Per sr, > 0 unless the
// chord or sigma is 0. For every phase function g is that of a Henyey-Greenstein function of similar peak.
NEPHELE_FN float multiple_scattering_scale(float h, float mu, float sigma, float g) {
  float tau = 2.0f * sigma * h;
  float peak = pow(max(abs(g), 1e-6f), 2.0f + min(tau * (1.0f / 6.0f), 3.0f));
  return (phase_henyey_greenstein(mu, peak) + 0.05f) * one_minus_exp(tau) * sigma / (2.0f + sigma);
}

// Texture coordinates of the multiple scattering table of size (columns, rows, slices).
NEPHELE_FN vec3 multiple_scattering_coordinates(float c, float h, float sigma, float g, vec3 size) {
  float t = axis_from_optical_radius(sigma, density_axis_middle(g));
  return vec3(texture_from_axis(axis_from_normal_cosine(c), size.x), texture_from_axis(clamp(h, 0.0f, 1.0f), size.y),
              texture_from_axis(t, size.z));
}

// Radiance of orders >= 2 per unit irradiance from the fetched coefficients.
NEPHELE_FN float multiple_scattering_radiance(vec4 a, float c, float h, float mu, float sigma, float g) {
  float x = azimuth_cosine(c, h, mu);
  return max(0.0f, a.x + x * (a.y + x * (a.z + x * a.w))) * multiple_scattering_scale(h, mu, sigma, g);
}

// A place in the optical depth table: two trilinear fetches, at z0 and z1, mixed by `weight`.
struct OpticalDepthCoordinates {
  vec2 exit_uv;
  float z0;
  float z1;
  float weight;
};

// S and E: unit vectors in the reference particle's frame; n: vertices along a side of an octahedral map. S.u is
// filtered by the texture unit inside one slice of S.v, from its first vertex to its last and never beyond.
NEPHELE_FN OpticalDepthCoordinates optical_depth_coordinates(vec3 entry, vec3 exit, float n) {
  vec2 s = octahedral_encode(entry) * (n - 1.0f);
  vec2 e = octahedral_encode(exit);
  float row = clamp(floor(s.y), 0.0f, n - 2.0f);
  float column = clamp(s.x, 0.0f, n - 1.0f);
  OpticalDepthCoordinates at;
  at.exit_uv = vec2(texture_from_axis(e.x, n), texture_from_axis(e.y, n));
  at.z0 = (row * n + column + 0.5f) / (n * n);
  at.z1 = ((row + 1.0f) * n + column + 0.5f) / (n * n);
  at.weight = clamp(s.y - row, 0.0f, 1.0f);
  return at;
}

// Coarse vertices along an axis of n; the vertex that one is; and a place on the axis, 0 .. n - 1, among them.
NEPHELE_FN uint coarse_vertices(uint n) { return n / 2u + 1u; }

NEPHELE_FN uint coarse_vertex(uint coarse, uint n) { return min(2u * coarse, n - 1u); }

NEPHELE_FN float coarse_place(float place, uint n) {
  float in_last_cell = n % 2u == 0u ? max(place - (float(n) - 2.0f), 0.0f) : 0.0f;  // half as wide as the others
  return 0.5f * (place + in_last_cell);
}

// A word of the packed table holds four vertices along E.u, from vertex 3 * group on, the first in the lowest byte: any
// two neighbours are in one word. Groups of an axis of n <= 128 vertices, and the group where two neighbours begin:
NEPHELE_FN uint packed_groups(uint n) { return (n + 1u) / 3u; }

NEPHELE_FN uint packed_group(uint vertex) {
  return (vertex * 43u) >> 7u;  // vertex / 3
}

// A word's place is the sum of its places along the axes. A block of 16 words, 64 bytes and a cache line of most CPUs,
// holds 4 x 2 x 2 vertices along E.v, S.u and S.v; blocks follow each other along E.v, then S.u, S.v and the groups of
// E.u.
NEPHELE_FN uint packed_entry_u_stride(uint n) { return 16u * ((n + 3u) / 4u); }

NEPHELE_FN uint packed_entry_v_stride(uint n) { return packed_entry_u_stride(n) * ((n + 1u) / 2u); }

NEPHELE_FN uint packed_exit_u_stride(uint n) { return packed_entry_v_stride(n) * ((n + 1u) / 2u); }

NEPHELE_FN uint packed_words(uint n) { return packed_groups(n) * packed_exit_u_stride(n); }

NEPHELE_FN uint packed_along_exit_u(uint group, uint n) { return group * packed_exit_u_stride(n); }

NEPHELE_FN uint packed_along_exit_v(uint vertex) { return (vertex & 3u) + (vertex >> 2u) * 16u; }

NEPHELE_FN uint packed_along_entry_u(uint vertex, uint n) {
  return ((vertex & 1u) << 2u) + (vertex >> 1u) * packed_entry_u_stride(n);
}

NEPHELE_FN uint packed_along_entry_v(uint vertex, uint n) {
  return ((vertex & 1u) << 3u) + (vertex >> 1u) * packed_entry_v_stride(n);
}

// The mean density of a chord from the fetched texel; the root of it is stored.
NEPHELE_FN float mean_density_from_texel(float texel) { return texel * texel; }

NEPHELE_SHARED_END

#endif
