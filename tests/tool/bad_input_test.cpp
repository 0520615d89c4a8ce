// Bad input as a user types it: exit status 2, exactly one line on stderr, nothing on stdout, no file left behind.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "engine/image_io.h"
#include "tests/support/support.h"
#include "tests/tool/program.h"

using namespace nephele::test;

namespace {

// Runs in an empty directory; `mentions` are what the line must name.
void expect_refusal(const std::vector<std::string>& arguments, const std::vector<std::string>& mentions) {
  const ProgramResult result = run_program(arguments);
  CAPTURE(arguments);
  CAPTURE(result.err);
  CHECK(result.status == 2);
  CHECK(result.out.empty());
  CHECK(result.err.starts_with("nephele: "));
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  for (const std::string& mention : mentions) CHECK_MESSAGE(result.err.find(mention) != std::string::npos, mention);
}

}  // namespace

TEST_CASE("bad input: no command, unknown commands and options") {
  expect_refusal({}, {"no command"});
  expect_refusal({"paint"}, {"paint"});
  expect_refusal({"render", "--colour"}, {"--colour"});
  expect_refusal({"devices", "extra"}, {"extra"});
  expect_refusal({"render", "--out"}, {"--out"});
  expect_refusal({"bake", "--preset", "fancy"}, {"--preset", "fancy", "default"});
  expect_refusal({"bake", "--phase", "mie"}, {"--phase", "mie", "hg"});
}

TEST_CASE("bad input: nothing to write") { expect_refusal({"render"}, {"--out"}); }

TEST_CASE("bad input: option values out of range name the option, the value and what is accepted") {
  const TempDirectory directory;
  const std::string out = directory / "x.png";
  const auto refuse = [&](const std::string& option, const std::string& value, const std::string& accepted) {
    expect_refusal({"render", "--out", out, option, value}, {option, value, accepted});
  };
  for (const char* size : {"0x10", "10x0", "100000x1", "1x100000", "16384x16384", "64", "64x", "x64", "64x36x2", "-4x4",
                           "4.5x4", "", "64X36", "99999999999x1"})
    refuse("--size", size, "1 to 16384");
  refuse("--scale", "3", "1, 2 or 4");
  refuse("--scale", "0", "1, 2 or 4");
  refuse("--quality", "ultra", "medium");
  refuse("--backend", "magic", "attachment");
  refuse("--blend", "none", "volume");
  refuse("--method", "rasterize", "raymarch");
  refuse("--steps", "3", "accepted: a whole number from 4 to 4096");
  refuse("--frames", "0", "accepted: a whole number from 1 to 1000000");
  refuse("--frames", "-1", "1 to 1000000");
  refuse("--frames", "many", "1 to 1000000");
  refuse("--warmup", "-1", "0 to 1000000");
  refuse("--time", "nan", "a number from -1000000000 to 1000000000");
  refuse("--time", "2e+09", "a number from -1000000000 to 1000000000");
  refuse("--time", "1000000001", "a number from -1000000000 to 1000000000");
  for (const char* size : {"--g-single", "--g-multiple"})
    expect_refusal({"bake", "--out", directory / "tables", size, "1"}, {size, "a number from -0.95 to 0.95"});
  expect_refusal({"bake", "--out", directory / "tables", "--residual", "0"}, {"--residual is 0", "1e-07 to 0.01"});
  expect_refusal({"bake", "--out", directory / "tables", "--size-scattering", "4x3"}, {"--size-scattering", "4x3"});
  expect_refusal({"bake", "--out", directory / "tables", "--size-optical-depth", "1"}, {"optical_depth_size", "64"});
  CHECK(directory.entries().empty());
}

