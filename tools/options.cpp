#include "tools/options.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <optional>

#include "engine/check.h"

namespace nephele::tools {
namespace {

// Whole numbers between 'x', nothing else; empty when the text is anything else.
std::vector<std::uint32_t> split_sizes(const std::string& text) {
  std::vector<std::uint32_t> sizes;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (;;) {
    std::uint32_t size = 0;
    const auto [next, failure] = std::from_chars(at, end, size);
    if (failure != std::errc()) return {};
    sizes.push_back(size);
    if (next == end) return sizes;
    if (*next != 'x') return {};
    at = next + 1;
  }
}

struct FrameField {
  std::size_t start = 0, length = 0, digits = 0;
};

std::optional<FrameField> find_frame_field(const std::string& name) {
  for (std::size_t start = name.find('%'); start != std::string::npos; start = name.find('%', start + 1)) {
    std::size_t at = start + 1, digits = 0;
    while (at < name.size() && std::isdigit(static_cast<unsigned char>(name[at])) && digits < 100)
      digits = digits * 10 + static_cast<std::size_t>(name[at++] - '0');
    if (at < name.size() && name[at] == 'd' && digits <= 20) return FrameField{start, at + 1 - start, digits};
  }
  return std::nullopt;
}

// Without links, "." and ".."; a file that is not there yet is resolved as far as its directories are.
std::filesystem::path resolve(const std::string& path) {
  std::error_code failure;
  const std::filesystem::path absolute = std::filesystem::absolute(path, failure);
  const std::filesystem::path resolved = std::filesystem::weakly_canonical(absolute, failure);
  return failure ? absolute.lexically_normal() : resolved;
}

}  // namespace

Result<std::vector<std::uint32_t>> parse_axes(const std::string& option, const std::string& text, std::size_t axes) {
  std::vector<std::uint32_t> sizes = split_sizes(text);
  if (sizes.size() != axes)
    return Error{
        concat(option, " is \"", text, "\"; accepted: ", axes, " whole number", axes > 1 ? "s with x between" : "")};
  return sizes;
}

bool has_frame_number(const std::string& name) { return find_frame_field(name).has_value(); }

std::string frame_file_name(const std::string& name, std::uint64_t frame) {
  const std::optional<FrameField> field = find_frame_field(name);
  if (!field) return name;
  std::string number = std::to_string(frame);
  if (number.size() < field->digits) number.insert(0, field->digits - number.size(), '0');
  return name.substr(0, field->start) + number + name.substr(field->start + field->length);
}

Result<void> check_different(const std::vector<NamedFile>& files, std::uint64_t frames) {
  for (const std::uint64_t frame : {std::uint64_t{0}, frames - 1})
    for (std::size_t i = 0; i < files.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const NamedFile &a = files[j], &b = files[i];
        if (a.path.empty() || b.path.empty()) continue;
        const std::filesystem::path resolved = resolve(frame_file_name(a.path, frame));
        if (resolved == resolve(frame_file_name(b.path, frame)))
          return Error{concat(a.option, " and ", b.option, " are both \"", resolved.string(), '"')};
      }
  return {};
}

bool has_extension(const std::string& path, const std::string& extension) {
  if (path.size() < extension.size()) return false;
  return std::equal(extension.begin(), extension.end(), path.end() - static_cast<std::ptrdiff_t>(extension.size()),
                    [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
}

}  // namespace nephele::tools
