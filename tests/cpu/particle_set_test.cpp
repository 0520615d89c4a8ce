// Particle sets on disk: round trips, and every kind of damage is named instead of loaded.
#include "engine/particle_set.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "engine/npy.h"
#include "shared/ellipsoid.h"
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
  const std::size_t data_at = whole.size() - small_set().particles.size() * 40;
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
  CHECK(contains(with("\"count\": 7", "\"count\": 6"), "not the 6 rows of 10 columns"));
  CHECK(contains(with("\"count\": 7", "\"count\": 0"), "count is 0; accepted: a whole number from 1"));
  CHECK(contains(with("center_x", "center_y"), "column 0 is \"center_y\" in m; accepted: \"center_x\" in m"));
  CHECK(contains(with("\"1/m\"", "\"1/km\""), "column 9 is \"extinction\" in 1/km"));
  CHECK(contains(with("\"extinction\"", "\"extinction\", \"more\""), "columns: 11, units: 10"));
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
  std::memcpy(array->data.data() + 40, &nan, sizeof nan);
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
  NpyArray wide{ElementType::float32, {set.particles.size(), 11}, {}};
  std::vector<float> values;
  for (const SetParticle& p : set.particles) {
    const auto* row = reinterpret_cast<const float*>(&p);
    values.insert(values.end(), row, row + 10);
    values.push_back(1234.0f);
  }
  const auto bytes = std::as_bytes(std::span(values));
  wide.data.assign(bytes.begin(), bytes.end());
  REQUIRE(write_npy(dir / "cloud.npy", wide));
  std::string text = test::read_file(json);
  const auto put = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  put("\"extinction\"", "\"extinction\", \"temperature\"");
  put("\"1/m\"", "\"1/m\", \"K\"");
  text.replace(text.find("\"hash\": \"") + 9, 16, hex64(fnv1a(wide.data)));
  test::write_file(json, text);
  const Result<ParticleSet> back = load_particle_set(json);
  if (!back) FAIL(back.error().message);
  CHECK(back->particles[6].center_m == set.particles[6].center_m);
  CHECK(back->particles[6].extinction_per_m == set.particles[6].extinction_per_m);
}

TEST_CASE("particle set: radii and yaw of a scene's particles make the shape again") {
  ParticleSet set = small_set();
  for (const float xy : {0.0f, 12.0f, -30.0f, 60.0f})
    for (const glm::vec2 diagonal : {glm::vec2(90, 70), glm::vec2(70, 90), glm::vec2(80, 80)}) {
      set.particles[0].diagonal_m = {diagonal, 33.0f};
      set.particles[0].off_diagonal_m.x = xy;
      const Result<std::vector<ListedParticle>> listed = listed_particles(set);
      REQUIRE(listed);
      const ListedParticle& p = (*listed)[0];
      glm::dvec3 sum(0.0);  // xx, yy, xy of the axes' outer products
      for (int axis = 0; axis < 2; ++axis) {
        glm::vec3 e(0.0f);
        e[axis] = 1.0f;
        const glm::dvec3 d(shared::render_from_local(e, static_cast<float>(p.yaw_rad)));
        sum += static_cast<double>(p.radius_m[axis]) * glm::dvec3(d.x * d.x, d.y * d.y, d.x * d.y);
      }
      CHECK(sum.x == doctest::Approx(diagonal.x).epsilon(1e-5));
      CHECK(sum.y == doctest::Approx(diagonal.y).epsilon(1e-5));
      CHECK(sum.z == doctest::Approx(xy).epsilon(1e-5));
      CHECK(p.radius_m.z == 33.0f);
      CHECK(p.base_m == -20.0f);
      CHECK(p.top_m == 310.0f);
    }
  set.particles[4].off_diagonal_m.y = 3.0f;
  const Result<std::vector<ListedParticle>> tilted = listed_particles(set);
  REQUIRE_FALSE(tilted);
  CHECK(tilted.error().message == "particle 4 is tilted: shape_xz is 3, shape_yz is 0; accepted: 0");
}