TEST_CASE("bad input: an empty value is refused, and nothing else is taken for it") {
  const TempDirectory directory;
  const std::string out = directory / "x.exr";
  for (const char* option : {"--scene", "--view", "--path", "--out", "--layers", "--stats", "--tables", "--device",
                             "--time", "--frames", "--warmup", "--size", "--quality", "--steps", "--reuse"})
    expect_refusal({"render", "--out", out, option, ""}, {option});
  for (const char* option : {"--scene", "--view", "--picture", "--noise", "--spp", "--threads"})
    expect_refusal({"reference", "--out", out, option, ""}, {option});
  for (const char* option : {"--out", "--stats", "--phase", "--g-single", "--size-scattering"})
    expect_refusal({"bake", option, ""}, {option});
  expect_refusal({"compare", "", out}, {"test"});
  expect_refusal({"compare", out, out, "--channels", ""}, {"--channels"});
  expect_refusal({"sweep", "--config", "", "--out", directory / "sweep"}, {"--config"});
  expect_refusal({"probe", "--table", "single", "--rays", "", "--out", out}, {"--rays"});
  CHECK(directory.entries().empty());
}

TEST_CASE("bad input: two files that are one, however their names are spelt") {
  const TempDirectory directory;
  const std::string exr = directory / "a.exr", dotted = directory / "./a.exr", json = directory / "s.json";
  write_file(json, "{}");
  std::filesystem::create_directory_symlink(directory.path(), directory / "link");
  expect_refusal({"render", "--out", exr, "--layers", dotted}, {"--out and --layers are both", "a.exr"});
  expect_refusal({"render", "--out", exr, "--layers", directory / "link/a.exr"},
                 {"--out and --layers are both", "a.exr"});
  expect_refusal({"render", "--scene", json, "--stats", directory / "./s.json"},
                 {"--scene and --stats are both", "s.json"});
  expect_refusal({"render", "--out", directory / "a%d.exr", "--layers", directory / "a%04d.exr", "--frames", "2000"},
                 {"--out and --layers are both", "a1999.exr"});
  expect_refusal({"reference", "--out", exr, "--layers", dotted}, {"--out and --layers are both", "a.exr"});
  CHECK(read_file(json) == "{}");
  CHECK(directory.entries() == std::vector<std::string>{"link", "s.json"});
}

TEST_CASE("bad input: --layers needs the layer that --full-layer off does not keep") {
  const TempDirectory directory;
  expect_refusal({"render", "--layers", directory / "x.exr", "--full-layer", "off"}, {"--layers", "--full-layer"});
}

TEST_CASE("bad input: unknown devices are answered with the known ones") {
  const TempDirectory directory;
  expect_refusal({"render", "--out", directory / "x.png", "--device", "Voodoo"}, {"Voodoo", "0 = "});
  expect_refusal({"render", "--out", directory / "x.png", "--device", "99"}, {"99", "0 = "});
  CHECK(directory.entries().empty());
}

TEST_CASE("bad input: outputs that can't be written are refused before any rendering") {
  const TempDirectory directory;
  write_file(directory / "file", "x");
  expect_refusal({"render", "--out", directory / "none/x.png"}, {directory / "none/x.png", "can't be written"});
  expect_refusal({"render", "--out", directory / "file/x.png"}, {directory / "file/x.png", "can't be written"});
  expect_refusal({"render", "--out", directory / "x.jpg"}, {"--out", ".png or .exr"});
  expect_refusal({"render", "--layers", directory / "x.png"}, {"--layers", ".exr"});
  expect_refusal({"render", "--stats", directory / "none/x.json"}, {directory / "none/x.json", "can't be written"});
  expect_refusal({"render", "--out", directory / "x.exr", "--layers", directory / "x.exr"}, {"--out", "--layers"});
  expect_refusal({"render", "--out", directory / "x.png", "--frames", "2"}, {"--out", "%04d"});
  expect_refusal({"bake", "--out", directory / "file/tables"}, {directory / "file/tables"});
  CHECK(directory.entries() == std::vector<std::string>{"file"});
}

