// Option values that several commands read, and names of numbered frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/accepted.h"
#include "engine/result.h"

namespace nephele::tools {

inline constexpr RealNumber kTimeS{-1e9, 1e9};

// "48x24x16" with exactly `axes` sizes.
Result<std::vector<std::uint32_t>> parse_axes(const std::string& option, const std::string& text, std::size_t axes);

// The first "%d", "%4d" or "%04d" in a file name becomes the frame's number, padded with zeros.
bool has_frame_number(const std::string& name);
std::string frame_file_name(const std::string& name, std::uint64_t frame);

struct NamedFile {
  const char* option;
  std::string path;  // "" where the option was not given; may hold a frame's number
};

// An error where two of them are the same file for the first or the last of `frames` frames, however each is spelt.
Result<void> check_different(const std::vector<NamedFile>& files, std::uint64_t frames);

// Whether the path ends in the extension (".png"), in upper or lower case.
bool has_extension(const std::string& path, const std::string& extension);

}  // namespace nephele::tools
