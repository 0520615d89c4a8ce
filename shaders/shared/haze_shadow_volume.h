// Axes of the volume of shadowed haze: the camera's frustum from edge to edge, by distance to where the clouds end.
#ifndef NEPHELE_SHARED_HAZE_SHADOW_VOLUME_H
#define NEPHELE_SHARED_HAZE_SHADOW_VOLUME_H

#include "atmosphere_tables.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kHazeShadowWidth, 128u);
NEPHELE_CONST(uint, kHazeShadowHeight, 72u);
NEPHELE_CONST(uint, kHazeShadowSteps, 64u);
NEPHELE_CONST(uint, kHazeShadowStepsPerSlice, 2u);
NEPHELE_CONST(uint, kHazeShadowDepth, 33u);  // steps / steps per slice + 1

// Quadratic: the first step is 20 m long, the last 2.5 km at a reach of 80 km.
NEPHELE_FN float haze_shadow_distance(float unit, float reach_m) { return unit * unit * reach_m; }

// image_unit: place in the image, (0, 0) its upper left corner.
NEPHELE_FN vec3 haze_shadow_lookup(Table3D haze_shadow, vec2 image_unit, float distance_m, float reach_m) {
  float unit = sqrt(clamp(distance_m / reach_m, 0.0f, 1.0f));
  return table_rgb(sample_table(haze_shadow, vec3(texel_from_unit(image_unit.x, float(kHazeShadowWidth)),
                                                  texel_from_unit(image_unit.y, float(kHazeShadowHeight)),
                                                  texel_from_unit(unit, float(kHazeShadowDepth)))));
}

NEPHELE_SHARED_END

#endif
