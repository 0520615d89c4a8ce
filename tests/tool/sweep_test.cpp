// nephele sweep as a user runs it: results, going on after a kill, comparison with an earlier run, bad configurations.
#include <doctest/doctest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/image_io.h"
#include "tests/support/support.h"
#include "tests/tool/program.h"

using namespace nephele::test;
using nlohmann::json;

namespace {

constexpr const char* kScene =
    R"({"particles": [{"center_m": [0, 400, 0], "radius_m": [150, 150, 100]}], "camera": {"position_m": [0, 0, 0]}})";

// Six small pictures of one particle.
json tiny_config() {
  return json::parse(R"({
    "scenes": [{"name": "one", "file": "scene.json"}],
    "settings": {"resolution": "16x12", "quality": "low"},
    "series": [{"name": "volume", "axes": {"scale": [1, 2]}}, {"name": "exact", "settings": {"blend": "exact"}},
               {"name": "march", "settings": {"method": "raymarch"}, "axes": {"steps": [16, 256]}},
               {"name": "near", "axes": {"scene.sun.elevation_deg": [20]}}],
    "reference": {"blend": "exact", "quality": "low"}, "warmup_frames": 1, "frames": 2, "repetitions": 3})");
}

class SweepDirectory {
 public:
  explicit SweepDirectory(const json& config = tiny_config()) {
    write_file(directory_ / "scene.json", kScene);
    write(config);
  }
  void write(const json& config) const { write_file(directory_ / "config.json", config.dump()); }
  ProgramResult run(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"sweep", "--config", directory_ / "config.json", "--out", directory_ / "out"});
    return run_program(more);
  }
  json results() const { return json::parse(read_file(directory_ / "out/results.json")); }
  std::string operator/(const std::string& name) const { return directory_ / name; }

 private:
  TempDirectory directory_;
};

std::size_t count_lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace

TEST_CASE("sweep: results of every variant, in three forms and a script of plots") {
  const SweepDirectory sweep;
  const ProgramResult result = sweep.run();
  REQUIRE_MESSAGE(result.status == 0, result.err);
  CHECK(result.out.empty());
  const json results = sweep.results();
  for (const char* key : {"sweep", "commit", "device", "driver", "processors"})
    CHECK_MESSAGE(results.at("identity").contains(key), key);
  const json& variants = results.at("variants");
  REQUIRE(variants.size() == 6);
  CHECK(variants[1].at("name") == "one volume scale=2");
  CHECK(variants[5].at("settings").at("scene").at("sun").at("elevation_deg") == 20);
  for (const json& variant : variants) {
    CAPTURE(variant.at("name"));
    CHECK(variant.at("repetition_ms").size() == 3);
    CHECK(variant.at("frame_ms").at("min") > 0);
    CHECK(variant["frame_ms"]["min"] <= variant["frame_ms"].at("median"));
    CHECK(variant["frame_ms"]["median"] <= variant["frame_ms"].at("p95"));
    CHECK(variant.at("ratio").at("low") <= variant["ratio"].at("high"));
    CHECK(variant.at("passes").size() > 5);
    CHECK(variant.at("particles_visible") == 1);
    CHECK(variant.at("gpu_memory_bytes") > 0);
    CHECK(variant.at("overflow") == 0);
  }
  CHECK(variants[0].at("ratio") == json{{"median", 1.0}, {"low", 1.0}, {"high", 1.0}});
  // The reference is the exact blend at full resolution: one particle alone is the same to both blends, but not to
  // scale 2.
  CHECK(variants[2].at("errors").at("relmse") == 0);
  CHECK(variants[0].at("errors").at("relmse") < 1e-6);
  CHECK(variants[1].at("errors").at("relmse") > 1e-6);
  CHECK(std::any_of(variants.begin(), variants.end(), [](const json& v) { return v.at("pareto") == true; }));

  const std::string csv = read_file(sweep / "out/results.csv");
  CHECK(count_lines(csv) == 7);
  CHECK(csv.find("shade_blend_ms") != std::string::npos);
  CHECK(read_file(sweep / "out/results.md").find("| exact |") != std::string::npos);
  CHECK(read_file(sweep / "out/plots.gp").find("error_one") != std::string::npos);
}

