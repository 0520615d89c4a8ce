#include "engine/npy.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include "engine/check.h"

namespace nephele {

namespace {

constexpr char kMagic[] = "\x93NUMPY\x01\x00";
constexpr std::size_t kMagicBytes = 8;
constexpr std::size_t kMaxElements = std::size_t{1} << 28;

Error npy_error(const std::filesystem::path& path, const std::string& what) { return {path.string() + ": " + what}; }

std::string npy_header(const NpyArray& array) {
  std::string shape;
  for (std::size_t n : array.shape) shape += std::to_string(n) + ", ";
  if (array.shape.size() > 1) shape.resize(shape.size() - 2);
  if (array.shape.size() == 1) shape.pop_back();
  std::string text = std::string("{'descr': '") + npy_descriptor(array.type) + "', 'fortran_order': False, 'shape': (" +
                     shape + "), }";
  // Magic, header length and header fill a multiple of 64 bytes and end in a newline.
  while ((kMagicBytes + 2 + text.size() + 1) % 64 != 0) text += ' ';
  return text + '\n';
}

// The value after `key` in the header's dictionary, up to `terminator`; empty when it is not there.
std::string header_field(const std::string& header, const std::string& key, char open, char close) {
  const std::size_t name = header.find("'" + key + "'");
  if (name == std::string::npos) return {};
  const std::size_t begin = header.find(open, name + key.size() + 2);
  if (begin == std::string::npos) return {};
  const std::size_t end = header.find(close, begin + 1);
  return end == std::string::npos ? std::string{} : header.substr(begin + 1, end - begin - 1);
}

}  // namespace

std::size_t element_bytes(ElementType type) {
  return type == ElementType::uint8 ? 1 : type == ElementType::float16 ? 2 : 4;
}

const char* npy_descriptor(ElementType type) {
  return type == ElementType::uint8 ? "|u1" : type == ElementType::float16 ? "<f2" : "<f4";
}

std::size_t NpyArray::count() const {
  std::size_t product = 1;
  for (std::size_t n : shape) product *= n;
  return product;
}

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::size_t max_bytes) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return npy_error(path, "cannot be opened for reading");
  const std::streamoff bytes = file.tellg();
  if (bytes < 0) return npy_error(path, "size cannot be read");
  if (static_cast<std::size_t>(bytes) > max_bytes)
    return npy_error(path, concat("size ", bytes, " bytes, at most ", max_bytes, " are expected"));
  std::vector<std::byte> data(static_cast<std::size_t>(bytes));
  file.seekg(0);
  if (!file.read(reinterpret_cast<char*>(data.data()), bytes)) return npy_error(path, "cannot be read");
  return data;
}

Result<void> write_file(const std::filesystem::path& path, std::span<const std::byte> data) {
  static std::atomic<unsigned> serial{0};
  const std::filesystem::path temporary =
      path.string() + concat(".tmp-", static_cast<long>(::getpid()), "-", serial.fetch_add(1));
  std::error_code ignored;
  {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
    file.close();
    if (!file) {
      std::filesystem::remove(temporary, ignored);
      return npy_error(path, "cannot be written");
    }
  }
  std::error_code failed;
  std::filesystem::rename(temporary, path, failed);
  if (failed) {
    std::filesystem::remove(temporary, ignored);
    return npy_error(path, "cannot be written: " + failed.message());
  }
  return {};
}

