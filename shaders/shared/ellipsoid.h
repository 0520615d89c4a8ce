// Ellipsoids, rays and directions. An ellipsoid's *unit space* has its centre at the origin and is what the inverse of
// its shape makes of space: the ellipsoid is the unit sphere there. Because shapes are symmetric, unit space is
// squeezed along the ellipsoid's axes and not turned, so it depends smoothly on the ellipsoid, whatever its axes are.
#ifndef NEPHELE_SHARED_ELLIPSOID_H
#define NEPHELE_SHARED_ELLIPSOID_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

// A symmetric positive definite matrix that takes the unit sphere to the ellipsoid: its eigenvalues are the semi-axes,
// its eigenvectors their directions.
struct EllipsoidShape {
  vec3 diagonal_m;      // xx, yy, zz
  vec3 off_diagonal_m;  // xy, xz, yz
#ifdef __cplusplus
  bool operator==(const EllipsoidShape&) const = default;
#endif
};

NEPHELE_FN mat3 shape_matrix(EllipsoidShape s) {
  vec3 d = s.diagonal_m;
  vec3 o = s.off_diagonal_m;
  return mat3(vec3(d.x, o.x, o.y), vec3(o.x, d.y, o.z), vec3(o.y, o.z, d.z));
}

NEPHELE_FN float shape_determinant(EllipsoidShape s) {
  vec3 d = s.diagonal_m;
  vec3 o = s.off_diagonal_m;
  return d.x * (d.y * d.z - o.z * o.z) - o.x * (o.x * d.z - o.z * o.y) + o.y * (o.x * o.z - d.y * o.y);
}

// Radius of the sphere of the same volume.
NEPHELE_FN float mean_radius_m(EllipsoidShape s) { return pow(max(shape_determinant(s), 0.0f), 1.0f / 3.0f); }

// From render space, relative to the centre, to unit space.
NEPHELE_FN mat3 unit_from_render(EllipsoidShape s) {
  vec3 d = s.diagonal_m;
  vec3 o = s.off_diagonal_m;
  float inverse_determinant = 1.0f / shape_determinant(s);
  float xy = (o.z * o.y - o.x * d.z) * inverse_determinant;
  float xz = (o.x * o.z - d.y * o.y) * inverse_determinant;
  float yz = (o.x * o.y - d.x * o.z) * inverse_determinant;
  return mat3(vec3((d.y * d.z - o.z * o.z) * inverse_determinant, xy, xz),
              vec3(xy, (d.x * d.z - o.y * o.y) * inverse_determinant, yz),
              vec3(xz, yz, (d.x * d.y - o.x * o.x) * inverse_determinant));
}

// Half the ellipsoid's extent along a direction of any length.
NEPHELE_FN float ellipsoid_extent(EllipsoidShape s, vec3 direction) { return length(shape_matrix(s) * direction); }

// No semi-axis is longer: the largest sum of a row (Gershgorin), exact for shapes along the coordinate axes, and at
// most 1.4 times the longest semi-axis of an upright one.
NEPHELE_FN float longest_axis_at_most_m(EllipsoidShape s) {
  vec3 d = s.diagonal_m;
  vec3 o = abs(s.off_diagonal_m);
  return max(d.x + o.x + o.y, max(d.y + o.x + o.z, d.z + o.y + o.z));
}

// The longest semi-axis: the largest eigenvalue, in closed form (Smith, Eigenvalues of a symmetric 3 x 3 matrix, 1961).
NEPHELE_FN float longest_axis_m(EllipsoidShape s) {
  float mean = (s.diagonal_m.x + s.diagonal_m.y + s.diagonal_m.z) / 3.0f;
  vec3 d = s.diagonal_m - mean;
  vec3 o = s.off_diagonal_m;
  float spread = sqrt((dot(d, d) + 2.0f * dot(o, o)) / 6.0f);
  if (!(spread > 1.0e-6f * mean)) return mean;
  EllipsoidShape apart;
  apart.diagonal_m = d / spread;
  apart.off_diagonal_m = o / spread;
  return mean + 2.0f * spread * cos(acos(clamp(0.5f * shape_determinant(apart), -1.0f, 1.0f)) / 3.0f);
}

// An upright ellipsoid: semi-axes x and y turned by the yaw, z up.
NEPHELE_FN EllipsoidShape upright_shape(vec3 radius_m, float yaw_rad) {
  float s = sin(yaw_rad);
  float c = cos(yaw_rad);
  EllipsoidShape shape;
  shape.diagonal_m = vec3(radius_m.x * c * c + radius_m.y * s * s, radius_m.x * s * s + radius_m.y * c * c, radius_m.z);
  shape.off_diagonal_m = vec3((radius_m.y - radius_m.x) * s * c, 0.0f, 0.0f);
  return shape;
}

// Where a ray meets an ellipsoid. The distances are kept as the chord's middle and half length, because their
// difference is exact where entry and exit distances, both huge, would cancel.
struct EllipsoidHit {
  float mid_m;   // distance along the ray to the middle of the chord; negative when it lies behind the origin
  float half_m;  // half the chord's length; 0 for a tangent
  vec3 entry;    // unit space, on the unit sphere
  vec3 exit;     // unit space, on the unit sphere
};

// Directions and offsets: from the own axes of an upright ellipsoid (before scaling) to render space and back.
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
NEPHELE_FN bool intersect_ellipsoid(vec3 origin_m, vec3 direction, vec3 center_m, EllipsoidShape shape,
                                    NEPHELE_OUT(EllipsoidHit) hit) {
  mat3 to_unit = unit_from_render(shape);
  vec3 to_center = center_m - origin_m;
  float along = dot(to_center, direction);
  vec3 start = to_unit * (along * direction - to_center);
  vec3 step = to_unit * direction;
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

// First b, then a.
NEPHELE_FN vec4 quaternion_product(vec4 a, vec4 b) {
  vec3 u = vec3(a.x, a.y, a.z);
  vec3 v = vec3(b.x, b.y, b.z);
  return vec4(a.w * v + b.w * u + cross(u, v), a.w * b.w - dot(u, v));
}

// About the vertical, clockwise seen from above: render_from_local as a quaternion.
NEPHELE_FN vec4 yaw_rotation(float yaw_rad) { return vec4(0.0f, 0.0f, -sin(0.5f * yaw_rad), cos(0.5f * yaw_rad)); }

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
