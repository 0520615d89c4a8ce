// What values an option, a setting or a key of a file takes. Text is read against it, values are checked against it,
// and --help and error lines say it in the same words, so that a range is written down once.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/image_size.h"
#include "engine/result.h"

namespace nephele {

// Each kind of accepted values, with the type that holds one of them.
struct Toggle {
  using Held = bool;
};

struct WholeNumber {
  using Held = std::uint64_t;

  std::uint64_t minimum, maximum;
  std::uint64_t multiple_of = 1;
  const char* zero_means = nullptr;  // 0 is accepted too and stands for this
};

struct RealNumber {
  using Held = double;

  double minimum, maximum;
  bool ends_accepted = true;
};

struct OneOfNumbers {
  using Held = std::uint64_t;

  std::vector<std::uint64_t> numbers;
};

struct OneOfNames {
  using Held = std::string;

  OneOfNames(std::span<const char* const> names_in) : names(names_in.begin(), names_in.end()) {}
  OneOfNames(std::initializer_list<const char*> names_in) : names(names_in.begin(), names_in.end()) {}
  std::vector<std::string> names;
};

// "1280x720"; its limits are those of image_size.h.
struct PixelSize {
  using Held = ImageSize;
};

using Accepted = std::variant<Toggle, WholeNumber, RealNumber, OneOfNumbers, OneOfNames, PixelSize>;

// Of the type that the kind of accepted values holds; another type is never accepted.
using Value = std::variant<bool, std::uint64_t, double, std::string, ImageSize>;

bool accepts(const Accepted& accepted, const Value& value);

// Nothing where the text is not wholly such a value. value_text(*read_value(a, text)) reads back as the same value.
std::optional<Value> read_value(const Accepted& accepted, std::string_view text);
std::string value_text(const Value& value);

// "a whole number from 4 to 4096", after "accepted: ".
std::string accepted_words(const Accepted& accepted);
// "N", "low|medium|high": stands for the value in --help.
std::string placeholder(const Accepted& accepted);

// "--steps is 3; accepted: a whole number from 4 to 4096". `shown` is the value as its writer had it (shown_text).
Error not_accepted(const std::string& name, const std::string& shown, const Accepted& accepted);
// Typed text in an error line: a number as it stands, anything else quoted; printable and not long.
std::string shown_text(std::string_view text);

// The shortest digits that give the number back, with an exponent only below 0.0001 and from 1e15 on.
std::string number_text(double number);

}  // namespace nephele