namespace {

// The header in the first bytes of a file of file_bytes; `bytes` holds all of it, if the file does.
Result<NpyLayout> parse_layout(std::span<const std::byte> bytes, std::uintmax_t file_bytes, std::size_t max_elements,
                               const std::filesystem::path& path) {
  if (bytes.size() < kMagicBytes + 2 || std::memcmp(bytes.data(), kMagic, kMagicBytes) != 0)
    return npy_error(path, "magic: not a NumPy file of format 1.0");
  const std::size_t header_bytes =
      std::to_integer<std::size_t>(bytes[kMagicBytes]) | std::to_integer<std::size_t>(bytes[kMagicBytes + 1]) << 8;
  NpyLayout layout;
  layout.data_at = kMagicBytes + 2 + header_bytes;
  if (layout.data_at > bytes.size()) return npy_error(path, "header: cut short");
  const std::string header(reinterpret_cast<const char*>(bytes.data()) + kMagicBytes + 2, header_bytes);

  // What follows the key's own quotes is the next quoted string.
  const std::size_t descr = header.find("'descr'");
  const std::string type = descr == std::string::npos ? "" : header_field(header.substr(descr), "descr", '\'', '\'');
  bool known = false;
  for (ElementType candidate : {ElementType::uint8, ElementType::float16, ElementType::float32}) {
    if (type != npy_descriptor(candidate)) continue;
    layout.type = candidate;
    known = true;
  }
  if (!known) return npy_error(path, "descr: '" + type + "', accepted are |u1, <f2 and <f4");
  if (header.find("'fortran_order': False") == std::string::npos)
    return npy_error(path, "fortran_order: only False is accepted");
  const std::string shape = header_field(header, "shape", '(', ')');
  std::size_t product = 1;
  for (std::size_t at = 0; at < shape.size();) {
    const std::size_t digits = shape.find_first_of("0123456789", at);
    if (digits == std::string::npos) break;
    std::size_t n = 0;
    for (at = digits; at < shape.size() && shape[at] >= '0' && shape[at] <= '9'; ++at)
      if (n <= max_elements) n = n * 10 + static_cast<std::size_t>(shape[at] - '0');
    if (n == 0 || n > max_elements || product > max_elements / n)
      return npy_error(path, concat("shape: (", shape, "), 1 to ", max_elements, " elements are accepted"));
    product *= n;
    layout.shape.push_back(n);
  }
  if (layout.shape.empty()) return npy_error(path, "shape: missing");
  if (file_bytes - layout.data_at != product * element_bytes(layout.type))
    return npy_error(path, concat("data: ", file_bytes - layout.data_at, " bytes, the shape needs ",
                                  product * element_bytes(layout.type)));
  return layout;
}

}  // namespace

Result<NpyLayout> read_npy_layout(const std::filesystem::path& path, std::size_t max_elements) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff file_bytes = file ? static_cast<std::streamoff>(file.tellg()) : -1;
  if (file_bytes < 0 || std::filesystem::is_directory(path)) return npy_error(path, "cannot be opened for reading");
  std::vector<std::byte> bytes(std::min<std::size_t>(static_cast<std::size_t>(file_bytes), kMagicBytes + 2 + 65535));
  file.seekg(0);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
    return npy_error(path, "cannot be read");
  return parse_layout(bytes, static_cast<std::uintmax_t>(file_bytes), max_elements, path);
}

Result<NpyArray> read_npy(const std::filesystem::path& path) {
  Result<std::vector<std::byte>> file = read_file(path, kMaxElements * 4 + 65536);
  if (!file) return file.error();
  Result<NpyLayout> layout = parse_layout(*file, file->size(), kMaxElements, path);
  if (!layout) return layout.error();
  NpyArray array{layout->type, std::move(layout->shape), {}};
  array.data.assign(file->begin() + static_cast<std::ptrdiff_t>(layout->data_at), file->end());
  return array;
}

Result<void> write_npy(const std::filesystem::path& path, const NpyArray& array) {
  NEPHELE_CHECK(array.data.size() == array.count() * element_bytes(array.type), path.string(), ' ', array.data.size());
  const std::string header = npy_header(array);
  std::string text(kMagic, kMagicBytes);
  text += static_cast<char>(header.size() & 255);
  text += static_cast<char>(header.size() >> 8);
  text += header;
  std::vector<std::byte> file(text.size() + array.data.size());
  std::memcpy(file.data(), text.data(), text.size());
  std::memcpy(file.data() + text.size(), array.data.data(), array.data.size());
  return write_file(path, file);
}

std::uint64_t fnv1a(std::span<const std::byte> data, std::uint64_t start) {
  std::uint64_t hash = start;
  for (std::byte b : data) hash = (hash ^ std::to_integer<std::uint64_t>(b)) * 0x100000001b3u;
  return hash;
}

std::string hex64(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

}  // namespace nephele
