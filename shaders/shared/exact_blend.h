// The emission-absorption integral of any number of overlapping segments along one pixel's ray, front to back: between
// consecutive entry and exit events the extinction is the sum, the source the extinction-weighted mean.
//
// Segments come in any order, each before the ray is followed past its beginning (ExactState.cursor_m). A segment
// whose entry or exit is still ahead waits in one of kExactSlots slots. When slots run out, the interval that is being
// integrated (a stretch) is shortened: its end, the horizon, moves to the farthest of the waiting segments' next
// events. Then each waiting segment either has an event inside the stretch and keeps its slot, or spans the stretch and
// is added to the sums instead. A segment that begins behind the horizon is left for the next stretch, for which the
// caller goes through all segments again. So the integral is right for any number of segments; the number of slots
// decides only what it costs.
//
// A caller that cannot afford another stretch sets `merges`: then a segment without a slot is merged with the waiting
// segment that makes exact_loss least. Optical depth and emission of the two are kept, spread evenly over both, so only
// the order of matter within the two changes, by no more optical depth than exact_loss says.
#ifndef NEPHELE_SHARED_EXACT_BLEND_H
#define NEPHELE_SHARED_EXACT_BLEND_H

#include "blend.h"

NEPHELE_SHARED_BEGIN

// More slots cost every segment more time, and spare crowded rays stretches. Beyond 32, lavapipe would not unroll
// loops.
#ifndef EXACT_SLOTS
#define EXACT_SLOTS 16
#endif
NEPHELE_CONST(int, kExactSlots, EXACT_SLOTS);

struct ExactState {
  vec3 radiance;                      // premultiplied, in front of the cursor
  float transmittance;                // up to the cursor
  float first_m;                      // nearest matter
  float cursor_m;                     // everything nearer is final
  bool merges;                        // past the slots, instead of ending the stretch
  float horizon_m;                    // end of this stretch; kNoMatterM: of the ray
  float through_extinction_per_m;     // sums over segments that cover all from cursor to horizon
  vec3 through_emission_per_m;        // radiance times extinction
  BlendSegment waiting[kExactSlots];  // extinction 0: a free slot
};

NEPHELE_FN void exact_begin_stretch(NEPHELE_INOUT(ExactState) state, float cursor_m) {
  state.cursor_m = cursor_m;
  state.horizon_m = kNoMatterM;
  state.through_extinction_per_m = 0.0f;
  state.through_emission_per_m = vec3(0.0f);
  for (int k = 0; k < kExactSlots; ++k) state.waiting[k].extinction_per_m = 0.0f;
}

NEPHELE_FN ExactState exact_empty() {
  ExactState state;
  state.radiance = vec3(0.0f);
  state.transmittance = 1.0f;
  state.first_m = kNoMatterM;
  state.merges = false;
  exact_begin_stretch(state, 0.0f);
  return state;
}

// Where the segment next begins or ends, seen from the cursor.
NEPHELE_FN float exact_next_event(BlendSegment s, float cursor_m) { return s.near_m > cursor_m ? s.near_m : s.far_m; }

// Whether the segment needs a slot in the stretch; if it covers all of it, it joins the sums instead.
NEPHELE_FN bool exact_waits(NEPHELE_INOUT(ExactState) state, BlendSegment s) {
  if (s.extinction_per_m <= 0.0f || s.near_m >= state.horizon_m) return false;
  if (s.near_m > state.cursor_m || s.far_m < state.horizon_m) return true;
  state.through_extinction_per_m += s.extinction_per_m;
  state.through_emission_per_m += s.radiance * s.extinction_per_m;
  return false;
}

// Optical depth that is displaced when the two become one, 0 for coincident ones. Depths of what is ahead.
NEPHELE_FN float exact_loss(BlendSegment a, BlendSegment b, float cursor_m) {
  float a_near_m = max(a.near_m, cursor_m);
  float a_depth = a.extinction_per_m * (a.far_m - a_near_m);
  float b_depth = b.extinction_per_m * (b.far_m - b.near_m);
  float all_m = max(a.far_m, b.far_m) - min(a_near_m, b.near_m);
  float shared_m = max(min(a.far_m, b.far_m) - max(a_near_m, b.near_m), 0.0f);
  return a_depth * b_depth / max(a_depth + b_depth, 1e-30f) * (1.0f - shared_m / all_m);
}

