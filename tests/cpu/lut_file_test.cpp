// Tables on disk: round trips, and every kind of damage is named instead of loaded.
#include <doctest/doctest.h>

#include <array>
#include <filesystem>
#include <random>

#include "lut/tables.h"
#include "tests/support/support.h"

using namespace nephele;
using nephele::test::TempDirectory;

namespace {

// Small and quick to bake.
TableParameters tiny() {
  TableParameters parameters;
  parameters.optical_depth_size = 4;
  parameters.scattering_cosines = 4;
  parameters.scattering_chords = 3;
  parameters.scattering_densities = 4;
  parameters.coarse_solver = true;
  parameters.residual = 1e-2;
  return parameters;
}

std::filesystem::path find_json(const std::filesystem::path& dir, const std::string& prefix) {
  for (const auto& entry : std::filesystem::directory_iterator(dir))
    if (entry.path().filename().string().starts_with(prefix) && entry.path().extension() == ".json")
      return entry.path();
  return {};
}

void replace_in(const std::string& path, const std::string& from, const std::string& to) {
  std::string text = test::read_file(path);
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  test::write_file(path, text.replace(at, from.size(), to));
}

NpyArray counting_array() {
  NpyArray array;
  array.type = ElementType::float16;
  array.shape = {3, 2, 5};
  for (int i = 0; i < 60; ++i) array.data.push_back(static_cast<std::byte>(i));
  return array;
}

}  // namespace

TEST_CASE("an .npy file is a round trip and starts as NumPy says") {
  const TempDirectory dir;
  const std::string path = dir / "a.npy";
  REQUIRE(write_npy(path, counting_array()));
  const Result<NpyArray> back = read_npy(path);
  REQUIRE(back);
  CHECK(back->type == ElementType::float16);
  CHECK(back->shape == std::vector<std::size_t>{3, 2, 5});
  CHECK(back->data == counting_array().data);
  const std::string text = test::read_file(path);
  CHECK(text.substr(0, 8) == std::string("\x93NUMPY\x01\x00", 8));
  CHECK(text.find("{'descr': '<f2', 'fortran_order': False, 'shape': (3, 2, 5), }") == 10);
  CHECK((text.size() - 60) % 64 == 0);
  CHECK(text[text.size() - 61] == '\n');
  CHECK(dir.entries() == std::vector<std::string>{"a.npy"});
}

TEST_CASE("an .npy file cut at any length or with a changed header is refused by name") {
  const TempDirectory dir;
  const std::string path = dir / "a.npy";
  REQUIRE(write_npy(path, counting_array()));
  const std::string whole = test::read_file(path);
  for (std::size_t n = 0; n < whole.size(); ++n) {
    test::write_file(path, whole.substr(0, n));
    const Result<NpyArray> cut = read_npy(path);
    CHECK_MESSAGE(!cut, "cut at ", n);
    if (!cut) CHECK(cut.error().message.find(path) == 0);
  }
  test::write_file(path, whole + "x");
  CHECK_FALSE(read_npy(path));
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{{"<f2", ">f2"},
                                                                                 {"<f2", "<f8"},
                                                                                 {"False", "True "},
                                                                                 {"(3, 2, 5)", "(3, 2, 6)"},
                                                                                 {"(3, 2, 5)", "(0, 2, 5)"},
                                                                                 {"(3, 2, 5)", "(       )"},
                                                                                 {"NUMPY\x01", "NUMPY\x02"},
                                                                                 {"(3, 2, 5), }", "(9999999999)"}}) {
    test::write_file(path, whole);
    replace_in(path, from, to);
    const Result<NpyArray> changed = read_npy(path);
    CHECK_MESSAGE(!changed, from, " -> ", to);
  }
  CHECK(read_npy(dir / "absent.npy").error().message.find("absent.npy") != std::string::npos);
}

TEST_CASE("tables are baked once, then read back bit for bit") {
  const TempDirectory dir;
  std::vector<std::string> warnings;
  int progress_calls = 0;
  const auto warn = [&](const std::string& line) { warnings.push_back(line); };
  const auto count = [&](const std::string&, double) { ++progress_calls; };
  const Result<Tables> baked = load_or_bake(tiny(), dir.path(), count, warn);
  REQUIRE(baked);
  CHECK(progress_calls > 0);
  CHECK(dir.entries().size() == 6);  // three .npy, three .json, nothing temporary
  const auto refuse = [](const std::string&, double) { FAIL_CHECK("baked again"); };
  const Result<Tables> loaded = load_or_bake(tiny(), dir.path(), refuse, warn);
  REQUIRE(loaded);
  CHECK(warnings.empty());
  CHECK(loaded->optical_depth.array.data == baked->optical_depth.array.data);
  CHECK(loaded->multiple_scattering.array.data == baked->multiple_scattering.array.data);
  CHECK(loaded->multiple_scattering.metadata == baked->multiple_scattering.metadata);
  CHECK(loaded->near_beam.array.data == baked->near_beam.array.data);
  CHECK(loaded->mean_fill == baked->mean_fill);
  CHECK(loaded->mean_fill == doctest::Approx(0.43).epsilon(0.05));

  TableParameters other = tiny();
  other.g_multiple = 0.5;
  REQUIRE(load_or_bake(other, dir.path(), {}, warn));
  CHECK(dir.entries().size() == 10);  // the optical depth does not depend on g
}