TEST_CASE("bad input: scene and path files") {
  const TempDirectory directory;
  const std::string out = directory / "x.png", scene = directory / "scene.json";
  expect_refusal({"render", "--out", out, "--scene", scene}, {scene, "can't be opened"});
  expect_refusal({"render", "--out", out, "--scene", directory.path().string()}, {"is a directory"});
  const auto refuse_scene = [&](const std::string& text, const std::vector<std::string>& mentions) {
    write_file(scene, text);
    expect_refusal({"render", "--out", out, "--scene", scene}, mentions);
  };
  refuse_scene("{\n\"sun\": ", {scene, "not valid JSON"});
  refuse_scene(R"({"clouds": {"coverge": 1}})", {scene, "clouds.coverge", "coverage"});
  refuse_scene(R"({"clouds": {"coverage": 7}})", {scene, "clouds.coverage", "7", "0 to 1"});
  refuse_scene(R"({"sun": {"azimuth_deg": "south"}})", {scene, "sun.azimuth_deg", "south"});
  refuse_scene(R"({"exposure_ev": 1e999})", {scene, "1e999"});
  refuse_scene(R"({"clouds": {"weather_map": {"file": "no.png", "origin_m": [0, 0], "extent_m": [1, 1]}}})",
               {scene, "clouds.weather_map.file", directory / "no.png", "can't be opened"});
  refuse_scene(R"({"clouds": {"weather_map": {"file": "scene.json", "origin_m": [0, 0], "extent_m": [1, 1]}}})",
               {"clouds.weather_map.file", "can't be read as a PNG image"});
  refuse_scene(R"({"terrain": {"file": "scene.json", "origin_m": [0, 0], "extent_m": [1, 1], "lowest_m": 0,
                   "highest_m": 1}})",
               {"terrain.file", "can't be read as a PNG image"});
  refuse_scene(R"({"terrain": {"file": "no.png", "origin_m": [0, 0], "extent_m": [1, 1], "lowest_m": 0}})",
               {scene, "terrain.highest_m", "is missing"});
  refuse_scene("{\"sun\": 1, \"sun\": 2}", {scene, "sun", "twice"});
  refuse_scene(std::string("{\"particles\": []}\0{\"garbage", 27), {scene, "not valid JSON", "byte 18 is NUL"});
  // Deep nesting, in every JSON file that a user hands over.
  const std::string deep = "{\"exposure_ev\": " + std::string(100000, '[') + std::string(100000, ']') + "}";
  refuse_scene(deep, {scene, "nested deeper than 64"});
  write_file(directory / "deep.json", deep);
  expect_refusal({"render", "--out", out, "--path", directory / "deep.json"}, {"deep.json", "nested deeper than 64"});
  expect_refusal({"sweep", "--config", directory / "deep.json", "--out", directory / "sweep"},
                 {"deep.json", "nested deeper than 64"});
  std::filesystem::remove(directory / "deep.json");
  write_file(directory / "path.json", R"({"keys": []})");
  expect_refusal({"render", "--out", out, "--path", directory / "path.json"}, {directory / "path.json", "keys"});
  CHECK(directory.entries() == std::vector<std::string>{"path.json", "scene.json"});
}

TEST_CASE("bad input: views") {
  const TempDirectory directory;
  const std::string scene = directory / "scene.json";
  write_file(scene, R"({"views": [{"name": "level"}, {"name": "from above"}]})");
  for (const char* command : {"render", "reference"}) {
    const std::vector<std::string> start{command, "--out", directory / "x.exr"};
    const auto refuse = [&](std::vector<std::string> more, const std::vector<std::string>& mentions) {
      more.insert(more.begin(), start.begin(), start.end());
      expect_refusal(more, mentions);
    };
    for (const char* unknown : {"below", "0", "3", "-1", "1.0", "01", "Level"})
      refuse({"--scene", scene, "--view", unknown},
             {std::string("--view is "), unknown, R"(accepted: 1 = "level", 2 = "from above")"});
    refuse({"--view", "1"}, {"--view is 1", "the scene has no views"});
  }
  write_file(scene, R"({"views": [{"name": "a"}, {"name": "a"}]})");
  expect_refusal({"render", "--out", directory / "x.exr", "--scene", scene},
                 {scene, "views[1].name is \"a\"; accepted: a name that no other view has"});
  CHECK(directory.entries() == std::vector<std::string>{"scene.json"});
}

