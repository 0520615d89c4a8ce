#include "engine/accepted.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>
#include <type_traits>

#include "engine/check.h"

namespace nephele {
namespace {

// The whole text as a number; a plus sign is allowed before it.
template <class Number>
std::optional<Number> read_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Number number{};
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// {"a", "b", "c"} with ", " and " or ": "a, b or c".
template <class Words>
std::string joined(const Words& words, const char* between, const char* before_last) {
  std::ostringstream text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text << (i == 0 ? "" : i + 1 < words.size() ? between : before_last) << words[i];
  return text.str();
}

std::optional<Value> read(const Toggle&, std::string_view text) {
  if (text == "on" || text == "true") return true;
  if (text == "off" || text == "false") return false;
  return std::nullopt;
}
bool holds(const Toggle&, bool) { return true; }
std::string words(const Toggle&) { return "on or off, true or false"; }
std::string place(const Toggle&) { return "on|off"; }

std::optional<Value> read(const WholeNumber&, std::string_view text) { return read_number<std::uint64_t>(text); }
bool holds(const WholeNumber& kind, std::uint64_t number) {
  if (number == 0 && kind.zero_means) return true;
  return number >= kind.minimum && number <= kind.maximum && number % kind.multiple_of == 0;
}
std::string words(const WholeNumber& kind) {
  const std::string what = kind.multiple_of == 1 ? "a whole number" : concat("a multiple of ", kind.multiple_of);
  const std::string text = concat(what, " from ", kind.minimum, " to ", kind.maximum);
  return kind.zero_means ? text + ", or 0 for " + kind.zero_means : text;
}
std::string place(const WholeNumber&) { return "N"; }

std::optional<Value> read(const RealNumber&, std::string_view text) { return read_number<double>(text); }
bool holds(const RealNumber& kind, double number) {
  return kind.ends_accepted ? number >= kind.minimum && number <= kind.maximum
                            : number > kind.minimum && number < kind.maximum;
}
std::string words(const RealNumber& kind) {
  const std::string low = number_text(kind.minimum), high = number_text(kind.maximum);
  return kind.ends_accepted ? "a number from " + low + " to " + high
                            : "a number, more than " + low + ", less than " + high;
}
std::string place(const RealNumber&) { return "X"; }

std::optional<Value> read(const OneOfNumbers&, std::string_view text) { return read_number<std::uint64_t>(text); }
bool holds(const OneOfNumbers& kind, std::uint64_t number) {
  return std::find(kind.numbers.begin(), kind.numbers.end(), number) != kind.numbers.end();
}
std::string words(const OneOfNumbers& kind) { return joined(kind.numbers, ", ", " or "); }
std::string place(const OneOfNumbers& kind) { return joined(kind.numbers, "|", "|"); }

std::optional<Value> read(const OneOfNames&, std::string_view text) { return std::string(text); }
bool holds(const OneOfNames& kind, const std::string& name) {
  return std::find(kind.names.begin(), kind.names.end(), name) != kind.names.end();
}
std::string words(const OneOfNames& kind) { return joined(kind.names, ", ", " or "); }
std::string place(const OneOfNames& kind) { return joined(kind.names, "|", "|"); }

std::optional<Value> read(const PixelSize&, std::string_view text) {
  const std::size_t x = text.find('x');
  if (x == std::string_view::npos) return std::nullopt;
  const auto width = read_number<std::uint32_t>(text.substr(0, x));
  const auto height = read_number<std::uint32_t>(text.substr(x + 1));
  if (!width || !height) return std::nullopt;
  return ImageSize{*width, *height};
}
bool holds(const PixelSize&, const ImageSize& size) {
  return size.width_px >= 1 && size.width_px <= kMaxImageSidePx && size.height_px >= 1 &&
         size.height_px <= kMaxImageSidePx && std::uint64_t{size.width_px} * size.height_px <= kMaxImagePixels;
}
std::string words(const PixelSize&) {
  return concat("WIDTHxHEIGHT, each from 1 to ", kMaxImageSidePx, ", at most ", kMaxImagePixels, " pixels");
}
std::string place(const PixelSize&) { return "WIDTHxHEIGHT"; }

}  // namespace

bool accepts(const Accepted& accepted, const Value& value) {
  return std::visit(
      [](const auto& kind, const auto& held) {
        using Kind = std::remove_cvref_t<decltype(kind)>;
        if constexpr (std::is_same_v<typename Kind::Held, std::remove_cvref_t<decltype(held)>>)
          return holds(kind, held);
        else
          return false;
      },
      accepted, value);
}

std::optional<Value> read_value(const Accepted& accepted, std::string_view text) {
  const std::optional<Value> value = std::visit([&](const auto& kind) { return read(kind, text); }, accepted);
  return value && accepts(accepted, *value) ? value : std::nullopt;
}

std::string value_text(const Value& value) {
  if (const bool* on = std::get_if<bool>(&value)) return *on ? "on" : "off";
  if (const auto* number = std::get_if<std::uint64_t>(&value)) return std::to_string(*number);
  if (const auto* number = std::get_if<double>(&value)) return number_text(*number);
  if (const auto* size = std::get_if<ImageSize>(&value)) return concat(size->width_px, 'x', size->height_px);
  return std::get<std::string>(value);
}

std::string accepted_words(const Accepted& accepted) {
  return std::visit([](const auto& kind) { return words(kind); }, accepted);
}

std::string placeholder(const Accepted& accepted) {
  return std::visit([](const auto& kind) { return place(kind); }, accepted);
}

Error not_accepted(const std::string& name, const std::string& shown, const Accepted& accepted) {
  return Error{name + " is " + shown + "; accepted: " + accepted_words(accepted)};
}

std::string shown_text(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  if (text.size() <= kLongest && read_number<double>(text)) return std::string(text);
  std::string shown(text.substr(0, kLongest));
  std::replace_if(
      shown.begin(), shown.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return '"' + shown + (text.size() > kLongest ? "...\"" : "\"");
}

std::string number_text(double number) {
  char text[64];
  const bool plain = number == 0 || (std::abs(number) >= 1e-4 && std::abs(number) < 1e15);
  const auto [end, failure] = std::to_chars(std::begin(text), std::end(text), number,
                                            plain ? std::chars_format::fixed : std::chars_format::scientific);
  NEPHELE_CHECK(failure == std::errc());
  return std::string(text, end);
}

}  // namespace nephele
