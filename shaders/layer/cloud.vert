// Cloud particles as proxies: the quadrilateral around an ellipsoid's silhouette. In reference space the silhouette
// of the unit sphere seen from q is a circle around q / |q|^2 in the plane perpendicular to q; its circumscribed
// square maps to a parallelogram that touches the ellipse on four sides. From inside: the whole screen.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/types.h"

layout(scalar, set = 0, binding = 0) uniform Frame { FrameConstants frame; };
layout(scalar, set = 0, binding = 1) readonly buffer DrawParticles { DrawParticle draw_particles[]; };
layout(location = 0) flat out uint particle_index;

void main() {
  const uint corner = uint(gl_VertexIndex) % 6u;
  particle_index = uint(gl_VertexIndex) / 6u;
  const float x = (corner == 1u || corner == 2u || corner == 4u) ? 1.0 : -1.0;
  const float y = (corner == 2u || corner == 4u || corner == 5u) ? 1.0 : -1.0;

  const mat3 reference_from_render = draw_particles[particle_index].reference_from_render;
  const vec3 center_m = draw_particles[particle_index].center_m;
  const vec3 q = -(reference_from_render * center_m);
  const float q2 = dot(q, q);
  if (q2 < 1.0404) {  // within 2 % of the surface, or inside
    gl_Position = vec4(x, y, 0.5, 1.0);
    return;
  }
  const vec3 axis = q * inversesqrt(q2);
  const vec3 helper = abs(axis.z) < 0.7 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
  const vec3 t1 = normalize(cross(helper, axis));
  const vec3 t2 = cross(axis, t1);
  const float circle = sqrt(1.0 - 1.0 / q2) * 1.001;
  const vec3 p_reference = q / q2 + circle * (x * t1 + y * t2);
  const vec3 p_render = center_m + inverse(reference_from_render) * p_reference;
  gl_Position = frame.clip_from_render * vec4(p_render, 1.0);
  gl_Position.z = 0.5 * gl_Position.w;  // no depth test; only what is behind the eye is clipped
}