TEST_CASE("damaged and foreign cache files are reported by name and baked again") {
  const TempDirectory dir;
  const Result<Tables> good = load_or_bake(tiny(), dir.path());
  REQUIRE(good);
  const std::string json_path = find_json(dir.path(), "multiple_scattering").string();
  const std::string npy_path = std::filesystem::path(json_path).replace_extension(".npy").string();
  const std::string json_text = test::read_file(json_path), npy_text = test::read_file(npy_path);
  const auto expect_rebake = [&](const std::string& field) {
    CAPTURE(field);
    std::vector<std::string> warnings;
    const Result<Tables> again =
        load_or_bake(tiny(), dir.path(), {}, [&](const std::string& line) { warnings.push_back(line); });
    REQUIRE(again);
    CHECK(again->multiple_scattering.array.data == good->multiple_scattering.array.data);
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].find("multiple_scattering") != std::string::npos);
    CHECK_MESSAGE(warnings[0].find(field) != std::string::npos, warnings[0]);
    CHECK(test::read_file(npy_path) == npy_text);  // repaired on disk
  };
  std::string flipped = npy_text;
  flipped.back() = static_cast<char>(flipped.back() ^ 1);
  test::write_file(npy_path, flipped);
  expect_rebake("data_fnv1a");
  std::filesystem::remove(npy_path);
  expect_rebake("cannot be opened");
  for (const auto& [from, to, field] : std::vector<std::array<std::string, 3>>{
           {"\"hg\"", "\"cs\"", "parameters"}, {"\"generator\": \"", "\"generator\": \"0", "generator"}}) {
    test::write_file(json_path, json_text);
    replace_in(json_path, from, to);
    expect_rebake(field);
  }
  // What loading alone finds.
  for (const auto& [from, to, field] :
       std::vector<std::array<std::string, 3>>{{"\"version\": 2", "\"version\": 9", "version"},
                                               {"\"<f2\"", "\"<f4\"", "dtype"},
                                               {"nephele table", "somebody's", "format"},
                                               {"\"bytes\": ", "\"bytes\": 1", "bytes"},
                                               {"\"shape\"", "\"shapes\"", "shape"}}) {
    test::write_file(json_path, json_text);
    replace_in(json_path, from, to);
    const Result<Table> loaded = load_table(json_path);
    REQUIRE_FALSE(loaded);
    CHECK(loaded.error().message.find(json_path) == 0);
    CHECK_MESSAGE(loaded.error().message.find(field) != std::string::npos, loaded.error().message);
  }
}

TEST_CASE("flipping any byte of a table's files never goes unnoticed or crashes") {
  const TempDirectory dir;
  REQUIRE(bake_to(dir.path(), tiny()));
  const std::string json_path = dir / "multiple_scattering.json", npy_path = dir / "multiple_scattering.npy";
  const std::string npy_text = test::read_file(npy_path), json_text = test::read_file(json_path);
  const Result<Table> whole = load_table(json_path);
  REQUIRE(whole);
  std::mt19937 random(1);
  for (std::size_t i = 0; i < npy_text.size(); ++i) {
    std::string damaged = npy_text;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << random() % 8));
    test::write_file(npy_path, damaged);
    const Result<Table> loaded = load_table(json_path);
    // A few bytes of the header (padding, brackets) carry nothing: then the table is whole.
    if (!loaded) continue;
    CHECK_MESSAGE(loaded->array.data == whole->array.data, "byte ", i);
    CHECK_MESSAGE(loaded->array.shape == whole->array.shape, "byte ", i);
    CHECK_MESSAGE(i < 128, "byte ", i);
  }
  test::write_file(npy_path, npy_text);
  for (std::size_t n = 0; n + 2 < json_text.size(); n += 7) {
    test::write_file(json_path, json_text.substr(0, n));
    CHECK_FALSE(load_table(json_path));
  }
}

TEST_CASE("parameters out of range and unknown presets are refused with field and range") {
  TableParameters parameters = tiny();
  parameters.g_multiple = 0.99;
  const Result<Tables> refused = load_or_bake(parameters, "/nonexistent");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().message == "g_multiple: 0.99, accepted are -0.95 to 0.95");
  parameters = tiny();
  parameters.optical_depth_size = 1000;
  CHECK(parameters.validate().error().message == "optical_depth_size: 1000, accepted are 4 to 64");
  CHECK_FALSE(TableParameters::preset("best"));
  CHECK(TableParameters::preset("fast"));
}

TEST_CASE("a cache directory that cannot be written costs a warning, not the tables") {
  const TempDirectory dir;
  test::write_file(dir / "file", "in the way");
  std::vector<std::string> warnings;
  const Result<Tables> tables = load_or_bake(tiny(), std::filesystem::path(dir / "file") / "cache", {},
                                             [&](const std::string& line) { warnings.push_back(line); });
  REQUIRE(tables);
  CHECK(warnings.size() == 3);
  CHECK(tables->multiple_scattering.width() == 4);
}
