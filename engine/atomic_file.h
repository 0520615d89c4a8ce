// Files that appear complete or not at all: written under a temporary name in the same directory, then renamed.
// On any failure the temporary file is removed and an earlier file of that name is untouched.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "engine/result.h"

namespace nephele {

Result<void> write_file_atomically(const std::string& path, std::span<const std::byte> bytes);
Result<void> write_file_atomically(const std::string& path, std::string_view text);

// Whether write_file_atomically could write there, found out by trying: to be asked before long work.
Result<void> check_writable(const std::string& path);

}  // namespace nephele
