// Strict reading of small JSON input files: every key that is there must be known, well typed and in range. The
// first complaint wins and is one line: file, key path, value, what is accepted.
//
//   JsonReader reader("scene.json");
//   JsonObject root = reader.root(document);
//   root.number("exposure_ev", scene.exposure_ev, {-32, 32});
//   root.finish();
//   if (reader.error()) return *reader.error();
#pragma once

#include <cmath>
#include <cstdint>
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

// Syntax, repeated keys and numbers beyond double's range are errors.
Result<nlohmann::json> parse_json(std::string_view text, const std::string& file);

struct Range {
  double minimum, maximum;
};

inline constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

class JsonObject;

class JsonReader {
 public:
  explicit JsonReader(std::string file) : file_(std::move(file)) {}
  JsonObject root(const nlohmann::json& document);
  const std::optional<Error>& error() const { return error_; }
  // Records "<file>: <message>" unless there is an earlier error.
  void fail(const std::string& message);

 private:
  std::string file_;
  std::optional<Error> error_;
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
    if (const nlohmann::json* found = take(key)) read_number(*found, path_of(key), value, accepted, unit);
  }
  // Exactly N numbers; one range for all of them, or one each.
  template <glm::length_t N, class Real>
  void vector(const char* key, glm::vec<N, Real>& value, std::initializer_list<Range> accepted) {
    const nlohmann::json* found = take(key);
    if (!found || !check_array(*found, path_of(key), N)) return;
    for (glm::length_t i = 0; i < N; ++i)
      read_number((*found)[static_cast<std::size_t>(i)], path_of(key) + '[' + std::to_string(i) + ']', value[i],
                  accepted.begin()[accepted.size() == 1 ? 0 : i], 1.0);
  }
  void boolean(const char* key, bool& value);
  void integer(const char* key, std::uint32_t& value, std::uint32_t minimum = 0,
               std::uint32_t maximum = std::numeric_limits<std::uint32_t>::max());
  // Not empty.
  void string(const char* key, std::string& value);
  template <class Enum>
  void choice(const char* key, Enum& value, std::initializer_list<std::pair<const char*, Enum>> names) {
    const nlohmann::json* found = take(key);
    if (!found) return;
    std::string accepted;
    for (const auto& [name, meaning] : names) {
      if (*found == name) {
        value = meaning;
        return;
      }
      accepted += (accepted.empty() ? "\"" : ", \"") + std::string(name) + '"';
    }
    complain(*found, path_of(key), accepted);
  }
  // Calls read(JsonObject&) on the object at the key, then checks for unknown keys in it.
  template <class Read>
  void object(const char* key, Read&& read) {
    if (const nlohmann::json* found = take(key)) read_object(*found, path_of(key), read);
  }
  // Calls read(JsonObject&) on each object of the array.
  template <class Read>
  void objects(const char* key, std::size_t maximum_count, Read&& read) {
    const nlohmann::json* found = take(key);
    if (!found || !check_count(*found, path_of(key), maximum_count)) return;
    for (std::size_t i = 0; i < found->size(); ++i)
      read_object((*found)[i], path_of(key) + '[' + std::to_string(i) + ']', read);
  }
  // Complains about the value at a key that was read well but does not fit the rest.
  void refuse(const char* key, const std::string& accepted);
  // The value as it stands, to be read by the caller; null when absent.
  const nlohmann::json* value(const char* key) { return take(key); }
  // Unknown keys are errors. Call once, after everything has been read.
  void finish();

  std::string path_of(const std::string& key) const { return path_.empty() ? key : path_ + '.' + key; }

 private:
  const nlohmann::json* take(const char* key);
  void complain(const nlohmann::json& value, const std::string& path, const std::string& accepted);
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

  JsonReader& reader_;
  const nlohmann::json& value_;
  std::string path_;
  std::vector<std::string> known_;
};

}  // namespace nephele
