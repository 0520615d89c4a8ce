// How far each ray of the cloud layer goes: to what the host has drawn, or to the ground.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(set = 0, binding = 1) uniform sampler2D host_distance;
layout(set = 0, binding = 2, r32f) writeonly uniform image2D layer_scene;  // metres along the ray, huge: the sky

#include "kit/scene_distance.glsl"

void main() {
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(pixel, frame.layer_size_px))) return;
  imageStore(layer_scene, ivec2(pixel), vec4(scene_distance_m((vec2(pixel) + 0.5) * float(frame.scale))));
}
