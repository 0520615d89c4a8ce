// Arrays on disk: one NumPy .npy array (format 1.0, C order) with a JSON file beside it that says what the array is.
// Both are written under temporary names and renamed, JSON last: an array exists once its JSON does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/result.h"

namespace nephele {

enum class ElementType { uint8, float16, float32 };

std::size_t element_bytes(ElementType type);
const char* npy_descriptor(ElementType type);  // "|u1", "<f2", "<f4"

struct NpyArray {
  ElementType type = ElementType::float32;
  std::vector<std::size_t> shape;  // slowest axis first
  std::vector<std::byte> data;

  std::size_t count() const;  // product of the shape
};

// A file that is not exactly such an array (magic, header, type, order, shape, byte count) is an error naming the file
// and the field.
Result<NpyArray> read_npy(const std::filesystem::path& path);
Result<void> write_npy(const std::filesystem::path& path, const NpyArray& array);

// Where the data of such a file lies, for arrays of up to max_elements that are read piece by piece. Everything that
// read_npy checks has been checked.
struct NpyLayout {
  ElementType type = ElementType::float32;
  std::vector<std::size_t> shape;
  std::size_t data_at = 0;  // bytes from the file's beginning
};
Result<NpyLayout> read_npy_layout(const std::filesystem::path& path, std::size_t max_elements);

// Whole files: read up to max_bytes; write through a temporary name that no other process or thread uses.
Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::size_t max_bytes);
Result<void> write_file(const std::filesystem::path& path, std::span<const std::byte> data);

// FNV-1a, 64 bits, as 16 hexadecimal digits.
std::uint64_t fnv1a(std::span<const std::byte> data, std::uint64_t start = 0xcbf29ce484222325u);
std::string hex64(std::uint64_t value);

}  // namespace nephele
