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

// Follows the parser's events to find a key given twice in one object (the parser itself lets the last one win). A walk
// of its own over a text that is known to be good: as a callback of the parser it would cost the square of an array's
// length, since the parser then goes through all earlier elements after each one.
class RepeatedKeyFinder final : public nlohmann::json_sax<json> {
 public:
  const std::string& repeated() const { return repeated_; }

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool start_object(std::size_t) override { return begin(false); }
  bool start_array(std::size_t) override { return begin(true); }
  bool end_object() override { return end(); }
  bool end_array() override { return end(); }
  bool key(string_t& name) override {
    Level& level = levels_.back();
    level.key = name;
    if (level.keys.insert(name).second) return true;
    repeated_ = path();
    return false;
  }
  bool parse_error(std::size_t, const std::string&, const json::exception&) override { return false; }

 private:
  struct Level {
    bool is_array = false;
    std::set<std::string> keys;
    std::string key;
    std::size_t count = 0;
  };
  bool value() {
    if (!levels_.empty() && levels_.back().is_array) ++levels_.back().count;
    return true;
  }
  bool begin(bool is_array) {
    value();
    levels_.push_back({.is_array = is_array, .keys = {}, .key = {}});
    return true;
  }
  bool end() {
    levels_.pop_back();
    return true;
  }
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
  const auto control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
  std::replace_if(text.begin(), text.end(), control, '?');
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

Result<void> check_json_text(std::string_view text, const std::string& file) {
  if (const std::size_t at = text.find('\0'); at != std::string_view::npos)
    return Error{one_line(concat(file, ": not valid JSON: byte ", at + 1, " is NUL"))};
  std::size_t depth = 0, line = 1;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') ++line;
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxJsonDepth)
        return Error{one_line(concat(file, ": line ", line, " is nested deeper than ", kMaxJsonDepth,
                                     " objects and arrays; accepted: at most ", kMaxJsonDepth))};
    } else if ((c == '}' || c == ']') && depth > 0) {
      --depth;
    }
  }
  return {};
}

