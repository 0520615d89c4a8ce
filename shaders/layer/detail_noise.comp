// The tiling detail noise, once: half inverted Worley, half gradient noise, three octaves from four cells a tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/noise.h"

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(set = 0, binding = 0, r8) writeonly uniform image3D noise;

void main() {
  const ivec3 at = ivec3(gl_GlobalInvocationID);
  const ivec3 size = imageSize(noise);
  if (any(greaterThanEqual(at, size))) return;
  const vec3 p = (vec3(at) + 0.5) / vec3(size) * 4.0;
  const float cellular = worley_fbm_periodic(p, 4u, 11u, 3);
  const float gradient = 0.5 + 0.5 * fbm3_periodic(p, 4u, 23u, 3);
  // The mean of the two has mean 0.489 and deviation 0.076: stretched to 0.5 and 0.18, eight bits resolve it well.
  imageStore(noise, at, vec4(clamp(0.5 + 2.4 * (0.5 * (cellular + gradient) - 0.489), 0.0, 1.0)));
}
