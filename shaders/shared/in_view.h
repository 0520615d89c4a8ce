// Whether a particle can show in the picture. Conservative: a particle that covers a pixel is never left out.
#ifndef NEPHELE_SHARED_IN_VIEW_H
#define NEPHELE_SHARED_IN_VIEW_H

#include "ellipsoid.h"
#include "types.h"
#include "world.h"

NEPHELE_SHARED_BEGIN

// How far the ellipsoid reaches in front of the plane through the camera with this inward normal of any length: below 0
// when it lies wholly behind. The margin covers rounding: 1e-5 of the distance is a hundredth of a pixel.
NEPHELE_FN float in_front_of(Particle particle, float distance_m, vec3 inward) {
  float margin = 1e-5f * distance_m * length(inward);
  return dot(inward, particle.center_m) + ellipsoid_extent(particle.shape, inward) + margin;
}

// Whether the planet hides the sphere around the ellipsoid: with radius rho, it does if the segment from the camera
// to the centre dips rho below the ground, since then every segment into the sphere dips below it. A camera below
// the ground sees everything.
NEPHELE_FN bool behind_horizon(Particle particle, float camera_altitude_m) {
  vec3 c = particle.center_m;
  float rho = longest_axis_at_most_m(particle.shape);
  float lowest = clamp(-c.z * (kPlanetRadiusM + camera_altitude_m) / max(dot(c, c), 1.0f), 0.0f, 1.0f);
  bool dips = altitude_m(lowest * c, camera_altitude_m) < -rho - 1.0f;
  bool above_ground = camera_altitude_m > 0.0f;
  return dips && above_ground;
}

NEPHELE_FN bool particle_visible(FrameConstants frame, Particle particle) {
  if (!(particle.extinction_per_m > 0.0f)) return false;
  if (!(shape_determinant(particle.shape) > 0.0f)) return false;
  // Rows of the matrix; the camera is the origin, so the side planes pass through it.
  mat4 m = transpose(frame.clip_from_render);
  vec3 x = vec3(m[0].x, m[0].y, m[0].z);
  vec3 y = vec3(m[1].x, m[1].y, m[1].z);
  vec3 w = vec3(m[3].x, m[3].y, m[3].z);
  float distance_m = length(particle.center_m);
  float inside = in_front_of(particle, distance_m, w);
  inside = min(inside, min(in_front_of(particle, distance_m, w + x), in_front_of(particle, distance_m, w - x)));
  inside = min(inside, min(in_front_of(particle, distance_m, w + y), in_front_of(particle, distance_m, w - y)));
  bool hidden = inside < 0.0f || behind_horizon(particle, frame.ground_enabled == 0u ? -1.0f : frame.camera_grid_m.z);
  // No branch on what is constant over the frame alone: lavapipe would compile the shader anew for each frame's
  // constants.
  return (hidden ? frame.culling_enabled : 0u) == 0u;
}

NEPHELE_SHARED_END

#endif
