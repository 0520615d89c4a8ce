// Ends every pixel's blending: commits the open segment and writes the cloud layer.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "layer/blend_state.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D open_image;
layout(set = 0, binding = 1) uniform sampler2D extent_image;
layout(set = 0, binding = 2) uniform sampler2D committed_image;
layout(set = 0, binding = 3, rgba32f) writeonly uniform image2D layer_color;  // premultiplied radiance, transmittance
layout(set = 0, binding = 4, r32f) writeonly uniform image2D layer_depth;     // metres to the first matter, +inf

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(layer_color)))) return;
  BlendState state = unpack_blend_state(texelFetch(open_image, at, 0), texelFetch(extent_image, at, 0),
                                        texelFetch(committed_image, at, 0));
  blend_finish(state);
  imageStore(layer_color, at, vec4(state.committed, state.transmittance));
  imageStore(layer_depth, at, vec4(state.first_m < kNoMatterM ? state.first_m : uintBitsToFloat(0x7f800000u)));
}
