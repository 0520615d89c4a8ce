// How far an image is from a reference: one set of metrics for the command line, the sweeps and the tests.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "engine/image_io.h"
#include "engine/result.h"

namespace nephele {

// Over all values compared (pixels times channels), t of the image and r of the reference; means are over the values.
struct ImageErrors {
  double rmse = 0;     // sqrt(mean (t - r)^2)
  double relmse = 0;   // mean of (t - r)^2 / (r^2 + 0.01 mean r^2)
  double bias = 0;     // mean (t - r) / mean r
  double max_abs = 0;  // largest |t - r|
  double p99_abs = 0;  // 99th percentile of |t - r|
  double psnr_db = 0;  // 20 log10(peak / rmse), the peak being the 99.9th percentile of r
  std::uint64_t pixels = 0;
};
// Percentiles lie on straight lines between neighbouring values, as NumPy's do.
// Equal images have relmse and bias 0 and an infinite psnr_db, whatever the reference; others an infinite
// relmse or bias where they are divided by 0.

// Over the named channels, all of them in one mean. Errors name the image, the channel and the pixel: a channel
// that is missing or named twice, sizes that differ, values that are not finite.
Result<ImageErrors> compare_images(const ImageF& test, const std::string& test_name, const ImageF& reference,
                                   const std::string& reference_name, std::span<const std::string> channels);

// Errors of a cloud layer (channels R, G, B: radiance; T: transmittance) by how opaque the reference is. Null where no
// pixel or tile is that opaque. r is a sum over R, G and B.
struct LayerErrors {
  std::optional<double> thin_bias;   // mean (t - r) / mean r, reference opacity .3 to .97
  std::optional<double> thick_bias;  // the same, above .995
  // |t / r - 1| over tiles of 4 x 4 pixels, all of them of an opacity above .97: mean and 95th percentile.
  std::optional<double> tile_error, tile_error_p95;
  // Share of relMSE that noise of the reference makes: its mean squared standard error, weighed as relMSE weighs.
  std::optional<double> noise_relmse;
};

// noise: null, or an image with a channel SE, the standard error of the reference's luminance. Errors as above.
Result<LayerErrors> compare_layers(const ImageF& test, const std::string& test_name, const ImageF& reference,
                                   const std::string& reference_name, const ImageF* noise,
                                   const std::string& noise_name);

}  // namespace nephele
