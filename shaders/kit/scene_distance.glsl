// What stands behind the clouds. The including shader declares FrameConstants frame and sampler2D host_distance, in
// image pixels: metres along the ray to what the host has drawn, +inf where it has not.
#ifndef NEPHELE_SCENE_DISTANCE_GLSL
#define NEPHELE_SCENE_DISTANCE_GLSL

#include "kit/camera_rays.glsl"

const float kNoSceneM = 1e30;

float host_distance_m(ivec2 pixel) {
  if (frame.host_scene == 0u) return kNoSceneM;
  const float distance_m = texelFetch(host_distance, min(pixel, ivec2(frame.image_size_px) - 1), 0).x;
  return distance_m >= 0.0 && distance_m < kNoSceneM ? distance_m : kNoSceneM;
}

// Along the ray through a place in the image: to the host's scene, else to the ground, else a huge number.
float scene_distance_m(vec2 image_px) {
  const float distance_m = host_distance_m(ivec2(image_px));
  return distance_m < kNoSceneM ? distance_m : ground_distance_m(pixel_direction(image_px, frame.image_size_px));
}

#endif
