#include "engine/image_compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "engine/check.h"

namespace nephele {
namespace {

Result<void> append_channel(std::vector<double>& values, const ImageF& image, const std::string& image_name,
                            const std::string& channel) {
  const auto index = image.channel_index(channel);
  if (!index) {
    std::string known;
    for (const std::string& other : image.channels) known += (known.empty() ? "" : ", ") + other;
    return Error{image_name + ": has no channel \"" + channel + "\"; it has " + known};
  }
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const float value = image.at(x, y, *index);
      if (!std::isfinite(value))
        return Error{concat(image_name, ": channel \"", channel, "\" is ", value, " at pixel ", x, ", ", y,
                            "; accepted: finite values")};
      values.push_back(value);
    }
  return {};
}

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double rank = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  return std::lerp(values[below], values[std::min(below + 1, values.size() - 1)], rank - std::floor(rank));
}

Result<void> same_size(const ImageF& test, const std::string& test_name, const ImageF& reference,
                       const std::string& reference_name) {
  if (test.width == reference.width && test.height == reference.height) return {};
  return Error{concat(test_name, " is ", test.width, "x", test.height, " and ", reference_name, " is ", reference.width,
                      "x", reference.height, "; accepted: two images of one size")};
}

// 0 / 0 is no error at all.
double over(double error, double size) { return error == 0.0 ? 0.0 : error / size; }

}  // namespace

Result<ImageErrors> compare_images(const ImageF& test, const std::string& test_name, const ImageF& reference,
                                   const std::string& reference_name, std::span<const std::string> channels) {
  if (auto ok = same_size(test, test_name, reference, reference_name); !ok) return ok.error();
  if (channels.empty()) return Error{"no channel to compare"};

  std::vector<double> t, r;
  for (auto name = channels.begin(); name != channels.end(); ++name) {
    if (std::find(channels.begin(), name, *name) != name) return Error{"channel \"" + *name + "\" is named twice"};
    if (auto ok = append_channel(t, test, test_name, *name); !ok) return ok.error();
    if (auto ok = append_channel(r, reference, reference_name, *name); !ok) return ok.error();
  }
  const double count = static_cast<double>(r.size());
  double mean_square = 0;
  for (const double value : r) mean_square += value * value / count;
  double sum_squares = 0, sum_relative = 0, sum_signed = 0, sum_reference = 0;
  std::vector<double> differences;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double error = t[i] - r[i];
    sum_squares += error * error;
    sum_relative += over(error * error, r[i] * r[i] + 0.01 * mean_square);
    sum_signed += error;
    sum_reference += r[i];
    differences.push_back(std::abs(error));
  }
  ImageErrors errors;
  errors.rmse = std::sqrt(sum_squares / count);
  errors.relmse = sum_relative / count;
  errors.bias = over(sum_signed, sum_reference);
  errors.max_abs = *std::max_element(differences.begin(), differences.end());
  errors.p99_abs = percentile(differences, 0.99);
  errors.psnr_db = errors.rmse == 0.0 ? std::numeric_limits<double>::infinity()
                                      : 20.0 * std::log10(percentile(r, 0.999) / errors.rmse);
  errors.pixels = std::uint64_t{test.width} * test.height;
  return errors;
}

Result<LayerErrors> compare_layers(const ImageF& test, const std::string& test_name, const ImageF& reference,
                                   const std::string& reference_name, const ImageF* noise,
                                   const std::string& noise_name) {
  if (auto ok = same_size(test, test_name, reference, reference_name); !ok) return ok.error();
  std::vector<double> t(std::size_t{test.width} * test.height), r = t, opacity, luminance = t;
  const std::array<std::pair<const char*, double>, 3> weights = {{{"R", 0.2126}, {"G", 0.7152}, {"B", 0.0722}}};
  for (const auto& [channel, weight] : weights) {
    std::vector<double> values_t, values_r;
    if (auto ok = append_channel(values_t, test, test_name, channel); !ok) return ok.error();
    if (auto ok = append_channel(values_r, reference, reference_name, channel); !ok) return ok.error();
    for (std::size_t i = 0; i < t.size(); ++i) {
      t[i] += values_t[i];
      r[i] += values_r[i];
      luminance[i] += weight * values_r[i];
    }
  }
  if (auto ok = append_channel(opacity, reference, reference_name, "T"); !ok) return ok.error();
  for (double& value : opacity) value = 1.0 - value;

  const auto bias_between = [&](double low, double high) -> std::optional<double> {
    double error = 0, sum = 0;
    for (std::size_t i = 0; i < t.size(); ++i)
      if (opacity[i] >= low && opacity[i] <= high) {
        error += t[i] - r[i];
        sum += r[i];
      }
    return sum > 0 ? std::optional(error / sum) : std::nullopt;
  };
  LayerErrors errors;
  errors.thin_bias = bias_between(0.3, 0.97);
  errors.thick_bias = bias_between(0.995, 1.0);

  constexpr std::uint32_t kTile = 4;
  std::vector<double> tiles;
  for (std::uint32_t y = 0; y + kTile <= test.height; y += kTile)
    for (std::uint32_t x = 0; x + kTile <= test.width; x += kTile) {
      double sum_t = 0, sum_r = 0, least_opacity = 1;
      for (std::uint32_t i = 0; i < kTile * kTile; ++i) {
        const std::size_t at = std::size_t{y + i / kTile} * test.width + x + i % kTile;
        sum_t += t[at];
        sum_r += r[at];
        least_opacity = std::min(least_opacity, opacity[at]);
      }
      if (least_opacity > 0.97 && sum_r > 0) tiles.push_back(std::abs(sum_t / sum_r - 1.0));
    }
  if (!tiles.empty()) {
    errors.tile_error = std::accumulate(tiles.begin(), tiles.end(), 0.0) / static_cast<double>(tiles.size());
    errors.tile_error_p95 = percentile(tiles, 0.95);
  }

  if (noise != nullptr) {
    if (auto ok = same_size(*noise, noise_name, reference, reference_name); !ok) return ok.error();
    std::vector<double> error;
    if (auto ok = append_channel(error, *noise, noise_name, "SE"); !ok) return ok.error();
    const double count = static_cast<double>(error.size());
    double mean_square = 0, sum = 0;
    for (const double value : luminance) mean_square += value * value / count;
    for (std::size_t i = 0; i < error.size(); ++i)
      sum += over(error[i] * error[i], luminance[i] * luminance[i] + 0.01 * mean_square);
    errors.noise_relmse = sum / count;
  }
  return errors;
}

}  // namespace nephele
