// Strict reading of small JSON input files: every key that is there must be known, well typed and in range. The
// first complaint wins and is one line: file, key path, value, what is accepted.
//
//   JsonReader reader("scene.json");
//   JsonObject root = reader.root(document);
//   root.number("exposure_ev", scene.exposure_ev, {-32, 32});
//   root.finish();
//   if (reader.error()) return *reader.error();
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/result.h"

namespace nephele {

Result<std::string> read_text_file(const std::string& path);

inline constexpr std::size_t kMaxJsonDepth = 64;  // objects and arrays inside one another

// Refused before any parser sees the text: a NUL byte, which would end it early, and nesting deeper than kMaxJsonDepth,
// which would exhaust the stack of whatever walks the document.
Result<void> check_json_text(std::string_view text, const std::string& file);

// Syntax, repeated keys and numbers beyond double's range are errors, and what check_json_text refuses.
Result<nlohmann::json> parse_json(std::string_view text, const std::string& file);

struct Range {
  double minimum, maximum;

  bool operator==(const Range&) const = default;
};

inline constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

// What stands at a key.
enum class JsonKind : std::uint8_t {
  number,
  whole_number,
  vector,  // an array of numbers, always as many
  boolean,
  choice,   // one of a few texts
  text,     // not empty
  file,     // a text that names a file, relative to the one that is read
  object,   // with keys of its own
  objects,  // an array of them
};

// A key that a reading function accepts, as the function's own calls state it: in words, and so that a program can make
// a panel of it.
struct JsonKey {
  std::string path;           // "camera.yaw_deg"; "particles[].density": in every object of an array
  std::string accepted;       // worded as in an error line: "a number from 0 to 1"
  std::string default_value;  // what holds where the key is absent, as JSON; "none", or "required"
  JsonKind kind = JsonKind::object;
  // In the file's unit, ends included. number, whole_number: one; vector: one for each of its numbers; objects: one,
  // for how many of them there may be.
  std::vector<Range> ranges;
  std::vector<std::string> choices;  // of a choice
  bool required = false;             // a file without the key is refused
  // What holds where the key is absent. Null where that is nothing: of a required key, of one that may have no value,
  // and of objects, whose keys have defaults of their own.
  nlohmann::json default_json;
};

class JsonObject;

class JsonReader {
 public:
  explicit JsonReader(std::string file) : file_(std::move(file)) {}
  JsonObject root(const nlohmann::json& document);
  const std::optional<Error>& error() const { return error_; }
  // Records "<file>: <message>" unless there is an earlier error.
  void fail(const std::string& message);

  // Every key that read(JsonObject&) asks for, in its order. The function runs once, on an empty document, in which
  // every object that it asks for is there and empty, and every array of objects holds one.
  template <class Read>
  static std::vector<JsonKey> keys_of(Read&& read);

 private:
  friend class JsonObject;
  std::string file_;
  std::optional<Error> error_;
  std::vector<JsonKey>* listing_ = nullptr;  // where keys_of wants the keys noted
};

// One object of the document. Reading an absent key leaves the value alone; after the reader's first error all
// further calls do nothing.
class JsonObject {
 public:
  JsonObject(JsonReader& reader, const nlohmann::json& value, std::string path);

  bool has(const char* key) const;
  void require(const char* key);

