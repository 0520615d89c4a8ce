// The reference particle's density on a lattice of the cube around its sphere, first and last vertices on the faces:
// what the ray marcher samples, and shading where the eye is inside.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/reference_particle.h"

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(set = 0, binding = 0, r16f) writeonly uniform image3D density;
layout(push_constant) uniform Push { uint seed; };

void main() {
  const ivec3 at = ivec3(gl_GlobalInvocationID), size = imageSize(density);
  if (any(greaterThanEqual(at, size))) return;
  imageStore(density, at, vec4(reference_particle_density(2.0 * vec3(at) / vec3(size - 1) - 1.0, seed)));
}
