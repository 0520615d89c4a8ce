// From linear radiance to the display: exposure, filmic curve, sRGB encoding, dither.
#ifndef NEPHELE_SHARED_TONEMAP_H
#define NEPHELE_SHARED_TONEMAP_H

#include "hash.h"

NEPHELE_SHARED_BEGIN

// Exposure 0 EV: scene value per radiance, with the sun's irradiance at the top of the atmosphere as unit. At noon a
// cumulus in full sun (radiance 0.25) comes out white, the clear sky a middle blue, and grass at about its albedo.
NEPHELE_CONST(float, kBaseExposure, 5.2f);

// Own filmic curve. A print has more contrast than what it depicts: a power about the middle grey, without which sunlit
// and shaded sides of a cloud, 2 : 1 in radiance, are next to the same white. Above the knee the rest of the way to 1
// as 1 - 1 / (1 + y / 2)^2: slower than 1 - exp, so that haze about the sun and sunlit crowns keep their gradation up
// to ten times white; slope continuous.
NEPHELE_CONST(float, kFilmContrast, 1.25f);
NEPHELE_CONST(float, kFilmGrey, 0.45f);
NEPHELE_CONST(float, kFilmKnee, 0.60f);

NEPHELE_FN float film_curve(float x) {
  float y = kFilmGrey * pow(x * (1.0f / kFilmGrey), kFilmContrast);
  if (y <= kFilmKnee) return y;
  float rest = 1.0f / (1.0f + (y - kFilmKnee) * (0.5f / (1.0f - kFilmKnee)));
  return 1.0f - (1.0f - kFilmKnee) * rest * rest;
}

// Linear display values in [0, 1] of an exposed scene value. The curve goes over the channels (colours bleach on their
// way to white, as on film, but an orange light turns yellow) and over the largest channel alone (hue and saturation
// kept, but never white); a mixture has neither fault. Bright colours are paled first and lose their share of the
// second, so that the sun itself is white.
NEPHELE_CONST(float, kFilmHueShare, 0.45f);
NEPHELE_CONST(float, kFilmPaling, 0.5f);
NEPHELE_CONST(float, kPrintSaturation, 1.10f);  // film is more colourful than what it depicts

NEPHELE_FN vec3 tone_map(vec3 scene) {
  float luminance = 0.2126f * scene.x + 0.7152f * scene.y + 0.0722f * scene.z;
  float bright = max(0.0f, max(scene.x, max(scene.y, scene.z)));
  float saturation = kPrintSaturation - kFilmPaling * bright / (bright + 3.0f);
  vec3 print = max(vec3(0.0f), mix(vec3(luminance), scene, saturation));
  float largest = max(1e-6f, max(print.x, max(print.y, print.z)));
  vec3 by_channel = vec3(film_curve(print.x), film_curve(print.y), film_curve(print.z));
  return mix(by_channel, print * (film_curve(largest) / largest), kFilmHueShare / (1.0f + 0.1f * bright));
}

NEPHELE_FN float srgb_from_linear(float x) {
  return x <= 0.0031308f ? 12.92f * x : 1.055f * pow(x, 1.0f / 2.4f) - 0.055f;
}

// sRGB code values in [0, 1] with triangular noise of one 8-bit step against banding, the same in every frame; black
// stays black.
NEPHELE_CONST(uint, kDitherSeed, 0x646974u);

NEPHELE_FN float dithered_code(float linear, float noise) {
  float code = srgb_from_linear(linear);
  return clamp(code + noise * min(1.0f / 255.0f, code), 0.0f, 1.0f);
}

NEPHELE_FN vec3 display_color(vec3 radiance, float exposure, uvec2 pixel) {
  vec3 linear = tone_map(radiance * (exposure * kBaseExposure));
  uint hash = hash_uvec2(pixel, kDitherSeed);
  float noise = unit_float(hash) + unit_float(hash_uint(hash)) - 1.0f;
  return vec3(dithered_code(linear.x, noise), dithered_code(linear.y, noise), dithered_code(linear.z, noise));
}

NEPHELE_SHARED_END

#endif