  // unit: what one unit of the file is in the program, e.g. kRadiansPerDegree. The range is in the file's unit.
  template <class Real>
  void number(const char* key, Real& value, Range accepted, double unit = 1.0) {
    if (reader_.listing_) return note_number(key, accepted, number_text<Real>(value / unit));
    if (const nlohmann::json* found = take(key)) read_number(*found, path_of(key), value, accepted, unit);
  }
  // A number that may be absent: its default is none.
  template <class Real>
  void number(const char* key, std::optional<Real>& value, Range accepted, double unit = 1.0) {
    if (reader_.listing_) return note_number(key, accepted, "none");
    if (has(key))
      number(key, value.emplace(), accepted, unit);
    else
      known_.emplace_back(key);
  }
  // Exactly N numbers; one range for all of them, or one each.
  template <glm::length_t N, class Real>
  void vector(const char* key, glm::vec<N, Real>& value, std::initializer_list<Range> accepted) {
    if (reader_.listing_) return note_vector(key, N, accepted, vector_text(value));
    const nlohmann::json* found = take(key);
    if (!found || !check_array(*found, path_of(key), N)) return;
    for (glm::length_t i = 0; i < N; ++i)
      read_number((*found)[static_cast<std::size_t>(i)], path_of(key) + '[' + std::to_string(i) + ']', value[i],
                  accepted.begin()[accepted.size() == 1 ? 0 : i], 1.0);
  }
  // A vector that may be absent: its default is none.
  template <glm::length_t N, class Real>
  void vector(const char* key, std::optional<glm::vec<N, Real>>& value, std::initializer_list<Range> accepted) {
    if (reader_.listing_) return note_vector(key, N, accepted, "none");
    if (has(key))
      vector(key, value.emplace(Real{0}), accepted);
    else
      known_.emplace_back(key);
  }
  // Exactly N numbers that may be absent: their default is none.
  template <std::size_t N>
  void numbers(const char* key, std::optional<std::array<double, N>>& values, Range accepted) {
    if (reader_.listing_) return note_vector(key, static_cast<int>(N), {accepted}, "none");
    const nlohmann::json* found = take(key);
    if (!found || !check_array(*found, path_of(key), static_cast<int>(N))) return;
    values.emplace();
    for (std::size_t i = 0; i < N; ++i)
      read_number((*found)[i], path_of(key) + '[' + std::to_string(i) + ']', (*values)[i], accepted, 1.0);
  }
  // Three numbers, or one that stands for all of them. Listed as three.
  void radii(const char* key, glm::vec3& value, Range accepted) {
    const bool one = !reader_.listing_ && has(key) && value_.at(key).is_number();
    if (!one) return vector(key, value, {accepted});
    number(key, value.x, accepted);
    value = glm::vec3(value.x);
  }
  void boolean(const char* key, bool& value);
  void integer(const char* key, std::uint32_t& value, std::uint32_t minimum = 0,
               std::uint32_t maximum = std::numeric_limits<std::uint32_t>::max());
  // Not empty.
  void string(const char* key, std::string& value) { read_text(key, value, JsonKind::text); }
  // The name of a file, not empty: read as a text, listed as a file.
  void file(const char* key, std::string& value) { read_text(key, value, JsonKind::file); }
  template <class Enum>
  void choice(const char* key, Enum& value, std::initializer_list<std::pair<const char*, Enum>> names) {
    const auto accepted = [&names] {
      std::string text;
      for (const auto& entry : names) text += (text.empty() ? "\"" : ", \"") + std::string(entry.first) + '"';
      return text;
    };
    if (reader_.listing_) {
      JsonKey listed{.accepted = accepted(), .default_value = "none", .kind = JsonKind::choice};
      for (const auto& [name, meaning] : names) {
        listed.choices.emplace_back(name);
        if (meaning == value) listed.default_value = '"' + std::string(name) + '"';
      }
      return note(key, std::move(listed));
    }
    const nlohmann::json* found = take(key);
    if (!found) return;
    for (const auto& [name, meaning] : names) {
      if (*found != name) continue;
      value = meaning;
      return;
    }
    complain(*found, path_of(key), accepted());
  }
  // Calls read(JsonObject&) on the object at the key, then checks for unknown keys in it.
  template <class Read>
  void object(const char* key, Read&& read) {
    if (reader_.listing_)
      return list_object(key, {.accepted = "an object", .default_value = "none", .kind = JsonKind::object}, "", read);
    if (const nlohmann::json* found = take(key)) read_object(*found, path_of(key), read);
  }
  // Calls read(JsonObject&) on each object of the array.
  template <class Read>
  void objects(const char* key, std::size_t maximum_count, Read&& read) {
    if (reader_.listing_) return list_object(key, listed_objects(maximum_count), "[]", read);
    const nlohmann::json* found = take(key);
    if (!found || !check_count(*found, path_of(key), maximum_count)) return;
    for (std::size_t i = 0; i < found->size(); ++i)
      read_object((*found)[i], path_of(key) + '[' + std::to_string(i) + ']', read);
  }
  // For objects whose other keys depend on this one, which is required: calls the function that has the key's name.
  using Kinds = std::initializer_list<std::pair<const char*, std::function<void(JsonObject&)>>>;
  void kind(const char* key, const Kinds& kinds);
  // The value as it stands, to be read by the caller; null when absent.
  const nlohmann::json* value(const char* key) { return take(key); }
  // Complains about the value at a key that was read well but does not fit the rest.
  void refuse(const char* key, const std::string& accepted);
  // Records what is wrong with the key beyond its value.
  void fail(const char* key, const std::string& what) { reader_.fail(path_of(key) + ' ' + what); }
  // Records "<path> is <value>; accepted: <accepted>".
  void complain(const nlohmann::json& value, const std::string& path, const std::string& accepted);
  // Unknown keys are errors. Call once, after everything has been read.
  void finish();

