// Phase functions, per steradian: they integrate to 1 over the sphere. mu = cosine of the scattering angle, 1 =
// forward.
#ifndef NEPHELE_SHARED_PHASE_H
#define NEPHELE_SHARED_PHASE_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(uint, kPhaseHenyeyGreenstein, 0u);
NEPHELE_CONST(uint, kPhaseCornetteShanks, 1u);

// 1 + g^2 - 2 g mu without cancellation near the peak. |g| < 1.
NEPHELE_FN float phase_denominator(float mu, float g) {
  float a = abs(g);
  float toward_peak = g < 0.0f ? -mu : mu;
  return (1.0f - a) * (1.0f - a) + 2.0f * a * max(0.0f, 1.0f - toward_peak);
}

// Henyey and Greenstein 1941. Mean cosine g.
NEPHELE_FN float phase_henyey_greenstein(float mu, float g) {
  float d = phase_denominator(mu, g);
  return (1.0f - g * g) / (4.0f * kPi * d * sqrt(d));
}

// Cornette and Shanks 1992. Mean cosine: cornette_shanks_mean_cosine(g).
NEPHELE_FN float phase_cornette_shanks(float mu, float g) {
  float d = phase_denominator(mu, g);
  return 3.0f * (1.0f - g * g) * (1.0f + mu * mu) / (8.0f * kPi * (2.0f + g * g) * d * sqrt(d));
}

NEPHELE_FN float cornette_shanks_mean_cosine(float g) { return g * 3.0f * (4.0f + g * g) / (5.0f * (2.0f + g * g)); }

NEPHELE_FN float phase_per_sr(uint phase_function, float mu, float g) {
  return phase_function == kPhaseCornetteShanks ? phase_cornette_shanks(mu, g) : phase_henyey_greenstein(mu, g);
}

NEPHELE_FN float phase_mean_cosine(uint phase_function, float g) {
  return phase_function == kPhaseCornetteShanks ? cornette_shanks_mean_cosine(g) : g;
}

// Legendre moments: the mean of P_l over the phase function. Cornette and Shanks's is Henyey and Greenstein's times
// 3 (1 + mu^2) / (2 (2 + g^2)), and mu P_l = ((l + 1) P_(l + 1) + l P_(l - 1)) / (2 l + 1).
NEPHELE_FN float henyey_greenstein_moment_times_mu(int l, float g) {
  float below = l > 0 ? float(l) * pow(g, float(l - 1)) : 0.0f;
  return (float(l + 1) * pow(g, float(l + 1)) + below) / float(2 * l + 1);
}
NEPHELE_FN float phase_moment(uint phase_function, int l, float g) {
  float own = l > 0 ? pow(g, float(l)) : 1.0f;
  if (phase_function != kPhaseCornetteShanks) return own;
  float below = l > 0 ? float(l) * henyey_greenstein_moment_times_mu(l - 1, g) : 0.0f;
  float squared = (float(l + 1) * henyey_greenstein_moment_times_mu(l + 1, g) + below) / float(2 * l + 1);
  return 1.5f * (own + squared) / (2.0f + g * g);
}

NEPHELE_SHARED_END

#endif
