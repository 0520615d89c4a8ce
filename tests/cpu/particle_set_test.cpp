// Particle sets on disk: round trips, and every kind of damage is named instead of loaded.
#include "engine/particle_set.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <span>

#include "engine/npy.h"
#include "tests/support/support.h"

using namespace nephele;
using nephele::test::TempDirectory;

namespace {

ParticleSet small_set() {
  ParticleSet set;
  set.base_m = -20.0f;
  set.top_m = 310.0f;
  set.source = "test";
  set.parameters = R"({"seed":3})";
  for (int i = 0; i < 7; ++i) {
    const float f = static_cast<float>(i);
    set.particles.push_back({.center_m = {10.0f * f, -7.0f * f, 40.0f * f},
                             .diagonal_m = {90.0f + f, 70.0f, 55.0f},
                             .off_diagonal_m = {5.0f * f, 0.0f, 0.0f},
                             .extinction_per_m = 0.01f * f});
  }
  give_particles_base_and_top(set);
  return set;
}

std::string complaint(const std::string& path) {
  const Result<ParticleSet> set = load_particle_set(path);
  return set ? "accepted" : set.error().message;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("particle set: a round trip keeps every bit") {
  const TempDirectory dir;
  const ParticleSet set = small_set();
  REQUIRE(save_particle_set(dir / "cloud.json", set));
  CHECK(dir.entries() == std::vector<std::string>{"cloud.json", "cloud.npy"});
  const Result<ParticleSet> back = load_particle_set(dir / "cloud.json");
  if (!back) FAIL(back.error().message);
  CHECK(back->base_m == set.base_m);
  CHECK(back->top_m == set.top_m);
  CHECK(back->source == "test");
  CHECK(back->parameters == R"({"seed":3})");
  REQUIRE(back->particles.size() == set.particles.size());
  for (std::size_t i = 0; i < set.particles.size(); ++i) {
    CHECK(back->particles[i].center_m == set.particles[i].center_m);
    CHECK(back->particles[i].diagonal_m == set.particles[i].diagonal_m);
    CHECK(back->particles[i].off_diagonal_m == set.particles[i].off_diagonal_m);
    CHECK(back->particles[i].extinction_per_m == set.particles[i].extinction_per_m);
  }
}

TEST_CASE("particle set: files cut at any length are refused by name") {
  const TempDirectory dir;
  const std::string json = dir / "cloud.json", npy = dir / "cloud.npy";
  REQUIRE(save_particle_set(json, small_set()));
  const std::string whole_json = test::read_file(json), whole_npy = test::read_file(npy);
  for (std::size_t n = 0; n < whole_npy.size(); ++n) {
    test::write_file(npy, whole_npy.substr(0, n));
    CHECK_MESSAGE(contains(complaint(json), npy), "array cut at ", n);
  }
  test::write_file(npy, whole_npy);
  for (std::size_t n = 0; n + 1 < whole_json.size(); ++n) {  // the last byte is a newline
    test::write_file(json, whole_json.substr(0, n));
    CHECK_MESSAGE(contains(complaint(json), json), "description cut at ", n);
  }
  test::write_file(json, whole_json);
  CHECK(complaint(json) == "accepted");
  std::filesystem::remove(npy);
  CHECK(contains(complaint(json), "cloud.npy: cannot be opened"));
  CHECK(contains(complaint(dir / "absent.json"), "absent.json"));
}

TEST_CASE("particle set: a flipped bit anywhere in the data is found") {
  const TempDirectory dir;
  const std::string json = dir / "cloud.json", npy = dir / "cloud.npy";
  REQUIRE(save_particle_set(json, small_set()));
  const std::string whole = test::read_file(npy);
  const std::size_t data_at = whole.size() - small_set().particles.size() * sizeof(SetParticle);
  for (std::size_t i = data_at; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    test::write_file(npy, damaged);
    CHECK(contains(complaint(json), "damaged"));
  }
}

TEST_CASE("particle set: a description that does not fit is refused, each fault in its own line") {
  const TempDirectory dir;
  const std::string json = dir / "cloud.json";
  REQUIRE(save_particle_set(json, small_set()));
  const std::string whole = test::read_file(json);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = whole;
    const std::size_t at = text.find(from);
    REQUIRE_MESSAGE(at != std::string::npos, from);
    test::write_file(json, text.replace(at, from.size(), to));
    const std::string line = complaint(json);
    CHECK(line.find('\n') == std::string::npos);
    return line;
  };
  CHECK(contains(with("\"count\": 7", "\"count\": 6"), "not the 6 rows of 13 columns"));
  CHECK(contains(with("\"count\": 7", "\"count\": 0"), "count is 0; accepted: a whole number from 1"));
  CHECK(contains(with("center_x", "center_y"), "column 0 is \"center_y\" in m; accepted: \"center_x\" in m"));
  CHECK(contains(with("\"1/m\"", "\"1/km\""), "column 9 is \"extinction\" in 1/km"));
  CHECK(contains(with("\"extinction\"", "\"extinction\", \"more\""), "columns: 14, units: 13"));
  CHECK(contains(with("nephele particle set", "a table"), "format is \"a table\""));
  CHECK(contains(with("\"version\": 1", "\"version\": 2"), "version is 2"));
  CHECK(contains(with("\"base_m\": -20.0", "\"base_m\": 2e7"), "base_m is"));
  CHECK(contains(with("\"base_m\": -20.0", "\"base_m\": 311"), "top_m is 310, below base_m, 311"));
  CHECK(contains(with("\"base_m\": -20.0,", ""), "base_m is missing"));
  CHECK(contains(with("\"units\"", "\"unit\""), "units is missing"));
  CHECK(contains(with("\"count\"", "\"colour\": 1, \"count\""), "unknown key colour"));
  CHECK(contains(with("\"parameters\": {", "\"parameters\": [{"), "not valid JSON"));
}

TEST_CASE("particle set: values that make no particle are refused, saving and loading") {
  const TempDirectory dir;
  const std::string json = dir / "cloud.json";
  const auto saved = [&](auto&& change) -> std::string {
    ParticleSet set = small_set();
    change(set);
    const Result<void> ok = save_particle_set(json, set);
    return ok ? "accepted" : ok.error().message;
  };
  using Set = ParticleSet;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(saved([](Set&) {}) == "accepted");
  CHECK(contains(saved([&](Set& s) { s.particles[3].center_m.y = nan; }), "particle 3: center_y is"));
  CHECK(contains(saved([&](Set& s) { s.particles[3].extinction_per_m = INFINITY; }), "particle 3: extinction is inf"));
  CHECK(contains(saved([](Set& s) { s.particles[3].extinction_per_m = -1.0f; }), "particle 3: extinction is -1"));
  CHECK(contains(saved([](Set& s) { s.particles[2].diagonal_m.z = 0.0f; }), "particle 2: the shape is not positive"));
  CHECK(contains(saved([](Set& s) { s.particles[2].off_diagonal_m.x = 90.0f; }), "not positive definite"));
  CHECK(contains(saved([](Set& s) { s.particles[2].off_diagonal_m = {0, 50, 50}; }), "not positive definite"));
  CHECK(saved([](Set& s) { s.particles[2].off_diagonal_m = {0, 20, 20}; }) == "accepted");
  CHECK(contains(saved([](Set& s) { s.particles.clear(); }), "0 particles"));
  CHECK(contains(saved([](Set& s) { s.top_m = -21.0f; }), "below base_m"));
  CHECK(contains(saved([](Set& s) { s.parameters = "[]"; }), "not a JSON object"));
  // The same in files that somebody else wrote, hash and all.
  REQUIRE(save_particle_set(json, small_set()));
  Result<NpyArray> array = read_npy(dir / "cloud.npy");
  REQUIRE(array);
  std::memcpy(array->data.data() + sizeof(SetParticle), &nan, sizeof nan);
  std::string text = test::read_file(json);
  const std::size_t at = text.find("\"hash\": \"") + 9;
  REQUIRE(write_npy(dir / "cloud.npy", *array));
  test::write_file(json, text.replace(at, 16, hex64(fnv1a(array->data))));
  CHECK(contains(complaint(json), "particle 1: center_x is"));
}

TEST_CASE("particle set: further columns are left alone") {
  const TempDirectory dir;
  const std::string json = dir / "cloud.json";
  const ParticleSet set = small_set();
  REQUIRE(save_particle_set(json, set));
  NpyArray wide{ElementType::float32, {set.particles.size(), 14}, {}};
  std::vector<float> values;
  for (const SetParticle& p : set.particles) {
    const auto* row = reinterpret_cast<const float*>(&p);
    values.insert(values.end(), row, row + 13);
    values.push_back(1234.0f);
  }
  const auto bytes = std::as_bytes(std::span(values));
  wide.data.assign(bytes.begin(), bytes.end());
  REQUIRE(write_npy(dir / "cloud.npy", wide));
  std::string text = test::read_file(json);
  const auto put = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  put("\"seed\"", "\"seed\", \"temperature\"");
  put("\"1\"", "\"1\", \"K\"");
  text.replace(text.find("\"hash\": \"") + 9, 16, hex64(fnv1a(wide.data)));
  test::write_file(json, text);
  const Result<ParticleSet> back = load_particle_set(json);
  if (!back) FAIL(back.error().message);
  CHECK(back->particles[6].center_m == set.particles[6].center_m);
  CHECK(back->particles[6].extinction_per_m == set.particles[6].extinction_per_m);
}

TEST_CASE("particle set: bases, tops and seeds a particle, shape, detail and coarser levels come back") {
  const TempDirectory dir;
  const std::string json = dir / "cloud.json";
  ParticleSet set = small_set();
  set.shape = ParticleShape::soft;
  set.detail = 0.25f;
  for (std::size_t i = 0; i < set.particles.size(); ++i) {
    set.particles[i].base_m = -20.0f + static_cast<float>(i);
    set.particles[i].top_m = 310.0f - static_cast<float>(i);
    set.particles[i].seed = kMaxParticleSeed - static_cast<float>(i);
  }
  ParticleSet coarse = set;
  coarse.particles.resize(3);
  set.coarser = {coarse, coarse};
  set.coarser[1].particles.resize(1);
  REQUIRE(save_particle_set(json, set));
  CHECK(dir.entries() == std::vector<std::string>{"cloud.json", "cloud.npy", "cloud_1.json", "cloud_1.npy",
                                                  "cloud_2.json", "cloud_2.npy"});
  const Result<ParticleSet> back = load_particle_set(json);
  if (!back) FAIL(back.error().message);
  CHECK(*back == set);
  // Levels of levels, levels that are missing and values out of range are faults.
  std::filesystem::remove(dir / "cloud_2.npy");
  CHECK(contains(complaint(json), "cloud.json: coarser: "));
  CHECK(contains(complaint(json), "cloud_2.npy"));
  ParticleSet deep = set;
  deep.coarser[0].coarser = {coarse};
  CHECK(contains(save_particle_set(json, deep).error().message, "coarser level 1 has coarser levels itself"));
  const auto saved = [&](auto&& change) {
    ParticleSet bad = set;
    change(bad);
    const Result<void> ok = save_particle_set(json, bad);
    return ok ? std::string("accepted") : ok.error().message;
  };
  CHECK(contains(saved([](ParticleSet& s) { s.particles[1].seed = 0.5f; }), "particle 1: seed is 0.5"));
  CHECK(contains(saved([](ParticleSet& s) { s.particles[1].seed = 2e7f; }), "particle 1: seed is"));
  CHECK(contains(saved([](ParticleSet& s) { s.particles[1].base_m = -21.0f; }), "particle 1: base is -21"));
  CHECK(contains(saved([](ParticleSet& s) { s.particles[1].top_m = 311.0f; }), "top 311"));
  CHECK(contains(saved([](ParticleSet& s) { s.detail = 1.5f; }), "detail is 1.5; accepted: 0 to 1"));
  CHECK(contains(saved([&](ParticleSet& s) { s.coarser.resize(7, coarse); }), "7 coarser levels; accepted: at most 6"));
}

TEST_CASE("particle set: ten columns are enough, as others write them") {
  const TempDirectory dir;
  const std::string json = dir / "cloud.json";
  const ParticleSet set = small_set();
  NpyArray narrow{ElementType::float32, {set.particles.size(), 10}, {}};
  for (const SetParticle& p : set.particles) {
    const auto row = std::as_bytes(std::span(&p, 1));
    narrow.data.insert(narrow.data.end(), row.begin(), row.begin() + 40);
  }
  REQUIRE(write_npy(dir / "cloud.npy", narrow));
  test::write_file(json, R"({"format": "nephele particle set", "version": 1,
    "columns": ["center_x", "center_y", "center_z", "shape_xx", "shape_yy", "shape_zz", "shape_xy", "shape_xz",
                "shape_yz", "extinction"],
    "units": ["m", "m", "m", "m", "m", "m", "m", "m", "m", "1/m"],
    "count": 7, "base_m": -20, "top_m": 310, "hash": ")" +
                             hex64(fnv1a(narrow.data)) +
                             R"(", "source": {"name": "test", "parameters": {"seed": 3}}})");
  const Result<ParticleSet> back = load_particle_set(json);
  if (!back) FAIL(back.error().message);
  CHECK(*back == set);
}
