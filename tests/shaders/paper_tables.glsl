// Fetches from the paper's 4D tables (axes: shared/paper_axes.h). Samplers: linear, clamped to the edge.
#ifndef NEPHELE_PAPER_TABLES_GLSL
#define NEPHELE_PAPER_TABLES_GLSL

#include "shared/paper_axes.h"

// Mean extinction over peak and the fraction of the chord before the first matter; or radiance (single scattering
// without its phase function). `size` counts the vertices along each axis.
vec2 fetch_paper(sampler3D table, vec4 axes, vec4 size) {
  PaperCoordinates at = paper_coordinates(axes, size);
  return mix(textureLod(table, vec3(at.xy, at.z0), 0.0).xy, textureLod(table, vec3(at.xy, at.z1), 0.0).xy, at.weight);
}

#endif
