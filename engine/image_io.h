// Images on disk: 8-bit PNG of what a screen shows, float32 OpenEXR of linear data. The same pixels give the same
// bytes (no dates, no host names), and files appear complete or not at all (atomic_file.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/image_size.h"
#include "engine/result.h"

namespace nephele {

// Rows from the top, channels interleaved: data[(y * width + x) * channels.size() + channel].
struct ImageF {
  std::uint32_t width = 0, height = 0;
  std::vector<std::string> channels;  // e.g. R G B, or R G B T Z
  std::vector<float> data;

  std::optional<std::size_t> channel_index(std::string_view name) const;
  float at(std::uint32_t x, std::uint32_t y, std::size_t channel) const {
    return data[(std::size_t{y} * width + x) * channels.size() + channel];
  }
};

// Tone-mapped sRGB bytes, 4 a pixel; alpha is dropped.
Result<void> write_png(const std::string& path, std::uint32_t width, std::uint32_t height,
                       std::span<const std::uint8_t> rgba);

// 8 bits a channel as they stand in the file (16 are cut to 8), no colour management; alpha is dropped.
struct ImageBytes {
  std::uint32_t width = 0, height = 0;
  std::uint32_t channels = 0;      // 1 (grey) or 3
  std::vector<std::uint8_t> data;  // rows from the top, channels interleaved
};

Result<ImageBytes> read_png(const std::string& path, std::uint32_t max_side_px = kMaxImageSidePx);

// One channel of 16 bits as they stand in the file (8 are scaled by 257), no colour management; alpha is dropped. An
// image with colours is an error.
struct GreyImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint16_t> data;  // rows from the top
};

Result<GreyImage> read_grey_png(const std::string& path, std::uint32_t max_side_px = kMaxImageSidePx);

Result<void> write_exr(const std::string& path, const ImageF& image);

// All channels of the data window as float32, in the file's own order (alphabetical): look them up by name.
Result<ImageF> read_exr(const std::string& path);

}  // namespace nephele
