// The flat base of a cloud: an altitude below which its particles hold no matter, and above which the matter fades in.
// Shading, the ray marcher and the path tracer thin particles by base_fade; shadows (light.h) and the bounds on the
// screen (screen_bounds.h) cut particles off at the base, which holds all that base_fade leaves.
#ifndef NEPHELE_SHARED_FLAT_BASE_H
#define NEPHELE_SHARED_FLAT_BASE_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

// The base_m of a particle that has no flat base. It lies so far down that every place counts as above the fade, and
// that adding an altitude to it leaves it as it is; so code that only compares heights needs no case of its own.
NEPHELE_CONST(float, kNoBaseM, -1e30f);

NEPHELE_FN bool has_base(float base_m) { return base_m > kNoBaseM; }

// Height above a base over which the matter fades in.
NEPHELE_CONST(float, kBaseFadeM, 50.0f);

// Share of a particle's extinction that is left at a height above its base: 0 at the base and below it, 1 from
// kBaseFadeM on.
NEPHELE_FN float base_fade(float above_base_m) { return smoothstep(0.0f, kBaseFadeM, above_base_m); }

// Its integral from the base up, metres; and its mean over a way that climbs evenly from one height to another.
NEPHELE_FN float base_fade_integral(float above_base_m) {
  float u = clamp(above_base_m / kBaseFadeM, 0.0f, 1.0f);
  return kBaseFadeM * u * u * u * (1.0f - 0.5f * u) + max(above_base_m - kBaseFadeM, 0.0f);
}
NEPHELE_FN float mean_base_fade(float from_m, float to_m) {
  float climb_m = to_m - from_m;
  return abs(climb_m) < 0.5f ? base_fade(0.5f * (from_m + to_m))
                             : (base_fade_integral(to_m) - base_fade_integral(from_m)) / climb_m;
}

NEPHELE_SHARED_END

#endif
