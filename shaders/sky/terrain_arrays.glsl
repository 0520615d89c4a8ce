// The terrain's arrays as the passes of passes/sky/terrain.h bind them: the view at 1, heights at 2, maxima at 3.
#ifndef NEPHELE_TERRAIN_ARRAYS_GLSL
#define NEPHELE_TERRAIN_ARRAYS_GLSL

#include "kit/texels.glsl"

WORDS(2, heights);
WORDS(3, highest);
#define NEPHELE_TERRAIN_HEIGHT(terrain, i) float_at(heights, i)
#define NEPHELE_TERRAIN_HIGHEST(terrain, i) float_at(highest, i)
#include "shared/heightfield.h"

layout(scalar, set = 0, binding = 1) readonly buffer View { TerrainConstants view; };

#endif