TEST_CASE("sweep: goes on after a kill, from what had been measured") {
  const SweepDirectory sweep;
  REQUIRE(sweep.run().status == 0);
  const std::string record_path = sweep / "out/measurements.jsonl", record = read_file(record_path);
  CHECK(count_lines(record) == 1 + 6 * 3);
  CHECK(sweep.run().status == 0);
  CHECK(read_file(record_path) == record);  // nothing is measured twice

  // As a kill leaves it: in the middle of the sixth measurement's line.
  std::size_t torn = 0;
  for (int line = 0; line < 6; ++line) torn = record.find('\n', torn) + 1;
  write_file(record_path, record.substr(0, torn + 40));
  const ProgramResult result = sweep.run();
  REQUIRE_MESSAGE(result.status == 0, result.err);
  const std::string resumed = read_file(record_path);
  CHECK(resumed.substr(0, torn) == record.substr(0, torn));
  CHECK(count_lines(resumed) == count_lines(record));
  const json results = sweep.results();
  for (const json& variant : results.at("variants")) CHECK(variant.at("repetition_ms").size() == 3);
}

TEST_CASE("sweep: frames with nothing to do again are measured too, and read back") {
  json config = tiny_config();
  config["series"] = {{{"name", "still"}, {"axes", {{"reuse", {true, false}}}}}};
  const SweepDirectory sweep(config);
  for (int run = 0; run < 2; ++run) {
    const ProgramResult result = sweep.run();
    REQUIRE_MESSAGE(result.status == 0, result.err);
  }
  const json variants = sweep.results().at("variants");
  CHECK(variants[0].at("name") == "one still reuse=true");
  CHECK(variants[0].at("passes").empty());
  CHECK(variants[1].at("passes").size() > 5);
  CHECK(variants[0].at("errors") == variants[1].at("errors"));
}

TEST_CASE("sweep: settings of the command line take the place of the file's common ones") {
  const SweepDirectory sweep;
  const ProgramResult result = sweep.run({"--size", "8x6", "--culling", "off"});
  REQUIRE_MESSAGE(result.status == 0, result.err);
  const json variants = sweep.results().at("variants");
  for (const json& variant : variants) {
    CHECK(variant.at("settings").at("resolution") == "8x6");
    CHECK(variant.at("settings").at("quality") == "low");
    CHECK(variant.at("settings").at("culling") == false);
  }
}

TEST_CASE("sweep: --compare matches results that were written before a setting was there") {
  const SweepDirectory sweep;
  REQUIRE(sweep.run().status == 0);
  json old = sweep.results();
  for (json& variant : old["variants"]) {
    variant["key"] = "of another version";
    for (const char* key : {"culling", "full_layer", "reuse"}) variant["settings"].erase(key);
  }
  write_file(sweep / "old.json", old.dump());
  CHECK(sweep.run({"--compare", sweep / "old.json"}).out.find("6 of 6 ratios agree") != std::string::npos);
  for (json& variant : old["variants"]) variant["settings"]["culling"] = false;
  write_file(sweep / "old.json", old.dump());
  CHECK(sweep.run({"--compare", sweep / "old.json"}).err.find("no variant of this sweep") != std::string::npos);
}

TEST_CASE("sweep: the record of another sweep is refused and left alone") {
  const SweepDirectory sweep;
  REQUIRE(sweep.run().status == 0);
  const std::string record = read_file(sweep / "out/measurements.jsonl");
  json other = tiny_config();
  other["frames"] = 1;
  sweep.write(other);
  const ProgramResult result = sweep.run();
  CHECK(result.status == 2);
  CHECK(result.err.find("another sweep") != std::string::npos);
  CHECK(count_lines(result.err) == 1);
  CHECK(read_file(sweep / "out/measurements.jsonl") == record);
}

TEST_CASE("sweep: another weather map under the same name makes another sweep") {
  const SweepDirectory sweep;
  write_file(sweep / "scene.json", R"({"clouds": {"coverage": 0, "view_distance_m": 100, "weather_map":
      {"file": "map.png", "origin_m": [0, 0], "extent_m": [100, 100]}}})");
  REQUIRE(nephele::write_png(sweep / "map.png", 1, 1, std::vector<std::uint8_t>{9, 9, 9, 255}));
  REQUIRE(sweep.run().status == 0);
  REQUIRE(nephele::write_png(sweep / "map.png", 1, 1, std::vector<std::uint8_t>{10, 9, 9, 255}));
  const ProgramResult result = sweep.run();
  CHECK(result.status == 2);
  CHECK(result.err.find("another sweep") != std::string::npos);
}

