// The reader of JSON inputs: texts that no parser should see, and the list of keys that a reading function accepts.
#include "engine/json_reader.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include "engine/scene.h"
#include "tests/support/key_table.h"
#include "tests/support/support.h"

using namespace nephele;

namespace {

enum class Pet { cat, dog };

struct Zoo {
  double angle_rad = 90.0 * kRadiansPerDegree;
  float share = 0.1f;
  glm::dvec2 place_m{1.5, -2.0};
  std::optional<glm::vec3> color;
  bool open = true;
  std::uint32_t count = 7;
  std::string name;
  Pet pet = Pet::dog;
  std::vector<float> ages;
};

void read_zoo(JsonObject& json, Zoo& zoo) {
  json.number("angle_deg", zoo.angle_rad, {-90, 90}, kRadiansPerDegree);
  json.number("share", zoo.share, {0, 1});
  json.vector("place_m", zoo.place_m, {Range{0, 1}, Range{-1e9, 1e9}});
  json.vector("color", zoo.color, {Range{0, 1}});
  json.boolean("open", zoo.open);
  json.integer("count", zoo.count, 1, 9);
  json.require("name");
  json.string("name", zoo.name);
  json.choice("pet", zoo.pet, {{"cat", Pet::cat}, {"dog", Pet::dog}});
  json.objects("visitors", 3, [&](JsonObject& child) {
    child.kind("kind", {{"child",
                         [&](JsonObject& own) {
                           own.number("age_years", zoo.ages.emplace_back(), {0, 17});
                         }},
                        {"adult", [&](JsonObject& own) { own.boolean("paid", zoo.open); }}});
  });
}

std::string nested(std::size_t arrays) { return std::string(arrays, '[') + std::string(arrays, ']'); }

std::string complaint(const std::string& text) {
  const Result<nlohmann::json> document = parse_json(text, "zoo.json");
  if (!document) return document.error().message;
  JsonReader reader("zoo.json");
  JsonObject root = reader.root(*document);
  Zoo zoo;
  read_zoo(root, zoo);
  root.finish();
  return reader.error() ? reader.error()->message : "accepted";
}

}  // namespace

TEST_CASE("JSON: nesting is accepted up to the limit and refused beyond it, however deep") {
  CHECK(parse_json(nested(kMaxJsonDepth), "a.json"));
  for (const std::size_t depth : {kMaxJsonDepth + 1, std::size_t{100000}, std::size_t{3000000}}) {
    const Result<nlohmann::json> parsed = parse_json(std::string("\n").append(nested(depth)), "a.json");
    REQUIRE_FALSE(parsed);
    CHECK(parsed.error().message == "a.json: line 2 is nested deeper than 64 objects and arrays; accepted: at most 64");
  }
  // Brackets in strings do not nest, and an escaped quote does not end a string.
  CHECK(parse_json(R"({"a": ")" + std::string(1000, '[') + R"(\"[[", "b": "\\"})", "a.json"));
  // Siblings do not nest either.
  std::string row = "[[]";
  for (int i = 0; i < 1000; ++i) row += ",{}";
  CHECK(parse_json(row + "]", "a.json"));
}

TEST_CASE("JSON: a NUL byte is an error wherever it stands; a byte order mark before the text is not") {
  using namespace std::string_literals;
  for (const std::string& text : {"{}\0"s, "{\"particles\":[]}\0{\"garbage"s, "\0{}"s, "{\"a\0b\": 1}"s}) {
    const Result<nlohmann::json> parsed = parse_json(text, "a.json");
    REQUIRE_FALSE(parsed);
    CHECK(parsed.error().message == "a.json: not valid JSON: byte " + std::to_string(text.find('\0') + 1) + " is NUL");
  }
  CHECK(parse_json("\xef\xbb\xbf{}", "a.json"));
}

TEST_CASE("JSON: objects whose keys depend on their kind") {
  CHECK(
      complaint(R"({"name": "x", "visitors": [{"kind": "child", "age_years": 3}, {"kind": "adult", "paid": true}]})") ==
      "accepted");
  CHECK(complaint(R"({"name": "x", "visitors": [{}]})") == "zoo.json: visitors[0].kind is missing");
  CHECK(complaint(R"({"name": "x", "visitors": [{"kind": "dog"}]})") ==
        "zoo.json: visitors[0].kind is \"dog\"; accepted: \"child\", \"adult\"");
  CHECK(complaint(R"({"name": "x", "visitors": [{"kind": "adult", "age_years": 3}]})") ==
        "zoo.json: unknown key visitors[0].age_years; accepted: kind, paid");
}

