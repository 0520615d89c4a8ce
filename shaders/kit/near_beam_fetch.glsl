#ifndef NEPHELE_NEAR_BEAM_FETCH_GLSL
#define NEPHELE_NEAR_BEAM_FETCH_GLSL

#include "shared/near_beam_axes.h"

// Light scattered little from the beam, per sr and unit irradiance, at optical depth tau (lut/near_beam.h). mu: cosine
// between the ray from the eye and the way to the sun. Sampler: linear, clamped to the edge.
float fetch_near_beam(sampler2D table, float tau, float mu) {
  return textureLod(table, near_beam_coordinates(tau, mu, vec2(textureSize(table, 0))), 0.0).x;
}

#endif
