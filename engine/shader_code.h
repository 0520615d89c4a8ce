// A shader as the build embeds it: SPIR-V words of the program's own memory.
#pragma once

#include <cstddef>
#include <cstdint>

namespace nephele {

struct ShaderCode {
  const char* name;
  const std::uint32_t* words;
  std::size_t bytes;
};

}  // namespace nephele