  std::string path_of(const std::string& key) const { return path_.empty() ? key : path_ + '.' + key; }

 private:
  const nlohmann::json* take(const char* key);
  // Lists the key: fills in its path, whether it is required, and its default as JSON.
  void note(const char* key, JsonKey listed);
  void note_number(const char* key, Range accepted, const std::string& default_value);
  void note_vector(const char* key, int count, std::initializer_list<Range> accepted, const std::string& default_value);
  static JsonKey listed_objects(std::size_t maximum_count);
  void read_text(const char* key, std::string& value, JsonKind kind);
  static std::string words_for(Range accepted);
  static std::string words_for(int count, std::initializer_list<Range> accepted);
  static std::string words_for_objects(std::size_t maximum_count);
  static std::string number_text(double value, int digits);
  // As a person would write the number: the digits that its type keeps.
  template <class Real>
  static std::string number_text(double value) {
    return number_text(value, std::numeric_limits<Real>::digits10);
  }
  template <glm::length_t N, class Real>
  static std::string vector_text(const glm::vec<N, Real>& value) {
    std::string text;
    for (glm::length_t i = 0; i < N; ++i) text += (i ? ", " : "[") + number_text<Real>(value[i]);
    return text + ']';
  }
  bool check_array(const nlohmann::json& value, const std::string& path, int count);
  bool check_count(const nlohmann::json& value, const std::string& path, std::size_t maximum_count);
  std::optional<double> checked_number(const nlohmann::json& value, const std::string& path, Range accepted);

  template <class Real>
  void read_number(const nlohmann::json& value, const std::string& path, Real& out, Range accepted, double unit) {
    if (const std::optional<double> number = checked_number(value, path, accepted))
      out = static_cast<Real>(*number * unit);
  }
  template <class Read>
  void read_object(const nlohmann::json& value, std::string path, Read& read) {
    if (reader_.error()) return;
    JsonObject child(reader_, value, std::move(path));
    read(child);
    child.finish();
  }

  template <class Read>
  void list_object(const char* key, JsonKey listed, const char* inside, Read& read) {
    note(key, std::move(listed));
    JsonObject child(reader_, value_, path_of(key) + inside);
    read(child);
  }

  JsonReader& reader_;
  const nlohmann::json& value_;
  std::string path_;
  std::vector<std::string> known_, required_;
};

template <class Read>
std::vector<JsonKey> JsonReader::keys_of(Read&& read) {
  std::vector<JsonKey> keys;
  JsonReader reader("");
  reader.listing_ = &keys;
  const nlohmann::json nothing = nlohmann::json::object();
  JsonObject root = reader.root(nothing);
  read(root);
  return keys;
}

}  // namespace nephele