Result<json> parse_json(std::string_view text, const std::string& file) {
  if (Result<void> ok = check_json_text(text, file); !ok) return ok.error();
  try {
    json document = json::parse(text);
    RepeatedKeyFinder finder;
    json::sax_parse(text, &finder);
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
  if (reader_.listing_) return required_.emplace_back(key), void();
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
  complain(value, path, words_for(accepted));
  return std::nullopt;
}

bool JsonObject::check_array(const json& value, const std::string& path, int count) {
  if (value.is_array() && value.size() == static_cast<std::size_t>(count)) return true;
  complain(value, path, "an array of " + std::to_string(count) + " numbers");
  return false;
}

bool JsonObject::check_count(const json& value, const std::string& path, std::size_t maximum_count) {
  if (value.is_array() && value.size() <= maximum_count) return true;
  complain(value, path, words_for_objects(maximum_count));
  return false;
}

void JsonObject::note(const char* key, JsonKey listed) {
  listed.path = path_of(key);
  listed.required = std::find(required_.begin(), required_.end(), key) != required_.end();
  if (listed.required) listed.default_value = "required";
  // A text's default is quoted, so these two words are never a value.
  if (listed.default_value != "none" && !listed.required) listed.default_json = json::parse(listed.default_value);
  reader_.listing_->push_back(std::move(listed));
}

void JsonObject::note_number(const char* key, Range accepted, const std::string& default_value) {
  note(key, {.accepted = words_for(accepted),
             .default_value = default_value,
             .kind = JsonKind::number,
             .ranges = {accepted}});
}

void JsonObject::note_vector(const char* key, int count, std::initializer_list<Range> accepted,
                             const std::string& default_value) {
  std::vector<Range> ranges = accepted;
  ranges.resize(static_cast<std::size_t>(count), *accepted.begin());
  note(key, {.accepted = words_for(count, accepted),
             .default_value = default_value,
             .kind = JsonKind::vector,
             .ranges = std::move(ranges)});
}

JsonKey JsonObject::listed_objects(std::size_t maximum_count) {
  return {.accepted = words_for_objects(maximum_count),
          .default_value = "none",
          .kind = JsonKind::objects,
          .ranges = {{0.0, static_cast<double>(maximum_count)}}};
}

std::string JsonObject::words_for(Range accepted) {
  return "a number from " + shown(accepted.minimum) + " to " + shown(accepted.maximum);
}

std::string JsonObject::words_for(int count, std::initializer_list<Range> accepted) {
  std::string text = std::to_string(count) + " numbers";
  const char* separator = accepted.size() == 1 ? ", each from " : ": from ";
  for (const Range& range : accepted) {
    text += separator + shown(range.minimum) + " to " + shown(range.maximum);
    separator = ", ";
  }
  return text;
}

std::string JsonObject::words_for_objects(std::size_t maximum_count) {
  return "an array of at most " + std::to_string(maximum_count) + " objects";
}

std::string JsonObject::number_text(double value, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

void JsonObject::refuse(const char* key, const std::string& accepted) {
  if (!reader_.listing_ && !reader_.error()) complain(value_.at(key), path_of(key), accepted);
}

void JsonObject::kind(const char* key, const Kinds& kinds) {
  require(key);
  std::string accepted;
  for (const auto& entry : kinds) accepted += (accepted.empty() ? "\"" : ", \"") + std::string(entry.first) + '"';
  if (reader_.listing_) {
    JsonKey listed{.accepted = accepted, .default_value = "none", .kind = JsonKind::choice};
    for (const auto& entry : kinds) listed.choices.emplace_back(entry.first);
    note(key, std::move(listed));
    for (const auto& [name, read] : kinds) {
      std::string inside = path_;  // "sources[]" becomes "sources[set]"
      inside.insert(inside.ends_with("[]") ? inside.size() - 1 : inside.size(), name);
      JsonObject child(reader_, value_, inside);
      read(child);
    }
    return;
  }
  const json* found = take(key);
  if (!found) return;
  for (const auto& [name, read] : kinds)
    if (*found == name) return read(*this);
  complain(*found, path_of(key), accepted);
}

void JsonObject::boolean(const char* key, bool& value) {
  if (reader_.listing_)
    return note(key,
                {.accepted = "true or false", .default_value = value ? "true" : "false", .kind = JsonKind::boolean});
  const json* found = take(key);
  if (!found) return;
  if (found->is_boolean())
    value = found->get<bool>();
  else
    complain(*found, path_of(key), "true or false");
}

void JsonObject::integer(const char* key, std::uint32_t& value, std::uint32_t minimum, std::uint32_t maximum) {
  const auto accepted = [&] {
    return "a whole number from " + std::to_string(minimum) + " to " + std::to_string(maximum);
  };
  if (reader_.listing_)
    return note(key, {.accepted = accepted(),
                      .default_value = std::to_string(value),
                      .kind = JsonKind::whole_number,
                      .ranges = {{static_cast<double>(minimum), static_cast<double>(maximum)}}});
  const json* found = take(key);
  if (!found) return;
  if (found->is_number_unsigned() && found->get<std::uint64_t>() >= minimum && found->get<std::uint64_t>() <= maximum)
    value = found->get<std::uint32_t>();
  else
    complain(*found, path_of(key), accepted());
}

void JsonObject::read_text(const char* key, std::string& value, JsonKind kind) {
  constexpr const char* kAccepted = "a text that is not empty";
  if (reader_.listing_)
    return note(key,
                {.accepted = kAccepted, .default_value = value.empty() ? "none" : json(value).dump(), .kind = kind});
  const json* found = take(key);
  if (!found) return;
  if (found->is_string() && !found->get_ref<const std::string&>().empty())
    value = found->get<std::string>();
  else
    complain(*found, path_of(key), kAccepted);
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
