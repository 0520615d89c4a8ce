// A shader as the build embeds it: SPIR-V words of the program's own memory.
#pragma once

#include <cstddef>
#include <cstdint>

namespace nephele {

struct ShaderCode {
  const char* name;
  const std::uint32_t* words;
  std::size_t bytes;
  // The same shader reading its records from storage buffers instead of texel buffers (shaders/kit/texels.glsl); null
  // for a shader that has no such records.
  const ShaderCode* storage = nullptr;
};

}  // namespace nephele
