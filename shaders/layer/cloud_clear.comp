// Resets the blend state of the interlock backend's storage images.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "layer/blend_state.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba32f) writeonly uniform image2D open_image;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D extent_image;
layout(set = 0, binding = 2, rgba32f) writeonly uniform image2D committed_image;

void main() {
  const ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, imageSize(open_image)))) return;
  vec4 open, extent, committed;
  pack_blend_state(blend_empty(), open, extent, committed);
  imageStore(open_image, at, open);
  imageStore(extent_image, at, extent);
  imageStore(committed_image, at, committed);
}