TEST_CASE("JSON: the list of a reading function's keys says what each accepts and its default") {
  const std::vector<JsonKey> keys = JsonReader::keys_of([](JsonObject& root) {
    Zoo zoo;
    read_zoo(root, zoo);
  });
  const std::vector<std::array<std::string, 3>> expected{
      {"angle_deg", "a number from -90 to 90", "90"},
      {"share", "a number from 0 to 1", "0.1"},
      {"place_m", "2 numbers: from 0 to 1, -1e+09 to 1e+09", "[1.5, -2]"},
      {"color", "3 numbers, each from 0 to 1", "none"},
      {"open", "true or false", "true"},
      {"count", "a whole number from 1 to 9", "7"},
      {"name", "a text that is not empty", "required"},
      {"pet", "\"cat\", \"dog\"", "\"dog\""},
      {"visitors", "an array of at most 3 objects", "none"},
      {"visitors[].kind", "\"child\", \"adult\"", "required"},
      {"visitors[child].age_years", "a number from 0 to 17", "0"},
      {"visitors[adult].paid", "true or false", "true"}};
  REQUIRE(keys.size() == expected.size());
  for (std::size_t i = 0; i < keys.size(); ++i)
    CHECK(std::array{keys[i].path, keys[i].accepted, keys[i].default_value} == expected[i]);
}

TEST_CASE("JSON: the list of keys says in values what it says in words") {
  const std::vector<JsonKey> keys = JsonReader::keys_of([](JsonObject& root) {
    Zoo zoo;
    read_zoo(root, zoo);
    std::string plan;
    root.file("plan", plan);
    root.object("gate", [](JsonObject&) {});
  });
  struct Expected {
    JsonKind kind;
    std::vector<Range> ranges;
    std::vector<std::string> choices;
    bool required;
    nlohmann::json default_json;
  };
  using enum JsonKind;
  const std::vector<Expected> expected{{number, {{-90, 90}}, {}, false, 90},
                                       {number, {{0, 1}}, {}, false, 0.1},
                                       {vector, {{0, 1}, {-1e9, 1e9}}, {}, false, {1.5, -2}},
                                       {vector, {{0, 1}, {0, 1}, {0, 1}}, {}, false, nullptr},
                                       {boolean, {}, {}, false, true},
                                       {whole_number, {{1, 9}}, {}, false, 7},
                                       {text, {}, {}, true, nullptr},
                                       {choice, {}, {"cat", "dog"}, false, "dog"},
                                       {objects, {{0, 3}}, {}, false, nullptr},
                                       {choice, {}, {"child", "adult"}, true, nullptr},
                                       {number, {{0, 17}}, {}, false, 0},
                                       {boolean, {}, {}, false, true},
                                       {file, {}, {}, false, nullptr},
                                       {object, {}, {}, false, nullptr}};
  REQUIRE(keys.size() == expected.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    CAPTURE(keys[i].path);
    CHECK(keys[i].kind == expected[i].kind);
    CHECK(keys[i].ranges == expected[i].ranges);
    CHECK(keys[i].choices == expected[i].choices);
    CHECK(keys[i].required == expected[i].required);
    CHECK(keys[i].default_json == expected[i].default_json);
  }
}

TEST_CASE("docs/scene_file.md: the tables of keys are the reader's own") {
  const auto rows = test::key_table_rows(test::read_file(std::string(NEPHELE_SOURCE_DIR) + "/docs/scene_file.md"));
  // Some sources have the keys of "clouds" or of "particles": the document refers to those, so they must be the same.
  std::vector<JsonKey> keys, repeated;
  for (JsonKey key : scene_keys()) {
    const std::string field = "sources[field].", listed = "sources[particles].particles[].", view = "views[].camera.";
    if (key.path.starts_with(field))
      repeated.push_back({"clouds." + key.path.substr(field.size()), key.accepted, key.default_value});
    else if (key.path.starts_with(listed))
      repeated.push_back({"particles[]." + key.path.substr(listed.size()), key.accepted, key.default_value});
    else if (key.path.starts_with(view))
      repeated.push_back({"camera." + key.path.substr(view.size()), key.accepted, key.default_value});
    else
      keys.push_back(std::move(key));
  }
  const auto count_of = [&](const std::string& prefix) {
    return std::count_if(keys.begin(), keys.end(), [&](const JsonKey& key) { return key.path.starts_with(prefix); });
  };
  CHECK(static_cast<std::size_t>(count_of("camera.") + count_of("clouds.") + count_of("particles[].")) ==
        repeated.size());
  for (const JsonKey& key : repeated) {
    CAPTURE(key.path);
    CHECK(std::any_of(keys.begin(), keys.end(), [&](const JsonKey& other) {
      return other.path == key.path && other.accepted == key.accepted && other.default_value == key.default_value;
    }));
  }
  test::check_key_table(rows, keys);
}