TEST_CASE("bad input: damaged tables given with --tables") {
  const TempDirectory directory;
  const std::string out = directory / "x.png", tables = directory / "tables";
  const auto refuse = [&](const std::vector<std::string>& mentions) {
    expect_refusal({"render", "--size", "8x8", "--out", out, "--tables", tables}, mentions);
  };
  refuse({tables});

  bake_small_tables(tables);
  const std::string good = read_file(tables + "/multiple_scattering.npy");
  std::string flipped = good;
  flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 1);
  for (const std::string& bad :
       {flipped, good.substr(0, good.size() - 1), good + "x", std::string("not a table"), std::string()}) {
    write_file(tables + "/multiple_scattering.npy", bad);
    refuse({tables});
  }
  write_file(tables + "/multiple_scattering.npy", good);
  write_file(tables + "/optical_depth.json", "{}");
  refuse({tables + "/optical_depth.json"});
  CHECK(directory.entries() == std::vector<std::string>{"tables"});
}

TEST_CASE("bad input: tables baked for another phase function than the scene's") {
  const TempDirectory directory;
  bake_small_tables(directory / "tables");
  write_file(directory / "scene.json", R"({"phase": {"g": 0.5}})");
  expect_refusal({"render", "--size", "8x8", "--out", directory / "x.png", "--tables", directory / "tables", "--scene",
                  directory / "scene.json"},
                 {directory / "tables", "0.85", "0.5"});
}

TEST_CASE("bad input: images that can't be compared") {
  const TempDirectory directory;
  const std::string a = directory / "a.exr", b = directory / "b.exr";
  const auto write = [](const std::string& path, const nephele::ImageF& image) {
    REQUIRE(nephele::write_exr(path, image));
  };
  write(a, {2, 1, {"R", "G", "B"}, {1, 2, 3, 4, 5, 6}});
  expect_refusal({"compare", a}, {"reference"});
  expect_refusal({"compare", a, b}, {b, "can't be read"});
  write(b, {1, 2, {"R", "G", "B"}, {1, 2, 3, 4, 5, 6}});
  expect_refusal({"compare", a, b}, {a, b, "2x1", "1x2"});
  write(b, {2, 1, {"R", "G", "B"}, {1, 2, 3, 4, NAN, 6}});
  expect_refusal({"compare", a, b}, {b, "\"G\"", "nan", "pixel 1, 0", "finite"});
  expect_refusal({"compare", a, a, "--channels", "R,T"}, {a, "\"T\"", "B, G, R"});
  expect_refusal({"compare", a, a, "--channels", "R,R"}, {"\"R\"", "twice"});
}

TEST_CASE("bad input: references") {
  const TempDirectory directory;
  const std::string out = directory / "x.exr";
  expect_refusal({"reference"}, {"--out"});
  expect_refusal({"reference", "--out", directory / "x.png"}, {"--out", ".exr"});
  expect_refusal({"reference", "--out", out, "--picture", directory / "y.jpg"}, {"--picture", ".png"});
  expect_refusal({"reference", "--out", out, "--layers", out}, {"--out", "--layers"});
  expect_refusal({"reference", "--out", directory / "none/x.exr"}, {directory / "none/x.exr", "can't be written"});
  const auto refuse = [&](const std::string& option, const std::string& value, const std::string& accepted) {
    expect_refusal({"reference", "--out", out, option, value}, {option, value, accepted});
  };
  refuse("--spp", "0", "1 to 16777216");
  refuse("--spp", "-1", "1 to 16777216");
  refuse("--noise", "0", "more than 0, less than 1");
  refuse("--noise", "nan", "more than 0, less than 1");
  refuse("--noise", "1", "more than 0, less than 1");
  refuse("--sky-radiance", "-1", "0 to 1000000");
  refuse("--threads", "257", "256");
  refuse("--time", "nan", "-1000000000 to 1000000000");
  refuse("--size", "0x4", "1 to 16384");
  refuse("--quality", "ultra", "medium");
  CHECK(directory.entries().empty());

  bake_small_tables(directory / "tables");
  write_file(directory / "scene.json", R"({"particles": []})");
  write_file(out + ".state", "no state");
  expect_refusal({"reference", "--out", out, "--scene", directory / "scene.json", "--tables", directory / "tables",
                  "--size", "4x4", "--resume"},
                 {out + ".state", "not the state of a reference"});
}
