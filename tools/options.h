// Option values that several commands read, and names of numbered frames.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/result.h"

namespace nephele::tools {

struct ImageSize {
  std::uint32_t width = 0, height = 0;
};

inline constexpr std::uint64_t kMaxPixels = 8192ull * 8192ull;

// "1280x720": each side 1 to kMaxImageSidePx, at most kMaxPixels together.
Result<ImageSize> parse_image_size(const std::string& option, const std::string& text);

// "48x24x16" with exactly `axes` sizes.
Result<std::vector<std::uint32_t>> parse_axes(const std::string& option, const std::string& text, std::size_t axes);

// The first "%d", "%4d" or "%04d" in a file name becomes the frame's number, padded with zeros.
bool has_frame_number(const std::string& name);
std::string frame_file_name(const std::string& name, std::uint64_t frame);

// Whether the path ends in the extension (".png"), in upper or lower case.
bool has_extension(const std::string& path, const std::string& extension);

}  // namespace nephele::tools
