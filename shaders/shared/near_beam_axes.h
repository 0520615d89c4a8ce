// Axes of the near-beam table (lut/near_beam.h): optical depth towards the sun, fine where it is thin; root of the
// sine of half the scattering angle, fine in the forward peak.
#ifndef NEPHELE_SHARED_NEAR_BEAM_AXES_H
#define NEPHELE_SHARED_NEAR_BEAM_AXES_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(float, kNearBeamDeepest, 200.0f);  // nothing is left beyond

NEPHELE_FN float near_beam_depth_unit(float depth) {
  return log2(1.0f + min(depth, kNearBeamDeepest)) / log2(1.0f + kNearBeamDeepest);
}
NEPHELE_FN float near_beam_depth(float unit) { return exp2(unit * log2(1.0f + kNearBeamDeepest)) - 1.0f; }
NEPHELE_FN float near_beam_angle_unit(float mu) { return sqrt(sqrt(clamp(0.5f - 0.5f * mu, 0.0f, 1.0f))); }
NEPHELE_FN float near_beam_cosine(float unit) {
  float sine = unit * unit;
  return 1.0f - 2.0f * sine * sine;
}

// Unit coordinates of a texture whose first and last texels are the axes' ends.
NEPHELE_FN vec2 near_beam_coordinates(float depth, float mu, vec2 size) {
  vec2 unit = vec2(near_beam_depth_unit(depth), near_beam_angle_unit(mu));
  return (unit * (size - vec2(1.0f)) + vec2(0.5f)) / size;
}

NEPHELE_SHARED_END

#endif
