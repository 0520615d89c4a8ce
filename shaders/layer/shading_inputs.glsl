// What shading by whole chords reads besides the particle (passes/layer/shading_inputs.h).
#ifndef NEPHELE_SHADING_INPUTS_GLSL
#define NEPHELE_SHADING_INPUTS_GLSL

#ifndef PACKED_TABLE
layout(set = 0, binding = 16) uniform sampler3D optical_depth_table;
#endif
layout(set = 0, binding = 17) uniform sampler3D multiple_table;
layout(set = 0, binding = 18) uniform sampler3D structure_tile_volume;
layout(set = 0, binding = 19) uniform sampler3D particle_density;

#include "layer/field_light.glsl"

#endif
