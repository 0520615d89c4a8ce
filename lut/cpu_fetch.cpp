#include "lut/cpu_fetch.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "engine/check.h"
#include "shared/near_beam_axes.h"
#include "shared/table_axes.h"

namespace nephele {

FloatTexture::FloatTexture(const Table& table)
    : width_(static_cast<int>(table.width())),
      height_(static_cast<int>(table.height())),
      depth_(static_cast<int>(table.depth())),
      channels_(static_cast<int>(table.array.shape[3])),
      texels_(table.array.count()) {
  NEPHELE_CHECK(channels_ <= 4, table.name, ' ', channels_);
  for (std::size_t i = 0; i < texels_.size(); ++i) {
    switch (table.array.type) {
      case ElementType::uint8:
        texels_[i] = static_cast<float>(std::to_integer<int>(table.array.data[i])) / 255.0f;
        break;
      case ElementType::float16: {
        std::uint16_t half = 0;
        std::memcpy(&half, &table.array.data[2 * i], 2);
        texels_[i] = glm::unpackHalf2x16(half).x;
        break;
      }
      case ElementType::float32:
        std::memcpy(&texels_[i], &table.array.data[4 * i], 4);
        break;
    }
  }
}

shared::vec4 FloatTexture::sample(const shared::vec3& at) const {
  const int sizes[3] = {width_, height_, depth_};
  int lower[3], upper[3];
  float f[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float place =
        std::clamp(at[axis] * static_cast<float>(sizes[axis]) - 0.5f, 0.0f, static_cast<float>(sizes[axis] - 1));
    lower[axis] = static_cast<int>(place);
    upper[axis] = std::min(lower[axis] + 1, sizes[axis] - 1);
    f[axis] = place - static_cast<float>(lower[axis]);
  }
  shared::vec4 sum(0.0f);
  for (int corner = 0; corner < 8; ++corner) {
    float weight = 1;
    int index[3];
    for (int axis = 0; axis < 3; ++axis) {
      const bool high = corner >> axis & 1;
      index[axis] = high ? upper[axis] : lower[axis];
      weight *= high ? f[axis] : 1 - f[axis];
    }
    const float* texel =
        &texels_[((static_cast<std::size_t>(index[2]) * height_ + index[1]) * width_ + index[0]) * channels_];
    for (int k = 0; k < channels_; ++k) sum[k] += weight * texel[k];
  }
  return sum;
}

shared::vec2 fetch_optical_depth(const FloatTexture& table, const shared::vec3& entry, const shared::vec3& exit) {
  const auto at = shared::optical_depth_coordinates(entry, exit, table.size().x);
  const shared::vec4 a = table.sample({at.exit_uv.x, at.exit_uv.y, at.z0});
  const shared::vec4 b = table.sample({at.exit_uv.x, at.exit_uv.y, at.z1});
  return {shared::mean_density_from_texel(a.x + at.weight * (b.x - a.x)), a.y + at.weight * (b.y - a.y)};
}

float fetch_multiple(const FloatTexture& table, float c, float h, float mu, float sigma, float g) {
  const shared::vec4 a = table.sample(shared::multiple_scattering_coordinates(c, h, sigma, g, table.size()));
  return shared::multiple_scattering_radiance(a, c, h, mu, sigma, g);
}

float fetch_near_beam(const FloatTexture& table, float tau, float mu) {
  const shared::vec2 size(table.size());
  return table.sample(shared::vec3(shared::near_beam_coordinates(tau, mu, size), 0.5f)).x;
}

}  // namespace nephele
