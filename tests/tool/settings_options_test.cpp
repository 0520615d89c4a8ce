// Every setting of the table as a user meets it: in --help, on the command line, in a sweep, in the statistics.
#include <doctest/doctest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/support/setting_values.h"
#include "tests/support/support.h"
#include "tests/tool/program.h"

using namespace nephele;
using namespace nephele::test;
using nlohmann::json;

namespace {

// No such device: what is said about it is said after every option was accepted and before anything is rendered.
const std::vector<std::string> kNoDevice{"--device", "none of these"};

std::string refusal(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), kNoDevice.begin(), kNoDevice.end());
  const ProgramResult result = run_program(arguments);
  CHECK(result.status == 2);
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  return result.err;
}

bool accepted(const std::string& line) { return line.find("none of these") != std::string::npos; }

std::string write_sweep(const TempDirectory& directory, const json& settings) {
  write_file(directory / "scene.json", R"({"particles": []})");
  const json config{
      {"scenes", {{{"name", "s"}, {"file", "scene.json"}}}}, {"settings", settings}, {"series", {{{"name", "one"}}}}};
  write_file(directory / "config.json", config.dump());
  return directory / "config.json";
}

// As a configuration spells the value that a command line spells `text`.
json as_json(const Setting& setting, const std::string& text) {
  RenderSettings settings;
  REQUIRE(set_from_text(setting, settings, text, setting.key));
  const Value value = setting.get(settings);
  if (const bool* on = std::get_if<bool>(&value)) return *on;
  if (const auto* number = std::get_if<std::uint64_t>(&value)) return *number;
  if (const auto* number = std::get_if<double>(&value)) return *number;
  return value_text(value);
}

}  // namespace

TEST_CASE("settings: --help of each command that renders lists every setting") {
  for (const char* command : {"render", "reference", "sweep", "fly"}) {
    // The help of one option may be broken into lines.
    std::string help = run_program({command, "--help"}).out;
    help.erase(std::unique(help.begin(), help.end(), [](char a, char b) { return std::isspace(a) && std::isspace(b); }),
               help.end());
    std::replace(help.begin(), help.end(), '\n', ' ');
    for (const Setting& setting : all_settings()) {
      CAPTURE(command);
      CAPTURE(setting.key);
      CHECK(help.find(' ' + std::string(setting.option) + ' ' + placeholder(setting.accepted)) != std::string::npos);
      CHECK(help.find(setting.help) != std::string::npos);
      if (std::holds_alternative<WholeNumber>(setting.accepted))
        CHECK(help.find(accepted_words(setting.accepted)) != std::string::npos);
    }
  }
}

TEST_CASE("settings: each one is an option of render, reference and sweep") {
  const TempDirectory directory;
  const std::string config = write_sweep(directory, json::object());
  std::vector<std::string> typed;
  for (const Setting& setting : all_settings()) typed.insert(typed.end(), {setting.option, changed_text(setting)});
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"render", "--out", directory / "x.png"},
        {"reference", "--out", directory / "x.exr", "--scene", directory / "scene.json", "--tables", small_tables()},
        {"sweep", "--config", config, "--out", directory / "sweep"}}) {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), typed.begin(), typed.end());
    const std::string line = refusal(arguments);
    CHECK_MESSAGE(accepted(line), line);
  }
}

TEST_CASE("settings: a sweep has each as a key, and refuses a value in the words of the command line") {
  const TempDirectory directory;
  const auto sweep = [&](const json& settings) {
    return refusal({"sweep", "--config", write_sweep(directory, settings), "--out", directory / "sweep"});
  };
  json all = json::object();
  for (const Setting& setting : all_settings()) all[setting.key] = as_json(setting, changed_text(setting));
  const std::string line = sweep(all);
  CHECK_MESSAGE(accepted(line), line);
  for (const Setting& setting : all_settings()) {
    CAPTURE(setting.key);
    const std::string words = "; accepted: " + accepted_words(setting.accepted);
    const std::string in_sweep = sweep({{setting.key, "surely not"}});
    CHECK(in_sweep.find("settings." + std::string(setting.key) + " is \"surely not\"" + words) != std::string::npos);
    const std::string typed = refusal({"render", "--out", directory / "x.png", setting.option, "surely not"});
    CHECK(typed.find(std::string(setting.option) + " is \"surely not\"" + words) != std::string::npos);
  }
  // A number is not the text that spells one.
  CHECK(sweep({{"steps", "64"}}).find("settings.steps is \"64\"; accepted: a whole number") != std::string::npos);
  CHECK(sweep({{"reuse", 1}}).find("settings.reuse is 1; accepted: on or off") != std::string::npos);
}

TEST_CASE("settings: a toggle's name alone turns it on, and may be followed by on or off") {
  const TempDirectory directory;
  const auto reuse = [&](std::vector<std::string> typed) {
    std::vector<std::string> arguments{
        "render",   "--size",      "8x8", "--stats", directory / "stats.json", "--scene", directory / "scene.json",
        "--tables", small_tables()};
    arguments.insert(arguments.end(), typed.begin(), typed.end());
    const ProgramResult result = run_program(arguments);
    REQUIRE_MESSAGE(result.status == 0, result.err);
    return json::parse(read_file(directory / "stats.json")).at("settings").at("reuse").get<bool>();
  };
  write_file(directory / "scene.json", R"({"particles": []})");
  CHECK_FALSE(reuse({}));
  CHECK(reuse({"--reuse"}));
  CHECK(reuse({"--reuse", "--quiet"}));
  CHECK(reuse({"--reuse", "on"}));
  CHECK(reuse({"--reuse=true"}));
  CHECK_FALSE(reuse({"--reuse", "off"}));
  CHECK_FALSE(reuse({"--reuse", "--reuse=off"}));
}

TEST_CASE("settings: a larger crown factor makes more particles of the same clouds") {
  const TempDirectory directory;
  write_file(directory / "scene.json", R"({"clouds": {"view_distance_m": 5000}})");
  const auto particles = [&](const char* factor) {
    const ProgramResult result =
        run_program({"render", "--scene", directory / "scene.json", "--size", "8x8", "--quality", "low", "--stats",
                     directory / "stats.json", "--tables", small_tables(), "--crown-factor", factor});
    REQUIRE_MESSAGE(result.status == 0, result.err);
    const json stats = json::parse(read_file(directory / "stats.json"));
    for (const auto& [buffer, lost] : stats.at("overflow").items()) CHECK_MESSAGE(lost == 0, buffer);
    return stats.at("particles_generated").get<double>();
  };
  CHECK(particles("4") > 1.5 * particles("0.25"));
}

TEST_CASE("settings: the statistics tell every setting as it was asked for") {
  const TempDirectory directory;
  write_file(directory / "scene.json", R"({"particles": []})");
  std::vector<std::string> arguments{
      "render", "--scene", directory / "scene.json", "--stats", directory / "s.json", "--tables", small_tables()};
  json expected = json::object();
  for (const Setting& setting : all_settings()) {
    const std::string key = setting.key;
    // Software devices lack the second backend of the list; a march has no use for it.
    const std::string text = key == "backend" ? "tiled" : changed_text(setting);
    arguments.insert(arguments.end(), {setting.option, key == "resolution" ? "8x9" : text});
    expected[key] = as_json(setting, key == "resolution" ? "8x9" : text);
  }
  const ProgramResult result = run_program(arguments);
  REQUIRE_MESSAGE(result.status == 0, result.err);
  CHECK(json::parse(read_file(directory / "s.json")).at("settings") == expected);
}
