// How large an image may be: one limit for files that are read and for frames that are rendered.
#pragma once

#include <cstdint>

namespace nephele {

inline constexpr std::uint32_t kMaxImageSidePx = 16384;
inline constexpr std::uint64_t kMaxImagePixels = std::uint64_t{8192} * 8192;  // of a rendered frame

struct ImageSize {
  std::uint32_t width_px = 0, height_px = 0;
  bool operator==(const ImageSize&) const = default;
};

}  // namespace nephele