TEST_CASE("sweep: --compare passes against itself and fails past the stated slowdown") {
  const SweepDirectory sweep;
  REQUIRE(sweep.run().status == 0);
  const ProgramResult same = sweep.run({"--compare", sweep / "out/results.json"});
  CHECK(same.status == 0);
  CHECK(same.out.find("6 of 6 ratios agree") != std::string::npos);

  // As if everything had been three times faster and one ratio another.
  json faster = sweep.results();
  for (json& variant : faster["variants"])
    for (const char* key : {"median", "low", "high"}) variant["ms"][key] = variant["ms"]["low"].get<double>() / 3;
  for (const char* key : {"median", "low", "high"}) faster["variants"][1]["ratio"][key] = 1000;
  write_file(sweep / "faster.json", faster.dump());
  const ProgramResult slower = sweep.run({"--compare", sweep / "faster.json"});
  CHECK(slower.status != 0);
  CHECK(slower.err.find("6 of 6 variants are slower than 1.1 times") != std::string::npos);
  CHECK(slower.out.find("SLOWER") != std::string::npos);
  CHECK(slower.out.find("5 of 6 ratios agree") != std::string::npos);
  CHECK(sweep.run({"--compare", sweep / "faster.json", "--slowdown", "100"}).status == 0);
  CHECK(sweep.run({"--compare", sweep / "scene.json"}).err.find("not the results.json") != std::string::npos);
}

TEST_CASE("sweep: bad configurations are refused in one line that names the key and what is accepted") {
  SweepDirectory sweep;
  const auto refuse = [&](const char* pointer, const json& value, const std::vector<std::string>& mentions) {
    json config = tiny_config();
    config[json::json_pointer(pointer)] = value;
    sweep.write(config);
    const ProgramResult result = sweep.run();
    CAPTURE(config.dump());
    CAPTURE(result.err);
    CHECK(result.status == 2);
    CHECK(count_lines(result.err) == 1);
    for (const std::string& mention : mentions) CHECK_MESSAGE(result.err.find(mention) != std::string::npos, mention);
  };
  refuse("/speed", 1, {"unknown key speed", "repetitions"});
  refuse("/repetitions", 0, {"repetitions is 0", "1 to 1000"});
  refuse("/frames", 2.5, {"frames is 2.5", "1 to 1000"});
  refuse("/warmup_frames", 0, {"warmup_frames is 0", "1 to 100"});
  refuse("/scenes", json::array(), {"scenes", "at least one"});
  refuse("/series", json::array(), {"series", "at least one"});
  refuse("/scenes/0/name", "", {"scenes[0].name"});
  refuse("/scenes/0/file", "none.json", {"none.json", "can't be opened"});
  refuse("/scenes/0/reference", "none.exr", {"none.exr"});
  refuse("/settings/quality", "ultra", {"settings.quality", "ultra", "low, medium or high"});
  refuse("/settings/resolution", "16", {"settings.resolution", "WIDTHxHEIGHT"});
  refuse("/settings/ring_size_cells", 100, {"settings.ring_size_cells is 100", "multiple of 8 from 40 to 256"});
  refuse("/settings/method", "rasterize", {"settings.method", "raymarch"});
  refuse("/settings/steps", 3, {"settings.steps is 3", "4 to 4096"});
  refuse("/settings/layers", 16, {"settings.layers is 16", "1 to 15"});
  refuse("/settings/table_preset", "fancy", {"settings.table_preset", "fancy", "default"});
  refuse("/settings/scene.clouds.coverage", 7, {"clouds.coverage is 7", "0 to 1"});
  refuse("/settings/scene.cloud.coverage", 0.5, {"cloud", "clouds"});
  refuse("/series/0/axes/scale", {1, 3}, {"series[0].axes.scale is 3", "1, 2 or 4"});
  refuse("/series/0/axes/scale", 1, {"series[0].axes.scale is 1", "array"});
  refuse("/series/0/axes/speed", {1}, {"series[0].axes.speed", "quality"});
  refuse("/series/0/axes/scale", {1, 1}, {"one volume scale=1", "same"});
  refuse("/series/1/name", "volume", {"series[1].name", "another"});
  refuse("/series/1/settings/backend", "alpha", {"one exact", "blend exact needs the backend tiled"});
  refuse("/reference/blend", "best", {"reference.blend", "volume"});
}
