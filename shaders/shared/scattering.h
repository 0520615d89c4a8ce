// Light scattered by a homogeneous unit sphere of optical radius sigma (extinction times radius), lit by a beam of
// irradiance 1, albedo 1. One view ray is described by
//   n      outward normal where the ray enters,  omega = minus the view direction,  s = direction light travels
//   c      n.s, negative on the lit side     h      n.omega, half the chord, in [0, 1]
//   mu     s.omega, cosine of the scattering angle    sigma  optical radius, 0 .. 1e4
// These three cosines and sigma say everything; no angle is ever formed.
#ifndef NEPHELE_SHARED_SCATTERING_H
#define NEPHELE_SHARED_SCATTERING_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

// 1 - exp(-x) without cancellation, x >= 0.
NEPHELE_FN float one_minus_exp(float x) {
  return x < 0.02f ? x * (1.0f - x * (0.5f - x * (1.0f / 6.0f))) : 1.0f - exp(-x);
}

// Distance the light travels inside the unit sphere before a point with p.s = along and 1 - |p|^2 = depth.
NEPHELE_FN float light_path(float along, float depth) {
  float m = abs(along) + sqrt(along * along + depth);
  return along >= 0.0f ? m : depth / max(m, 1e-20f);
}

// exp(-(optical depth travelled) + peeled): the integrand at distance u behind the entry.
NEPHELE_FN float single_scattering_term(float c, float h, float mu, float sigma, float u, float peeled) {
  float along = c - u * mu;
  float depth = max(0.0f, u * (2.0f * h - u));
  return exp(peeled - sigma * (u + light_path(along, depth)));
}

// Radiance of light scattered once, per unit of phase function and irradiance:
//   S = sigma * integral over the chord of exp(-sigma (u + d(u))) du,   d = distance travelled by the light.
// Four Gauss points after substituting the mean slope k of u + d; relative RMS error at most 0.6 % over random rays at
// any sigma in 0.01 .. 200. Short chords (2 a h < 1e-3), where the substitution cancels, use plain Gauss points.
NEPHELE_FN float single_scattering(float c, float h, float mu, float sigma) {
  const float x0 = 0.06943184420297371f;
  const float x1 = 0.33000947820757187f;
  const float w0 = 0.17392742256872693f;
  const float w1 = 0.32607257743127307f;
  float chord = 2.0f * max(h, 0.0f);
  float exit = c - chord * mu;
  float slope = (chord + exit + abs(exit) - c - abs(c)) / max(chord, 1e-12f);
  slope = clamp(slope, 0.01f, 1.0f);
  float a = slope * sigma;
  if (a * chord < 1e-3f) {
    return chord * sigma *
           (w0 * (single_scattering_term(c, h, mu, sigma, x0 * chord, 0.0f) +
                  single_scattering_term(c, h, mu, sigma, chord - x0 * chord, 0.0f)) +
            w1 * (single_scattering_term(c, h, mu, sigma, x1 * chord, 0.0f) +
                  single_scattering_term(c, h, mu, sigma, chord - x1 * chord, 0.0f)));
  }
  float v = one_minus_exp(a * chord);
  float p0 = -log(1.0f - v * x0);
  float p1 = -log(1.0f - v * x1);
  float p2 = -log(1.0f - v * (1.0f - x1));
  float p3 = -log(1.0f - v * (1.0f - x0));
  return v / slope *
         (w0 * (single_scattering_term(c, h, mu, sigma, p0 / a, p0) +
                single_scattering_term(c, h, mu, sigma, p3 / a, p3)) +
          w1 * (single_scattering_term(c, h, mu, sigma, p1 / a, p1) +
                single_scattering_term(c, h, mu, sigma, p2 / a, p2)));
}

NEPHELE_SHARED_END

#endif
