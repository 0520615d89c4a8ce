// Tables of a document that list the keys of an input file, compared with what the file's reader accepts.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "engine/check.h"
#include "engine/json_reader.h"

namespace nephele::test {

// The cells of a Markdown table's row without the spaces around them; a backslash keeps a bar in its cell.
inline std::vector<std::string> cells_of(const std::string& row) {
  std::vector<std::string> cells(1);
  for (std::size_t i = 1; i < row.size(); ++i) {
    if (row[i] == '|')
      cells.emplace_back();
    else if (row[i] != '\\')
      cells.back() += row[i];
  }
  cells.pop_back();
  for (std::string& cell : cells) {
    cell.erase(0, cell.find_first_not_of(' '));
    cell.erase(cell.find_last_not_of(' ') + 1);
  }
  return cells;
}

// The unit that a key's name ends in, as the documents spell it.
inline std::string unit_of(const std::string& path) {
  using Pair = std::pair<const char*, const char*>;
  for (const auto& [ending, unit] : {Pair{"_m_per_s", "m/s"}, Pair{"_per_m", "1/m"}, Pair{"_m", "m"},
                                     Pair{"_deg", "degrees"}, Pair{"_s", "s"}, Pair{"_ev", "stops"}})
    if (path.ends_with(ending)) return unit;
  return "";
}

// Rows that begin with a key in backquotes.
inline std::vector<std::vector<std::string>> key_table_rows(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    if (line.starts_with("| `")) rows.push_back(cells_of(line));
    at = end + 1;
  }
  return rows;
}

// Key, meaning, unit, accepted, default: in the reader's order and words.
inline void check_key_table(const std::vector<std::vector<std::string>>& rows, const std::vector<JsonKey>& keys) {
  for (std::size_t i = 0; i < std::max(rows.size(), keys.size()); ++i) {
    REQUIRE_MESSAGE(i < rows.size(), "the document lacks ", keys[i].path);
    REQUIRE_MESSAGE(i < keys.size(), "no such key: ", rows[i][0]);
    CAPTURE(rows[i][0]);
    REQUIRE(rows[i].size() == 5);
    CHECK(rows[i][0] == concat('`', keys[i].path, '`'));
    CHECK_FALSE(rows[i][1].empty());
    if (const std::string unit = unit_of(keys[i].path); !unit.empty()) CHECK(rows[i][2] == unit);
    CHECK(rows[i][3] == keys[i].accepted);
    CHECK(rows[i][4] == keys[i].default_value);
  }
}

}  // namespace nephele::test
