// Rays, upright ellipsoids and directions. A particle's *unit space* has its centre at the origin, its axes scaled
// to 1 and turned by its yaw: the ellipsoid is the unit sphere there.
#ifndef NEPHELE_SHARED_ELLIPSOID_H
#define NEPHELE_SHARED_ELLIPSOID_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

// Where a ray meets an ellipsoid. The distances are kept as the chord's middle and half length, because their
// difference is exact where entry and exit distances, both huge, would cancel.
struct EllipsoidHit {
  float mid_m;   // distance along the ray to the middle of the chord; negative when it lies behind the origin
  float half_m;  // half the chord's length; 0 for a tangent
  vec3 entry;    // unit space, on the unit sphere
  vec3 exit;     // unit space, on the unit sphere
};

// Directions and offsets: from the ellipsoid's own axes (before scaling) to render space and back.
// Yaw is clockwise from north (y) seen from above: at yaw pi/2 the local y axis points east.
NEPHELE_FN vec3 local_from_render(vec3 v, float yaw_rad) {
  float s = sin(yaw_rad);
  float c = cos(yaw_rad);
  return vec3(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
}

NEPHELE_FN vec3 render_from_local(vec3 v, float yaw_rad) {
  float s = sin(yaw_rad);
  float c = cos(yaw_rad);
  return vec3(c * v.x + s * v.y, c * v.y - s * v.x, v.z);
}

// The ray origin + t * direction against the unit sphere; the direction need not be unit. Closest-approach form
// (Haines et al., Precision Improvements for Ray/Sphere Intersection, Ray Tracing Gems ch. 7): no difference of
// large squares. mid and half are in units of the direction's length.
NEPHELE_FN bool intersect_unit_sphere(vec3 origin, vec3 direction, NEPHELE_OUT(float) mid,
                                      NEPHELE_OUT(float) half_chord) {
  float a = dot(direction, direction);
  mid = -dot(origin, direction) / a;
  vec3 closest = origin + mid * direction;
  float inside = 1.0f - dot(closest, closest);
  half_chord = sqrt(max(0.0f, inside) / a);
  return inside >= 0.0f;
}

// A ray from `origin_m` along the unit vector `direction` against the ellipsoid. Both points may be huge compared with
// the radii: the ray is first moved to the point nearest to the centre, so that unit space sees small numbers only.
NEPHELE_FN bool intersect_ellipsoid(vec3 origin_m, vec3 direction, vec3 center_m, vec3 radius_m, float yaw_rad,
                                    NEPHELE_OUT(EllipsoidHit) hit) {
  vec3 to_center = center_m - origin_m;
  float along = dot(to_center, direction);
  vec3 start = local_from_render(along * direction - to_center, yaw_rad) / radius_m;
  vec3 step = local_from_render(direction, yaw_rad) / radius_m;
  float mid;
  float half_chord;
  bool meets = intersect_unit_sphere(start, step, mid, half_chord);
  vec3 closest = start + mid * step;
  hit.mid_m = along + mid;
  hit.half_m = half_chord;
  hit.entry = closest - half_chord * step;
  hit.exit = closest + half_chord * step;
  if (meets) {
    hit.entry = normalize(hit.entry);
    hit.exit = normalize(hit.exit);
  }
  return meets;
}

// v turned by the unit quaternion q (xyz imaginary, w real), and back.
NEPHELE_FN vec3 quaternion_rotate(vec4 q, vec3 v) {
  vec3 i = vec3(q.x, q.y, q.z);
  return v + 2.0f * cross(i, cross(i, v) + q.w * v);
}

NEPHELE_FN vec3 quaternion_rotate_inverse(vec4 q, vec3 v) { return quaternion_rotate(vec4(-q.x, -q.y, -q.z, q.w), v); }

// A particle's orientation: the rotation from the reference particle's frame to the particle's unit space.
NEPHELE_FN uint pack_orientation(vec4 q) { return packSnorm4x8(q); }

NEPHELE_FN vec4 unpack_orientation(uint packed) {
  vec4 q = unpackSnorm4x8(packed);
  float n = dot(q, q);
  return n > 0.01f ? q / sqrt(n) : vec4(0.0f, 0.0f, 0.0f, 1.0f);
}

// Uniform rotation from three uniforms in [0, 1): Shoemake, Uniform Random Rotations, Graphics Gems III.
NEPHELE_FN vec4 random_rotation(float u0, float u1, float u2) {
  float r0 = sqrt(1.0f - u0);
  float r1 = sqrt(u0);
  float t0 = 2.0f * kPi * u1;
  float t1 = 2.0f * kPi * u2;
  return vec4(sin(t0) * r0, cos(t0) * r0, sin(t1) * r1, cos(t1) * r1);
}

NEPHELE_FN float sign_not_zero(float x) { return x < 0.0f ? -1.0f : 1.0f; }

// Octahedral map: unit vectors <-> the square [0, 1]^2 (after Meyer et al. 2010; Cigolle et al., A Survey of Efficient
// Representations for Independent Unit Vectors, JCGT 3(2), 2014). +z is the centre, -z all four corners; opposite
// halves of each side are glued together.
NEPHELE_FN vec2 octahedral_encode(vec3 n) {
  float scale = 1.0f / (abs(n.x) + abs(n.y) + abs(n.z));
  float x = n.x * scale;
  float y = n.y * scale;
  if (n.z < 0.0f) {
    float folded = (1.0f - abs(y)) * sign_not_zero(x);
    y = (1.0f - abs(x)) * sign_not_zero(y);
    x = folded;
  }
  return vec2(x * 0.5f + 0.5f, y * 0.5f + 0.5f);
}

NEPHELE_FN vec3 octahedral_decode(vec2 uv) {
  float x = uv.x * 2.0f - 1.0f;
  float y = uv.y * 2.0f - 1.0f;
  float z = 1.0f - abs(x) - abs(y);
  if (z < 0.0f) {
    float folded = (1.0f - abs(y)) * sign_not_zero(x);
    y = (1.0f - abs(x)) * sign_not_zero(y);
    x = folded;
  }
  return normalize(vec3(x, y, z));
}

NEPHELE_SHARED_END

#endif
