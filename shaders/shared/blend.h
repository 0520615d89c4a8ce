// Volume-aware blending of particles along one pixel's ray, back to front ([Yusov14] section 5.5, Eq. 10-17): one
// *open* segment, the nearest continuous volume so far, and what has been *committed* behind it. All blending
// backends and the CPU fold their segments through blend_add and blend_finish.
//
// Deviates from the paper: distances and extinctions are kept as they are (metres, 1/m), so beta is part of the
// extinction; committed transmittance is tracked beside the colour, since the sky is composited later.
#ifndef NEPHELE_SHARED_BLEND_H
#define NEPHELE_SHARED_BLEND_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

// A stretch of the ray with constant extinction and source radiance.
struct BlendSegment {
  vec3 radiance;           // source radiance; what an infinitely thick segment would show
  float extinction_per_m;  // 0: empty
  float near_m;
  float far_m;
};

struct BlendState {
  BlendSegment open;
  vec3 committed;       // premultiplied radiance behind the open segment
  float transmittance;  // through everything committed
  float first_m;        // nearest matter of all segments
};

NEPHELE_CONST(float, kNoMatterM, 1e30f);

// Work stops where less than this shines through: what lies behind is left out, an error of at most this share of its
// radiance. That brings the volume blend nearer to the exact one: it would mix what is hidden into what it overlaps.
NEPHELE_CONST(float, kOpaqueTransmittance, 1e-4f);

// 1 - exp(-x) for x >= 0, without cancellation for thin segments.
NEPHELE_FN float opacity_of(float optical_depth) {
  float x = optical_depth;
  return x < 0.04f ? x * (1.0f - x * (0.5f - x * (1.0f / 6.0f))) : 1.0f - exp(-x);
}

NEPHELE_FN BlendSegment blend_no_segment() {
  BlendSegment s;
  s.radiance = vec3(0.0f);
  s.extinction_per_m = 0.0f;
  s.near_m = 0.0f;
  s.far_m = 0.0f;
  return s;
}

NEPHELE_FN BlendState blend_empty() {
  BlendState state;
  state.open = blend_no_segment();
  state.committed = vec3(0.0f);
  state.transmittance = 1.0f;
  state.first_m = kNoMatterM;
  return state;
}

// Puts `length_m` of a medium in front of what is committed.
NEPHELE_FN void blend_commit(NEPHELE_INOUT(BlendState) state, vec3 radiance, float extinction_per_m, float length_m) {
  float alpha = opacity_of(extinction_per_m * length_m);
  state.committed = radiance * alpha + state.committed * (1.0f - alpha);
  state.transmittance *= 1.0f - alpha;
}

// Adds a particle's segment. Exact for any two overlapping segments that come back to front; a third one inside the
// merged segment meets its mean density and colour (the paper's stated limit).
NEPHELE_FN void blend_add(NEPHELE_INOUT(BlendState) state, BlendSegment s) {
  if (!(s.extinction_per_m > 0.0f) || !(s.far_m > s.near_m)) return;
  state.first_m = min(state.first_m, s.near_m);
  BlendSegment o = state.open;
  if (o.extinction_per_m <= 0.0f) {
    state.open = s;
    return;
  }
  float inner_near = max(s.near_m, o.near_m);
  float inner_far = min(s.far_m, o.far_m);
  if (inner_near >= inner_far) {  // apart: the farther one is done
    bool new_is_nearer = s.near_m < o.near_m;
    if (new_is_nearer) {
      blend_commit(state, o.radiance, o.extinction_per_m, o.far_m - o.near_m);
      state.open = s;
    } else {
      blend_commit(state, s.radiance, s.extinction_per_m, s.far_m - s.near_m);
    }
    return;
  }
  // Back part, Eq. 12 and 13: behind the intersection only one of the two is left.
  float outer_far = max(s.far_m, o.far_m);
  if (s.far_m > o.far_m)
    blend_commit(state, s.radiance, s.extinction_per_m, outer_far - inner_far);
  else
    blend_commit(state, o.radiance, o.extinction_per_m, outer_far - inner_far);

  // Front part and intersection become the open segment, Eq. 10, 11, 14, 15.
  float outer_near = min(s.near_m, o.near_m);
  bool new_in_front = s.near_m < o.near_m;
  vec3 front_radiance = new_in_front ? s.radiance : o.radiance;
  float front_extinction = new_in_front ? s.extinction_per_m : o.extinction_per_m;
  float front_depth = front_extinction * (inner_near - outer_near);
  float both_extinction = s.extinction_per_m + o.extinction_per_m;
  float both_depth = both_extinction * (inner_far - inner_near);
  float front_alpha = opacity_of(front_depth);
  float both_alpha = (1.0f - front_alpha) * opacity_of(both_depth);
  vec3 both_radiance = (s.radiance * s.extinction_per_m + o.radiance * o.extinction_per_m) / both_extinction;
  float alpha = front_alpha + both_alpha;
  state.open.radiance =
      alpha > 0.0f ? (front_radiance * front_alpha + both_radiance * both_alpha) / alpha : both_radiance;
  state.open.extinction_per_m = (front_depth + both_depth) / (inner_far - outer_near);
  state.open.near_m = outer_near;
  state.open.far_m = inner_far;
}

// Commits the open segment: the state then holds the whole ray. Eq. 16, 17.
NEPHELE_FN void blend_finish(NEPHELE_INOUT(BlendState) state) {
  if (state.open.extinction_per_m > 0.0f)
    blend_commit(state, state.open.radiance, state.open.extinction_per_m, state.open.far_m - state.open.near_m);
  state.open = blend_no_segment();
}

// How far a ray can see, by the segments met so far, in any order: an upper bound, the far end of the first few that
// are opaque together. All that begins behind it (opaque_front_hides) is hidden.
struct OpaqueFront {
  float depth;    // optical depth of the segments counted
  float reach_m;  // the farthest point at which any of these segments can still be seen
};

NEPHELE_FN OpaqueFront opaque_front_empty() {
  OpaqueFront front;
  front.depth = 0.0f;
  front.reach_m = 0.0f;
  return front;
}

NEPHELE_FN bool opaque_front_hides(OpaqueFront front, float begin_m) {
  return front.depth >= -log(kOpaqueTransmittance) && begin_m >= front.reach_m;
}

NEPHELE_FN void opaque_front_add(NEPHELE_INOUT(OpaqueFront) front, BlendSegment s) {
  float opaque = -log(kOpaqueTransmittance);
  if (front.depth >= opaque) return;
  // A segment that is opaque by itself hides its own far part: only its beginning is added.
  front.reach_m = max(front.reach_m, min(s.far_m, s.near_m + opaque / s.extinction_per_m));
  front.depth += s.extinction_per_m * (s.far_m - s.near_m);
}

NEPHELE_SHARED_END

#endif
