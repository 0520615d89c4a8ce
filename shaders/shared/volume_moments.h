// From the matter in a window of a volume to one soft particle: the maths of a node of the importer's lattice.
//
// A window holds mass (extinction times volume), a centroid and a covariance. The particle with the same three, under
// the profile that the light pass integrates (particle_profile in light.h), is the one made here. Its shape is the
// symmetric root of the covariance: it follows the matter without choosing an order or a sign of axes, so nothing flips
// as the matter moves.
//
// Windows stand on a lattice and overlap: between two nodes the weight of one falls as the other's rises, and all sum
// to one everywhere, so that no matter is lost or counted twice. A soft edge of 1 makes them hats, 0 boxes.
#ifndef NEPHELE_SHARED_VOLUME_MOMENTS_H
#define NEPHELE_SHARED_VOLUME_MOMENTS_H

#include "prelude.h"
#include "light.h"

NEPHELE_SHARED_BEGIN

// Mean of particle_profile over the unit ball, and its variance along an axis. With q = 1 - r^2, the integral of
// q^n r^2 over [0, 1] is 8/105, 16/315, 128/3465 for n = 2, 3, 4; that of q^n r^4 is 8/315, 16/1155, 128/15015.
NEPHELE_CONST(float, kProfileFill,
              3.0f * (kProfile2 * (8.0f / 105.0f) + kProfile3 * (16.0f / 315.0f) + kProfile4 * (128.0f / 3465.0f)));
NEPHELE_CONST(float, kProfileVariance,
              (kProfile2 * (8.0f / 315.0f) + kProfile3 * (16.0f / 1155.0f) + kProfile4 * (128.0f / 15015.0f)) /
                  kProfileFill);

// The share of the upper of two neighbouring nodes in matter at t in [0, 1] between them; the lower one has the rest.
NEPHELE_FN float window_share(float t, float soft_edge) {
  float from_middle = t - 0.5f;
  if (soft_edge <= 0.0f) return from_middle < 0.0f ? 0.0f : 1.0f;
  return clamp(from_middle / soft_edge + 0.5f, 0.0f, 1.0f);
}

// Sums over a window, places measured from its node.
struct WindowMoments {
  float mass_m2;      // extinction (1/m) times volume
  vec3 first;         // mass times place
  vec3 diagonal;      // mass times place^2: xx, yy, zz
  vec3 off_diagonal;  // xy, xz, yz
};

// A particle as engine/particle_set.h keeps it, its centre measured from the node.
struct MomentParticle {
  vec3 center_m;
  vec3 diagonal_m;      // of the shape: xx, yy, zz
  vec3 off_diagonal_m;  // xy, xz, yz
  float extinction_per_m;
};

// One rotation of the cyclic Jacobi method: afterwards a[q][p] is 0. The columns of v become the eigenvectors.
NEPHELE_FN void jacobi_rotate(NEPHELE_INOUT(mat3) a, NEPHELE_INOUT(mat3) v, int p, int q) {
  float off = a[q][p];
  if (abs(off) < 1.0e-20f) return;
  float theta = (a[q][q] - a[p][p]) / (2.0f * off);
  float t = (theta >= 0.0f ? 1.0f : -1.0f) / (abs(theta) + sqrt(theta * theta + 1.0f));
  float c = inversesqrt(t * t + 1.0f);
  float s = t * c;
  for (int k = 0; k < 3; ++k) {
    float first = a[p][k];
    float second = a[q][k];
    a[p][k] = c * first - s * second;
    a[q][k] = s * first + c * second;
    first = v[p][k];
    second = v[q][k];
    v[p][k] = c * first - s * second;
    v[q][k] = s * first + c * second;
  }
  for (int k = 0; k < 3; ++k) {
    float first = a[k][p];
    float second = a[k][q];
    a[k][p] = c * first - s * second;
    a[k][q] = s * first + c * second;
  }
}

// mass > 0. No radius comes out below least_radius_m.
NEPHELE_FN MomentParticle particle_of_moments(WindowMoments moments, float least_radius_m) {
  float per_mass = 1.0f / moments.mass_m2;
  vec3 center = moments.first * per_mass;
  vec3 own = moments.diagonal * per_mass - center * center;
  vec3 mixed = moments.off_diagonal * per_mass - vec3(center.x * center.y, center.x * center.z, center.y * center.z);
  // Of about unit size, so that the rotations neither overflow nor vanish.
  float size = max((own.x + own.y + own.z) * (1.0f / 3.0f), 1.0e-12f);
  mat3 a = mat3(own.x, mixed.x, mixed.y, mixed.x, own.y, mixed.z, mixed.y, mixed.z, own.z) * (1.0f / size);
  mat3 v = mat3(1.0f);
  for (int sweep = 0; sweep < 6; ++sweep) {
    jacobi_rotate(a, v, 0, 1);
    jacobi_rotate(a, v, 0, 2);
    jacobi_rotate(a, v, 1, 2);
  }
  MomentParticle particle;
  particle.center_m = center;
  particle.diagonal_m = vec3(0.0f);
  particle.off_diagonal_m = vec3(0.0f);
  float volume = kProfileFill * (4.0f / 3.0f) * kPi;
  for (int k = 0; k < 3; ++k) {
    float radius_m = max(sqrt(max(a[k][k], 0.0f) * size / kProfileVariance), least_radius_m);
    vec3 e = v[k];
    particle.diagonal_m += radius_m * e * e;
    particle.off_diagonal_m += radius_m * vec3(e.x * e.y, e.x * e.z, e.y * e.z);
    volume *= radius_m;
  }
  particle.extinction_per_m = moments.mass_m2 / volume;
  return particle;
}

NEPHELE_SHARED_END

#ifdef __cplusplus
static_assert(nephele::shared::kProfileFill > 0.4159f && nephele::shared::kProfileFill < 0.4160f);
static_assert(nephele::shared::kProfileVariance > 0.1249f && nephele::shared::kProfileVariance < 0.1251f);
#endif

#endif
