// The axes of the paper's 4D tables, kept to compare table_axes.h with. Based on: Yusov, High-Performance Rendering of
// Realistic Cumulus Clouds Using Pre-computed Lighting, 2014, sections 4.1, 4.3, 5.1. Each axis beside its inverse;
// places along an axis are fractions of its range, vertices at both ends (azimuths, too: the first and the last one
// agree).
//   optical depth  azimuth and zenith of the entry point, azimuth and zenith (0 .. pi/2) of the direction in there
//   scattering     zenith of the entry point from the light, azimuth and zenith (0 .. pi/2) of the direction,
//                  logarithm of the density
// A table is one 3D texture: x and y are the first two axes, z holds the third one once for each vertex of the fourth.
#ifndef NEPHELE_SHARED_PAPER_AXES_H
#define NEPHELE_SHARED_PAPER_AXES_H

#include "table_axes.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(float, kPaperGFirst, 0.9f);
NEPHELE_CONST(float, kPaperGLater, 0.7f);
NEPHELE_CONST(int, kPaperLastOrder, 18);
// Density scales 2^-4 .. 2^3 of a particle whose optical radius at scale 1 is 0.07 * 184.
NEPHELE_CONST(float, kPaperOpticalRadius, 12.88f);
NEPHELE_CONST(float, kPaperFirstOctave, -4.0f);
NEPHELE_CONST(float, kPaperOctaves, 7.0f);

// In [0, 1]; 0 on the axis itself.
NEPHELE_FN float fraction_of_turn(float y, float x) {
  if (x == 0.0f && y == 0.0f) return 0.0f;
  float turn = atan(y, x) / (2.0f * kPi);
  return turn < 0.0f ? turn + 1.0f : turn;
}

NEPHELE_FN float fraction_of_zenith(float cosine, float range_rad) {
  return acos(clamp(cosine, -1.0f, 1.0f)) / range_rad;
}

// Where a chord from S to E (unit vectors in the particle's frame) stands on the four axes.
NEPHELE_FN vec4 paper_chord_axes(vec3 entry, vec3 exit) {
  vec3 chord = exit - entry;
  float span = length(chord);
  vec3 direction = span > 1e-6f ? chord / span : -entry;
  float azimuth = fraction_of_turn(entry.y, entry.x);
  float a = 2.0f * kPi * azimuth;
  vec3 south = vec3(entry.z * cos(a), entry.z * sin(a), -sqrt(max(0.0f, 1.0f - entry.z * entry.z)));
  vec3 east = vec3(-sin(a), cos(a), 0.0f);
  return vec4(azimuth, fraction_of_zenith(entry.z, kPi), fraction_of_turn(dot(direction, east), dot(direction, south)),
              fraction_of_zenith(0.5f * span, 0.5f * kPi));
}

NEPHELE_FN void paper_chord_from_axes(vec4 at, NEPHELE_OUT(vec3) entry, NEPHELE_OUT(vec3) exit) {
  float a = 2.0f * kPi * at.x;
  float zenith = kPi * at.y;
  float turn = 2.0f * kPi * at.z;
  float slant = 0.5f * kPi * at.w;
  vec3 south = vec3(cos(zenith) * cos(a), cos(zenith) * sin(a), -sin(zenith));
  vec3 east = vec3(-sin(a), cos(a), 0.0f);
  entry = vec3(sin(zenith) * cos(a), sin(zenith) * sin(a), cos(zenith));
  vec3 direction = sin(slant) * (cos(turn) * south + sin(turn) * east) - cos(slant) * entry;
  exit = normalize(entry + 2.0f * cos(slant) * direction);
}

// The variables of scattering.h. The mirror symmetry of the azimuth is not used: as published, half of it is spare.
NEPHELE_FN vec4 paper_scattering_axes(float c, float h, float mu, float sigma) {
  float octave = log2(max(sigma, 1e-30f) / kPaperOpticalRadius);
  return vec4(fraction_of_zenith(c, kPi), fraction_of_zenith(azimuth_cosine(c, h, mu), 2.0f * kPi),
              fraction_of_zenith(h, 0.5f * kPi), clamp((octave - kPaperFirstOctave) / kPaperOctaves, 0.0f, 1.0f));
}

NEPHELE_FN float paper_optical_radius_from_axis(float t) {
  return kPaperOpticalRadius * exp2(kPaperFirstOctave + kPaperOctaves * t);
}

// Two trilinear fetches, at z0 and z1, mixed by `weight`.
struct PaperCoordinates {
  vec2 xy;
  float z0;
  float z1;
  float weight;
};

NEPHELE_FN PaperCoordinates paper_coordinates(vec4 at, vec4 size) {
  float slice = at.w * (size.w - 1.0f);
  float lower = clamp(floor(slice), 0.0f, size.w - 2.0f);
  float place = at.z * (size.z - 1.0f) + 0.5f;
  PaperCoordinates result;
  result.xy = vec2(texture_from_axis(at.x, size.x), texture_from_axis(at.y, size.y));
  result.z0 = (lower * size.z + place) / (size.z * size.w);
  result.z1 = ((lower + 1.0f) * size.z + place) / (size.z * size.w);
  result.weight = slice - lower;
  return result;
}

NEPHELE_SHARED_END

#endif
