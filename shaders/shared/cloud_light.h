// The source radiance of cloud matter: what an infinitely thick piece of this medium would show, to be multiplied by a
// segment's opacity. The shading of particles by whole chords and the ray marcher, which asks at places, both call it.
// Two models, one of which a frame is lit by (--light):
//
// field   light as a function of place (passes/light/light_field.h): the beam scattered once, the light near the beam
//         in closed form (lut/near_beam.h), and what the lattice carries.
// tables  [Yusov14] 4.4: each particle by itself. Light scattered once and more than once in it from its tables, behind
//         the depth of what lies towards the sun; and one ambient radiance. Light that neighbours exchange is missing.
//         Deviates from the paper: single scattering keeps the true depth, where the paper scales it by xi = 0.05 like
//         everything else.
#ifndef NEPHELE_SHARED_CLOUD_LIGHT_H
#define NEPHELE_SHARED_CLOUD_LIGHT_H

#include "phase.h"
#include "prelude.h"

NEPHELE_SHARED_BEGIN

// Depth towards the sun through other particles where it differs by `change` from that at a particle's centre: linear
// within limits, as four samples know it.
NEPHELE_FN float linear_depth(float at_center, float change) {
  return clamp(at_center + change, 0.1f * at_center, 4.0f * at_center);
}

// ---- Light from the field ----

// Per unit of sunlight: once_per_sr is the phase function, near_beam_per_sr K at this depth and angle; tau is the
// optical depth towards the sun through everything. carried: what the lattice scatters into the ray.
NEPHELE_FN vec3 field_source_radiance(vec3 sun_irradiance, float once_per_sr, float tau, float near_beam_per_sr,
                                      vec3 carried) {
  return sun_irradiance * (once_per_sr * exp(-tau) + near_beam_per_sr) + carried;
}

// ---- Light from tables ----

// Share of the depth through other particles that weakens the light which is then scattered more than once: light
// scattered forward on the way counts as not scattered, the more so as it spreads. [Yusov14] 5.3's xi.
NEPHELE_CONST(float, kDepthShareOfMultiple, 0.05f);

// Light of a place, or of a particle that is shaded by a whole chord.
struct TableLight {
  vec3 sun_irradiance;  // after the air, before any cloud
  // Source radiance of sunlight scattered once, per unit sun_irradiance, weakened by tau_sun and inside the particle.
  // The caller knows how: a chord integrates over its points in closed form (scattering.h), a place has one depth.
  float once_per_sr;
  float again_per_sr;     // of sunlight scattered again inside the particle, per unit irradiance on the particle
  float tau_sun;          // optical depth towards the sun through the other particles
  vec3 ambient_radiance;  // of sky and ground
};

NEPHELE_FN vec3 table_source_radiance(TableLight light) {
  float again = light.again_per_sr * exp(-kDepthShareOfMultiple * light.tau_sun);
  return light.sun_irradiance * (light.once_per_sr + again) + light.ambient_radiance;
}

// Share of light from above in a slab lit evenly from both sides, optical depth `above` below the top of `total`:
// Eddington's solution without a source, linear in the depth. A cloud is taken to be as dense as one particle at its
// peak, which is what several overlapping ones come to.
NEPHELE_FN float slab_share_above(float above, float total, float g) {
  return ((1.0f - g) * (total - above) + 2.0f / 3.0f) / ((1.0f - g) * total + 4.0f / 3.0f);
}

NEPHELE_SHARED_END

#endif
