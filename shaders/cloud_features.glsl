// What the cloud shaders share: the features around the camera, kept in a buffer. The including shader has declared
// the uniform block `frame` (binding 0); the windows are the CPU's, so that writer and readers agree.
// Where READS_WEATHER is its binding, the weather map lies in a buffer too.
#ifdef READS_WEATHER
layout(scalar, set = 0, binding = READS_WEATHER) readonly buffer WeatherMap { uint weather_texels[]; };
#define NEPHELE_WEATHER_TEXEL(weather, i) weather_texels[i]
#endif
#include "shared/cloud_features.h"

layout(push_constant, scalar) uniform Push {
  FeatureWindow windows[kCloudLattices];
  WeatherPlacement weather;
};

CloudParams frame_cloud_params() {
  CloudParams params = cloud_params(frame);
  params.weather.placement = weather;
  return params;
}

#ifndef WRITES_FEATURES
layout(scalar, set = 0, binding = 1) readonly buffer Features { PackedFeature features[]; };

PackedFeature stored_feature(uint lattice, ivec2 cell) { return features[feature_slot(windows[lattice], cell)]; }
#define NEPHELE_CLOUD_FEATURE(params, lattice, cell) stored_feature(lattice, cell)
#endif
