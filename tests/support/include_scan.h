// The `#include "…"` lines of a source file, for tests of what includes what.
#pragma once

#include <regex>
#include <string>
#include <vector>

namespace nephele::test {

inline std::vector<std::string> quoted_includes(const std::string& text) {
  static const std::regex line("(?:^|\n)[ \t]*#[ \t]*include[ \t]*\"([^\"\n]+)\"");
  std::vector<std::string> names;
  for (std::sregex_iterator match(text.begin(), text.end(), line), end; match != end; ++match)
    names.push_back((*match)[1]);
  return names;
}

}  // namespace nephele::test