TEST_CASE("scene keys: each is listed once, and its default is itself a value that the reader accepts") {
  std::set<std::string> paths;
  for (const JsonKey& key : scene_keys()) {
    CAPTURE(key.path);
    CHECK(paths.insert(key.path).second);
    if (key.default_value == "none" || key.default_value == "required" || key.path.find('[') != std::string::npos)
      continue;
    std::string text = key.default_value, path = "." + key.path;
    for (std::size_t dot; (dot = path.rfind('.')) != std::string::npos; path.erase(dot))
      text = "{\"" + path.substr(dot + 1) + "\": " + text + "}";
    const Result<Scene> scene = parse_scene(text, "scene.json");
    CHECK_MESSAGE(scene, text);
  }
  CHECK(paths.size() > 30);
}

TEST_CASE("scene keys: kinds, ranges, choices and defaults are what the words say") {
  const auto shown = [](double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", number);
    return std::string(text);
  };
  const auto from_to = [&](const Range& range) { return shown(range.minimum) + " to " + shown(range.maximum); };
  const auto words_of = [&](const JsonKey& key) -> std::string {
    switch (key.kind) {
      case JsonKind::number:
        return "a number from " + from_to(key.ranges.at(0));
      case JsonKind::whole_number:
        return "a whole number from " + std::to_string(static_cast<std::uint64_t>(key.ranges.at(0).minimum)) + " to " +
               std::to_string(static_cast<std::uint64_t>(key.ranges.at(0).maximum));
      case JsonKind::vector: {
        const bool alike = std::all_of(key.ranges.begin(), key.ranges.end(),
                                       [&](const Range& range) { return range == key.ranges[0]; });
        std::string text = std::to_string(key.ranges.size()) + (alike ? " numbers, each from " : " numbers: from ");
        for (std::size_t i = 0; i < (alike ? 1 : key.ranges.size()); ++i)
          text += (i > 0 ? ", " : "") + from_to(key.ranges[i]);
        return text;
      }
      case JsonKind::boolean:
        return "true or false";
      case JsonKind::choice: {
        std::string text;
        for (const std::string& choice : key.choices) text += (text.empty() ? "\"" : ", \"") + choice + '"';
        return text;
      }
      case JsonKind::text:
      case JsonKind::file:
        return "a text that is not empty";
      case JsonKind::object:
        return "an object";
      case JsonKind::objects:
        return "an array of at most " + shown(key.ranges.at(0).maximum) + " objects";
    }
    return "";
  };
  for (const JsonKey& key : scene_keys()) {
    CAPTURE(key.path);
    CHECK(words_of(key) == key.accepted);
    CHECK(key.required == (key.default_value == "required"));
    CHECK(key.default_json.is_null() == (key.default_value == "none" || key.required));
    if (key.default_json.is_null()) continue;
    CHECK(nlohmann::json::parse(key.default_value) == key.default_json);
    // Whoever makes a slider of the range starts inside of it.
    const auto inside = [](const nlohmann::json& number, const Range& range) {
      return number.get<double>() >= range.minimum && number.get<double>() <= range.maximum;
    };
    if (key.kind == JsonKind::number || key.kind == JsonKind::whole_number)
      CHECK(inside(key.default_json, key.ranges.at(0)));
    if (key.kind != JsonKind::vector) continue;
    REQUIRE(key.default_json.size() == key.ranges.size());
    for (std::size_t i = 0; i < key.ranges.size(); ++i) CHECK(inside(key.default_json[i], key.ranges[i]));
  }
}