NEPHELE_FN BlendSegment exact_merge(BlendSegment a, BlendSegment b, float cursor_m) {
  a.near_m = max(a.near_m, cursor_m);
  float a_depth = a.extinction_per_m * (a.far_m - a.near_m);
  float b_depth = b.extinction_per_m * (b.far_m - b.near_m);
  BlendSegment both;
  both.near_m = min(a.near_m, b.near_m);
  both.far_m = max(a.far_m, b.far_m);
  both.extinction_per_m = (a_depth + b_depth) / (both.far_m - both.near_m);
  both.radiance = (a.radiance * a_depth + b.radiance * b_depth) / max(a_depth + b_depth, 1e-30f);
  return both;
}

// Adds a segment that does not begin before the cursor, or that did when the last stretch ended.
NEPHELE_FN void exact_add(NEPHELE_INOUT(ExactState) state, BlendSegment s) {
  if (!(s.extinction_per_m > 0.0f) || !(s.far_m > s.near_m)) return;
  state.first_m = min(state.first_m, s.near_m);
  s.near_m = max(s.near_m, state.cursor_m);
  if (s.far_m <= s.near_m || !exact_waits(state, s)) return;
  int slot = -1;
  int partner = 0;
  float farthest_m = exact_next_event(s, state.cursor_m);
  float least_loss = kNoMatterM;
  for (int k = 0; k < kExactSlots; ++k) {
    if (state.waiting[k].extinction_per_m <= 0.0f) slot = k;
    farthest_m = max(farthest_m, exact_next_event(state.waiting[k], state.cursor_m));
    float loss = exact_loss(state.waiting[k], s, state.cursor_m);
    if (loss < least_loss) {
      least_loss = loss;
      partner = k;
    }
  }
  if (slot < 0 && state.merges) {
    slot = partner;
    for (int k = 0; k < kExactSlots; ++k)
      if (k == partner) s = exact_merge(state.waiting[k], s, state.cursor_m);
  } else if (slot < 0) {
    state.horizon_m = min(state.horizon_m, farthest_m);
    for (int k = 0; k < kExactSlots; ++k)
      if (!exact_waits(state, state.waiting[k])) {
        state.waiting[k].extinction_per_m = 0.0f;
        slot = k;
      }
    if (!exact_waits(state, s)) return;
  }
  for (int k = 0; k < kExactSlots; ++k)
    if (k == slot) state.waiting[k] = s;
}

// Follows the ray to to_m or the horizon, whichever is nearer; no segment to come begins before that.
NEPHELE_FN void exact_advance(NEPHELE_INOUT(ExactState) state, float to_m) {
  float end_m = min(to_m, state.horizon_m);
  while (state.cursor_m < end_m && state.transmittance >= kOpaqueTransmittance) {
    float next_m = end_m;
    float extinction = state.through_extinction_per_m;
    vec3 emission = state.through_emission_per_m;
    for (int k = 0; k < kExactSlots; ++k) {
      BlendSegment s = state.waiting[k];
      if (s.extinction_per_m > 0.0f) {
        next_m = min(next_m, exact_next_event(s, state.cursor_m));
        if (s.near_m <= state.cursor_m) {
          extinction += s.extinction_per_m;
          emission += s.radiance * s.extinction_per_m;
        }
      }
    }
    if (extinction > 0.0f) {
      float alpha = opacity_of(extinction * (next_m - state.cursor_m));
      state.radiance += state.transmittance * alpha / extinction * emission;
      state.transmittance *= 1.0f - alpha;
    }
    state.cursor_m = next_m;
    for (int k = 0; k < kExactSlots; ++k)
      if (state.waiting[k].far_m <= next_m) state.waiting[k].extinction_per_m = 0.0f;
  }
}

// Having advanced to the horizon: whether the segments have to be gone through again from there on; false when the
// ray is done.
NEPHELE_FN bool exact_next_stretch(NEPHELE_INOUT(ExactState) state) {
  if (state.horizon_m >= kNoMatterM || state.transmittance < kOpaqueTransmittance) return false;
  exact_begin_stretch(state, state.horizon_m);
  return true;
}

NEPHELE_SHARED_END

#endif
