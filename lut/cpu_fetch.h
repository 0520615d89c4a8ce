// The fetches of shaders/layer/table_fetch.glsl on the CPU: the same shared axes, linear filtering in float.
#pragma once

#include <vector>

#include "lut/tables.h"
#include "shared/prelude.h"

namespace nephele {

// One table decoded to floats, filtered like a clamped linear sampler.
class FloatTexture {
 public:
  explicit FloatTexture(const Table& table);
  // Texture coordinates in [0, 1]; missing channels are 0.
  shared::vec4 sample(const shared::vec3& at) const;
  shared::vec3 size() const { return {width_, height_, depth_}; }

 private:
  int width_, height_, depth_, channels_;
  std::vector<float> texels_;
};

shared::vec2 fetch_optical_depth(const FloatTexture& table, const shared::vec3& entry, const shared::vec3& exit);
float fetch_near_beam(const FloatTexture& table, float tau, float mu);
float fetch_multiple(const FloatTexture& table, float c, float h, float mu, float sigma, float g);

}  // namespace nephele
