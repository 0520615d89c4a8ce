// The source radiance of cloud matter ([Yusov14] 4.4, extended): what an infinitely thick piece of this medium would
// show, to be multiplied by a segment's opacity. source_radiance is the whole model; the shading of particles by whole
// chords and the ray marcher, which asks at places, both call it.
//
//   sun, scattered once      phase * S / opacity * exp(-tau)     exact in the homogeneous sphere
//   sun, scattered again     M(table) / opacity * exp(-tau')     light exchanged inside the particle
//   sun, scattered forward   a wider phase * (exp(-tau') - exp(-tau))  still in the beam's direction, more or less
//   sun, diffuse             two-stream light of the cloud around, by its thickness and the place in it, flowing out
//   sky and ground           mean radiance of the directions above and below, mixed by the place in the cloud and the
//                            view
//
// tau is the optical depth towards the sun; tau' = (1 - g) tau is the depth that similarity leaves of it when light
// scattered forward counts as not scattered. Deviates from the paper: it scales tau by xi = 0.05 for everything and has
// the first two terms; here single scattering keeps the true depth, and what the rest of the cloud contributes depends
// on how much of it there is, so that thin turrets and edges stay dark seen from the sun's side.
#ifndef NEPHELE_SHARED_CLOUD_LIGHT_H
#define NEPHELE_SHARED_CLOUD_LIGHT_H

#include "phase.h"
#include "prelude.h"

NEPHELE_SHARED_BEGIN

// The weights of the terms: fitted to the sunlight of the path-traced images of one cloud from three sides and of two
// fields (docs/accuracy.md), for their relative squared error and their bias alike. An earlier fit left single
// scattering free, which came out as 1. The terms overlap: orders two and three are in each.
NEPHELE_CONST(float, kAgainShare, 0.75f);
NEPHELE_CONST(float, kForwardShare, 1.15f);
NEPHELE_CONST(float, kDiffuseShare, 0.48f);

NEPHELE_CONST(float, kForwardAsymmetry, 0.5f);  // of the phase function's

NEPHELE_CONST(float, kMeanChord, 4.0f / 3.0f);  // of a sphere, over its radius

// Depth towards the sun through other particles where it differs by `change` from that at a particle's centre: linear
// within limits, as four samples know it.
NEPHELE_FN float linear_depth(float at_center, float change) {
  return clamp(at_center + change, 0.1f * at_center, 4.0f * at_center);
}

// Share of sunlight scattered forward alone on its way through optical depth tau: what similarity leaves in the beam
// without what is unscattered.
NEPHELE_FN float forward_share(float tau, float g) { return max(exp(-(1.0f - g) * tau) - exp(-tau), 0.0f); }

// Mean radiance of multiply scattered light in a slab lit along its normal, times 4 pi per unit irradiance: at optical
// depth `depth` of `total`, conservative scattering, Eddington's approximation with similarity-scaled depths and
// Marshak's boundary (no light from without). 0 in a slab of no depth, 2 on top of an endless one, 5 deep in it.
NEPHELE_FN float slab_light(float depth, float total, float g) {
  float t = (1.0f - g) * depth;
  float all = (1.0f - g) * total;
  float j = 5.0f - 3.0f * exp(-t) - (5.0f - exp(-all)) * (t + 2.0f / 3.0f) / (all + 4.0f / 3.0f);
  return max(j, 0.0f);
}

// Share of diffuse light that crosses a layer of optical depth tau of a non-absorbing medium: the two-stream result.
NEPHELE_FN float diffuse_transmission(float tau, float g) {
  return 1.0f / (1.0f + 0.75f * (1.0f - g) * max(tau, 0.0f));
}

// Diffuse light sent towards the eye, over its mean. It flows out through a cloud's skin: there Eddington's flux H is
// half of the mean J (Marshak's boundary), a quarter at a scaled depth of 2/3, as deep as one sees; scattering makes J
// + 3 g H cosine of it. outward: cosine between the open side and the way to the eye, times how one-sided it is. Taken
// once a particle.
NEPHELE_CONST(float, kOutwardFlux, 0.25f);
NEPHELE_FN float outward_factor(float outward, float g) { return max(1.0f + 3.0f * kOutwardFlux * g * outward, 0.0f); }

