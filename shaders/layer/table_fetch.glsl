// Fetches from the baked tables (axes: shared/table_axes.h). Samplers: linear, clamped to the edge.
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

// Radiance of orders >= 2 leaving the homogeneous sphere per unit irradiance, per sr. Variables: shared/scattering.h.
float fetch_multiple(sampler3D table, float c, float h, float mu, float sigma, float g) {
  vec3 at = multiple_scattering_coordinates(c, h, sigma, g, vec3(textureSize(table, 0)));
  return multiple_scattering_radiance(textureLod(table, at, 0.0), c, h, mu, sigma, g);
}

#endif
