// What the field's kernels share that look at features: the features around the camera, kept in a buffer.
// Where READS_WEATHER is its binding, the weather map lies in a buffer too.
#ifdef READS_WEATHER
layout(scalar, set = 0, binding = READS_WEATHER) readonly buffer WeatherMap { uint weather_texels[]; };
#define NEPHELE_WEATHER_TEXEL(weather, i) weather_texels[i]
#endif
#include "shared/cloud_features.h"
#include "sources/field.glsl"

// One of three, selected rather than indexed: the lattice differs from thread to thread.
FeatureWindow window_of(FeatureWindow all[kCloudLattices], uint lattice) {
  FeatureWindow window = all[0];
  for (uint k = 1u; k < kCloudLattices; ++k) {
    window.corner = lattice == k ? all[k].corner : window.corner;
    window.side = lattice == k ? all[k].side : window.side;
    window.first = lattice == k ? all[k].first : window.first;
  }
  return window;
}

// The lattice cell of a slot of these windows; false past the last one.
bool cell_of_slot(FeatureWindow all[kCloudLattices], uint slot, out uint lattice, out ivec2 cell) {
  lattice = 0u;
  for (uint k = 1u; k < kCloudLattices; ++k) lattice += slot >= all[k].first ? 1u : 0u;
  const FeatureWindow window = window_of(all, lattice);
  const uint local = slot - window.first;
  const uint side = uint(window.side);
  cell = window.corner + ivec2(int(local % side), int(local / side));
  return local < side * side;
}

#ifndef WRITES_FEATURES
#include "kit/texels.glsl"
TEXELS(1, features);  // PackedFeature

#ifdef READS_NEAR
WORDS(READS_NEAR, features_near);  // by slots of near_windows
#endif

PackedFeature feature_in(uint slot) {
  const uvec4 texel = texel_at(features, slot);
  return PackedFeature(uintBitsToFloat(texel.xy), uintBitsToFloat(texel.z), texel.w);
}

// A place: a slot, how many slots on the next row is, and which of the neighbourhood's features reach there.
uvec3 feature_place(FeatureWindow window, FeatureWindow near, ivec2 cell) {
  uint bits = kWholeNeighbourhood;
#ifdef READS_NEAR
  const ivec2 at = cell - near.corner;
  if (all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(near.side))))
    bits = word_at(features_near, feature_slot(near, cell));
#endif
  return uvec3(feature_slot(window, cell), window.side, bits);
}
#define NEPHELE_FEATURE_PLACE uvec3
#define NEPHELE_FEATURE_PLACE_OF(lattice, cell) \
  feature_place(constants.windows[lattice], constants.near_windows[lattice], cell)
#define NEPHELE_FEATURES_NEAR(lattice, place) (place).z
#define NEPHELE_CLOUD_FEATURE(params, lattice, place, i) \
  feature_in((place).x + ((i) / 3u) * (place).y + (i) % 3u - (place).y - 1u)
#endif