// Sunlight that the cloud around sends to a place, per unit irradiance, per sr. beam: optical depth towards the sun
// through everything; near and total: of the cloud around, towards the sun and through and through. outward:
// outward_factor.
NEPHELE_FN float light_from_around(float mu, float g, float beam, float near, float total, float outward) {
  float forward = phase_henyey_greenstein(mu, kForwardAsymmetry * g) * forward_share(beam, g);
  float diffuse = slab_light(min(near, total), total, g) * outward * (0.25f / kPi);
  return kForwardShare * forward + kDiffuseShare * diffuse * diffuse_transmission(beam - near, g);
}

// ---- Sky and ground ----
//
// Their shares sum to 1, so a uniform environment shows the cloud in its own radiance (white furnace).

// The ground under a cloud field lies partly in its shadow: what it sends up is reduced by this share of the coverage.
// From the ground's light in path-traced images of fields of coverage 0.3 and 0.45.
NEPHELE_CONST(float, kGroundShadow, 0.5f);

// Share of light from above in a slab lit evenly from both sides, optical depth `above` below the top of `total`:
// Eddington's solution without a source, linear in the depth. The cloud is taken to be as dense as one particle at its
// peak, which is what several overlapping ones come to: the share of sky light in the path-traced images of the fields
// then has slope 0.9 to 1.0 over this one.
NEPHELE_FN float slab_share_above(float above, float total, float g) {
  return ((1.0f - g) * (total - above) + 2.0f / 3.0f) / ((1.0f - g) * total + 4.0f / 3.0f);
}
NEPHELE_FN float slab_share_per_depth(float total, float g) { return (1.0f - g) / ((1.0f - g) * total + 4.0f / 3.0f); }

// How much more of what lies behind shows through: light goes on as it came, more or less, so a view from above down
// shows more of the ground. 0.75 g is what Eddington's flux gives in the thinnest slab; fitted to sky and ground light
// of the same five images as above.
NEPHELE_CONST(float, kShareAlongView, 0.55f);

// `share` where the place alone is known; view_z: vertical component of the unit direction from the eye.
NEPHELE_FN float ambient_share_above(float share, float view_z) {
  return clamp(share + kShareAlongView * view_z, 0.0f, 1.0f);
}

// ---- All of it ----

// The light at a place of a cloud as one ray sees it. A particle shaded by a whole chord has one place for the chord.
struct PlaceLight {
  vec3 sun_irradiance;  // after the air, before any cloud
  // Source radiance of sunlight scattered once, per unit sun_irradiance, weakened by tau_sun and tau_self. The caller
  // knows how: a chord integrates over its points in closed form (scattering.h), a place of its own has one depth.
  float once_per_sr;
  // Source radiance of sunlight scattered again inside the particle, per unit irradiance on the particle, and its
  // weight: kAgainShare, or 1 where again_per_sr has that in it.
  float again_per_sr, again_share;
  float tau_sun;          // optical depth towards the sun through the other particles
  float tau_self;         // optical depth towards the sun inside the particle itself
  float tau_near;         // of tau_sun, what belongs to the cloud around
  float tau_cloud;        // optical depth of the cloud around, from its sunlit side to its far side
  float outward;          // outward_factor
  vec3 ambient_radiance;  // of sky and ground
};

// mu: cosine between the way to the sun and the ray from the eye. phase_g: asymmetry of the phase function.
NEPHELE_FN vec3 source_radiance(PlaceLight light, float mu, float phase_g) {
  float again = light.again_per_sr * (light.again_share * exp(-(1.0f - phase_g) * light.tau_sun));
  float around = light_from_around(mu, phase_g, light.tau_sun + light.tau_self, light.tau_near + light.tau_self,
                                   light.tau_cloud, light.outward);
  return light.sun_irradiance * (light.once_per_sr + again + around) + light.ambient_radiance;
}

NEPHELE_SHARED_END

#endif
