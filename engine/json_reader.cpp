#include "engine/json_reader.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "engine/check.h"

namespace nephele {
namespace {

using nlohmann::json;

// A value as an error line shows it: compact, escaped, cut short.
std::string shown(const json& value) {
  constexpr std::size_t kLongest = 60;
  if (value.is_object()) return "an object";
  if (value.is_array() && value.size() > 8) return "an array of " + std::to_string(value.size());
  std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
  return text;
}

std::string shown(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", number);
  return text;
}

// Follows the parser's events to find a key given twice in one object (the parser itself lets the last one win).
class RepeatedKeyFinder {
 public:
  bool operator()(int, json::parse_event_t event, json& parsed) {
    using Event = json::parse_event_t;
    if (event == Event::object_end || event == Event::array_end) {
      levels_.pop_back();
      return true;
    }
    if (event == Event::key) {
      Level& level = levels_.back();
      level.key = parsed.get<std::string>();
      if (!level.keys.insert(level.key).second && repeated_.empty()) repeated_ = path();
      return true;
    }
    if (!levels_.empty() && levels_.back().is_array) ++levels_.back().count;
    if (event != Event::value) levels_.push_back({.is_array = event == Event::array_start, .keys = {}, .key = {}});
    return true;
  }
  const std::string& repeated() const { return repeated_; }

 private:
  struct Level {
    bool is_array = false;
    std::set<std::string> keys;
    std::string key;
    std::size_t count = 0;
  };
  std::string path() const {
    std::string text;
    for (const Level& level : levels_)
      text += level.is_array ? '[' + std::to_string(level.count - 1) + ']' : (text.empty() ? "" : ".") + level.key;
    return text;
  }
  std::vector<Level> levels_;
  std::string repeated_;
};

// Input keys and library messages may hold anything; an error stays one printable line.
std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

}  // namespace

Result<std::string> read_text_file(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return Error{path + ": is a directory, not a file"};
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{path + ": can't be opened: " + std::strerror(errno)};
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) return Error{path + ": can't be read"};
  return text;
}

Result<json> parse_json(std::string_view text, const std::string& file) {
  RepeatedKeyFinder finder;
  try {
    json document = json::parse(text, std::ref(finder));
    if (!finder.repeated().empty()) return Error{one_line(file + ": key " + finder.repeated() + " is given twice")};
    return document;
  } catch (const json::exception& failure) {
    // "[json.exception.parse_error.101] parse error at line 1, ..." without the bracket.
    std::string reason = failure.what();
    if (const std::size_t bracket = reason.find("] "); bracket != std::string::npos) reason.erase(0, bracket + 2);
    return Error{one_line(file + ": not valid JSON: " + reason)};
  }
}

JsonObject JsonReader::root(const json& document) { return JsonObject(*this, document, ""); }

void JsonReader::fail(const std::string& message) {
  if (!error_) error_ = Error{one_line(file_ + ": " + message)};
}

JsonObject::JsonObject(JsonReader& reader, const json& value, std::string path)
    : reader_(reader), value_(value), path_(std::move(path)) {
  if (!value_.is_object()) complain(value_, path_.empty() ? "the document" : path_, "an object");
}

bool JsonObject::has(const char* key) const { return value_.is_object() && value_.contains(key); }

void JsonObject::require(const char* key) {
  if (value_.is_object() && !has(key)) reader_.fail(path_of(key) + " is missing");
}

const json* JsonObject::take(const char* key) {
  known_.emplace_back(key);
  if (reader_.error() || !has(key)) return nullptr;
  return &value_.at(key);
}

void JsonObject::complain(const json& value, const std::string& path, const std::string& accepted) {
  reader_.fail(path + " is " + shown(value) + "; accepted: " + accepted);
}

std::optional<double> JsonObject::checked_number(const json& value, const std::string& path, Range accepted) {
  if (value.is_number()) {
    const double number = value.get<double>();
    if (number >= accepted.minimum && number <= accepted.maximum) return number;
  }
  complain(value, path, "a number from " + shown(accepted.minimum) + " to " + shown(accepted.maximum));
  return std::nullopt;
}

bool JsonObject::check_array(const json& value, const std::string& path, int count) {
  if (value.is_array() && value.size() == static_cast<std::size_t>(count)) return true;
  complain(value, path, "an array of " + std::to_string(count) + " numbers");
  return false;
}

bool JsonObject::check_count(const json& value, const std::string& path, std::size_t maximum_count) {
  if (value.is_array() && value.size() <= maximum_count) return true;
  complain(value, path, "an array of at most " + std::to_string(maximum_count) + " objects");
  return false;
}

void JsonObject::boolean(const char* key, bool& value) {
  const json* found = take(key);
  if (!found) return;
  if (found->is_boolean())
    value = found->get<bool>();
  else
    complain(*found, path_of(key), "true or false");
}

void JsonObject::integer(const char* key, std::uint32_t& value, std::uint32_t minimum, std::uint32_t maximum) {
  const json* found = take(key);
  if (!found) return;
  if (found->is_number_unsigned() && found->get<std::uint64_t>() >= minimum && found->get<std::uint64_t>() <= maximum)
    value = found->get<std::uint32_t>();
  else
    complain(*found, path_of(key), "a whole number from " + std::to_string(minimum) + " to " + std::to_string(maximum));
}

void JsonObject::string(const char* key, std::string& value) {
  const json* found = take(key);
  if (!found) return;
  if (found->is_string() && !found->get_ref<const std::string&>().empty())
    value = found->get<std::string>();
  else
    complain(*found, path_of(key), "a text that is not empty");
}

void JsonObject::refuse(const char* key, const std::string& accepted) {
  if (const json* found = take(key)) complain(*found, path_of(key), accepted);
}

void JsonObject::finish() {
  if (reader_.error()) return;
  for (const auto& [key, value] : value_.items()) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    std::string accepted;
    for (const std::string& name : known_) accepted += (accepted.empty() ? "" : ", ") + name;
    reader_.fail("unknown key " + path_of(key) + "; accepted: " + accepted);
    return;
  }
}

}  // namespace nephele
