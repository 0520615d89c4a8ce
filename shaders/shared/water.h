// Light from a water surface in a light wind: the sun's glint and the sky in facets of the waves, and what comes back
// from the water itself.
// Based on: Cox and Munk, Measurement of the Roughness of the Sea Surface from Photographs of the Sun's Glitter, 1954
// (slopes); Bruneton, Neyret and Holzschuch, Real-time Realistic Ocean Lighting using Seamless Transitions from
// Geometry to BRDF, 2010 (mean reflectance of the facets). No wave is drawn: footprints take in all of them, so the
// statistics hold the whole variance of the slopes.
#ifndef NEPHELE_SHARED_WATER_H
#define NEPHELE_SHARED_WATER_H

#include "prelude.h"

NEPHELE_SHARED_BEGIN

// Variance of the slope, both components together: 0.003 + 0.00512 U [Cox and Munk], with a wind of U = 3 m/s.
NEPHELE_CONST(float, kWaterSlopeVariance, 0.018f);
NEPHELE_CONST(float, kWaterSlope, 0.134164f);                            // its root
NEPHELE_FN vec3 water_albedo() { return vec3(0.016f, 0.024f, 0.022f); }  // without the surface: inland, not clear

// Fresnel's reflectance in Schlick's form, and its mean over the facets that are seen [Bruneton10].
NEPHELE_FN float water_fresnel(float cos_incidence) {
  float x = 1.0f - cos_incidence;
  return 0.02f + 0.98f * x * x * x * x * x;
}
NEPHELE_FN float mean_water_fresnel(float cos_view) {
  return 0.02f +
         0.98f * pow(1.0f - cos_view, 5.0f * exp(-2.69f * kWaterSlope)) / (1.0f + 22.7f * pow(kWaterSlope, 1.5f));
}

// The share of facets hidden from a direction over the share seen, times the direction's cosine: Smith's function for
// Gaussian slopes in the rational form of Walter et al. 2007, finite along the surface.
NEPHELE_FN float hidden_facets(float up) {
  float steep = up / (kWaterSlope * sqrt(max(1.0e-6f, 1.0f - up * up)));
  if (steep >= 1.6f) return 0.0f;
  float tilt = kWaterSlope * sqrt(max(1.0e-6f, 1.0f - up * up));
  return tilt * (1.0f - 1.259f * steep + 0.396f * steep * steep) / (3.535f + 2.181f * steep);
}

// The sun's glint per unit of its irradiance on the surface, in 1/sr. view_up, sun_up: cosines of the angles between
// the vertical and the ways to the eye and to the sun; view_sun: of the angle between those two.
NEPHELE_FN float water_glint(float view_up, float sun_up, float view_sun) {
  if (sun_up <= 0.0f || view_up <= 0.0f) return 0.0f;
  float facing = sqrt(max(1.0e-6f, 0.5f + 0.5f * view_sun));  // cosine of the incidence on the facet that mirrors
  float facet_up = min(1.0f, (view_up + sun_up) / (2.0f * facing));
  float up2 = facet_up * facet_up;
  float density = exp((1.0f - 1.0f / up2) / kWaterSlopeVariance) / (kPi * kWaterSlopeVariance * up2 * up2);
  float seen = view_up * sun_up + sun_up * hidden_facets(view_up) + view_up * hidden_facets(sun_up);
  return water_fresnel(facing) * density / (4.0f * seen);
}

// Radiance of the surface: direction of view and sun as water_glint has them; irradiance on the ground of the sun alone
// and of the sky. The mirrored sky is the CIE's clear sky by elevation (gradation 1 - exp(-0.32 / sin elevation),
// divided by its cosine-weighted mean), the same on all sides.
NEPHELE_FN vec3 water_reflection(float view_up, float sun_up, float view_sun, vec3 sun, vec3 sky) {
  float up = clamp(view_up, 0.02f, 1.0f);
  float reflectance = mean_water_fresnel(up);
  // Facets lean towards the eye at low angles, so what they show is higher up.
  float elevation = sqrt(up * up + kWaterSlopeVariance);
  vec3 mirrored = sky * ((1.0f - exp(-0.32f / elevation)) / (0.418f * kPi));
  return reflectance * mirrored + (1.0f - reflectance) * water_albedo() / kPi * (sun + sky) +
         water_glint(up, sun_up, view_sun) * sun;
}

NEPHELE_SHARED_END

#endif
