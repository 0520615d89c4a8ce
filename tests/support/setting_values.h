// Texts that tests give to settings, made from what the table says each one accepts.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "passes/settings.h"

namespace nephele::test {

// Every accepted text of a finite kind, the ends of a range, some sizes.
inline std::vector<std::string> accepted_texts(const Accepted& accepted) {
  if (std::holds_alternative<Toggle>(accepted)) return {"on", "off"};
  if (const auto* names = std::get_if<OneOfNames>(&accepted)) return names->names;
  if (std::holds_alternative<PixelSize>(accepted)) return {"1x1", "16384x4096", "31x17"};
  std::vector<std::string> texts;
  if (const auto* numbers = std::get_if<OneOfNumbers>(&accepted))
    for (const std::uint64_t number : numbers->numbers) texts.push_back(std::to_string(number));
  if (const auto* range = std::get_if<WholeNumber>(&accepted)) {
    texts = {std::to_string(range->minimum), std::to_string(range->maximum)};
    if (range->zero_means) texts.emplace_back("0");
  }
  if (const auto* range = std::get_if<RealNumber>(&accepted))
    texts = {number_text(range->minimum), number_text(range->maximum)};
  return texts;
}

inline std::vector<std::string> refused_texts(const Accepted& accepted) {
  std::vector<std::string> texts{"", "surely not", "-1", "3 ", "99999999999999999999", "nan"};
  if (const auto* range = std::get_if<RealNumber>(&accepted)) {
    texts.push_back(number_text(std::nextafter(range->minimum, -INFINITY)));
    texts.push_back(number_text(std::nextafter(range->maximum, INFINITY)));
  } else {
    texts.emplace_back("1.5");
  }
  if (const auto* range = std::get_if<WholeNumber>(&accepted)) {
    texts.push_back(std::to_string(range->minimum - 1));
    texts.push_back(std::to_string(range->maximum + 1));
    if (range->minimum == 1 && range->zero_means) texts.erase(texts.end() - 2);  // 0 is accepted
    if (range->multiple_of > 1) texts.push_back(std::to_string(range->minimum + 1));
  }
  if (std::holds_alternative<OneOfNumbers>(accepted)) texts.insert(texts.end(), {"0", "3"});
  if (std::holds_alternative<OneOfNames>(accepted)) texts.emplace_back("0");
  if (std::holds_alternative<PixelSize>(accepted))
    texts.insert(texts.end(), {"64", "64x", "x64", "0x10", "16385x1", "16384x4097", "64X36", "64x36x2", "4.5x4"});
  return texts;
}

// A text for a value that is not the default.
inline std::string changed_text(const Setting& setting) {
  const std::string usual = value_text(setting.get(RenderSettings{}));
  for (const std::string& text : accepted_texts(setting.accepted))
    if (text != usual) return text;
  return usual;
}

}  // namespace nephele::test
