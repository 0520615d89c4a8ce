// The generators of clouds: repeatable numbers, skin, grammar, filling, and what each generator promises of its set.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "engine/check.h"
#include "engine/json_reader.h"
#include "engine/particle_set.h"
#include "engine/result.h"
#include "tests/support/key_table.h"
#include "tests/support/support.h"
#include "tools/clouds/cloud_skin.h"
#include "tools/clouds/grow_gaussian.h"
#include "tools/clouds/grow_l_system.h"
#include "tools/clouds/grow_mesh.h"
#include "tools/clouds/grow_metaballs.h"
#include "tools/clouds/mesh_reader.h"
#include "tools/clouds/repeatable.h"
#include "tools/clouds/solid_fill.h"

using namespace nephele;
using namespace nephele::clouds;

namespace {

std::vector<Triangle> quads(const std::vector<std::array<glm::dvec3, 4>>& faces) {
  std::vector<Triangle> triangles;
  for (const auto& face : faces) {
    triangles.push_back({face[0], face[1], face[2]});
    triangles.push_back({face[0], face[2], face[3]});
  }
  return triangles;
}

// Around the z axis; tube 0: a sphere of the ring's radius.
std::vector<Triangle> torus(double ring, double tube) {
  constexpr int kAround = 64, kTube = 48;
  const auto point = [&](int i, int j) {
    const double a = 2.0 * std::numbers::pi * i / kAround;
    const double b = (tube > 0.0 ? 2.0 : 1.0) * std::numbers::pi * j / kTube;
    const double out = tube > 0.0 ? ring + tube * std::cos(b) : ring * std::sin(b);
    return glm::dvec3(out * std::cos(a), out * std::sin(a), tube > 0.0 ? tube * std::sin(b) : ring * std::cos(b));
  };
  std::vector<std::array<glm::dvec3, 4>> faces;
  for (int i = 0; i < kAround; ++i)
    for (int j = 0; j < kTube; ++j)
      faces.push_back({point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)});
  return quads(faces);
}

bool inside(const SetParticle& p, const glm::dvec3& place) {
  const glm::dvec3 q = (place - glm::dvec3(p.center_m)) / glm::dvec3(p.diagonal_m);
  return glm::dot(q, q) < 1.0;
}

bool covered(const ParticleSet& set, const glm::dvec3& place) {
  return std::any_of(set.particles.begin(), set.particles.end(), [&](const auto& p) { return inside(p, place); });
}

double area_at(const ParticleSet& set, double z) {
  int hits = 0;
  for (int j = -30; j <= 30; ++j)
    for (int i = -30; i <= 30; ++i) hits += covered(set, {i * 40.0, j * 40.0, z});
  return hits * 1600.0;
}

bool same(const ParticleSet& a, const ParticleSet& b) {
  return a.particles.size() == b.particles.size() && a.parameters == b.parameters &&
         std::memcmp(a.particles.data(), b.particles.data(), a.particles.size() * sizeof(SetParticle)) == 0;
}

// Holds for every generator whose cloud has a flat base.
template <class Parameters, class Grow>
void check_cumulus(Parameters parameters, Grow grow) {
  std::vector<ParticleSet> sets;
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    CAPTURE(seed);
    parameters.seed = seed;
    const Result<ParticleSet> set = grow(parameters), again = grow(parameters);
    REQUIRE(set);
    REQUIRE(again);
    CHECK(same(*set, *again));
    CHECK(check_particle_set(*set));
    CHECK(set->shape == ParticleShape::reference);
    CHECK(set->detail == 1.0f);
    CHECK(set->coarser.empty());
    CHECK(set->base_m == 0.0f);
    CHECK(set->particles.size() >= 250);
    CHECK(set->particles.size() <= 2500);
    std::size_t crossing = 0, upright = 0;
    float low_x = 1e9f, high_x = -1e9f, top = 0.0f;
    for (const SetParticle& p : set->particles) {
      crossing += p.center_m.z - p.diagonal_m.z < 0.0f && p.center_m.z > 0.0f;
      upright += p.off_diagonal_m == glm::vec3(0.0f);
      CHECK(p.base_m == 0.0f);
      CHECK(p.center_m.z + p.diagonal_m.z > 0.0f);
      low_x = std::min(low_x, p.center_m.x - p.diagonal_m.x);
      high_x = std::max(high_x, p.center_m.x + p.diagonal_m.x);
      top = std::max(top, p.center_m.z + p.diagonal_m.z);
    }
    CHECK(upright == set->particles.size());
    CHECK(crossing >= 12);                    // a bed for the base to cut
    CHECK(std::abs(low_x + high_x) < 1e-2f);  // the origin is below the middle, to rounding at some 1000 m
    CHECK(std::abs(top - set->top_m) < 1e-2f);
    // A cumulus: broad below, a crown above.
    const double low = area_at(*set, 0.05 * top), middle = area_at(*set, 0.5 * top), high = area_at(*set, 0.9 * top);
    CHECK(low > middle);
    CHECK(middle > high);
    CHECK(high > 0.0);
    sets.push_back(*set);
  }
  // Two seeds are two clouds: on a lattice of places at least a fifth of what either covers is the other's air.
  for (std::size_t i = 1; i < sets.size(); ++i) {
    int either = 0, both = 0;
    for (int x = -10; x <= 10; ++x)
      for (int y = -10; y <= 10; ++y)
        for (int z = 0; z < 10; ++z) {
          const glm::dvec3 place(x * 80.0, y * 80.0, 40.0 + z * 100.0);
          const bool first = covered(sets[0], place), second = covered(sets[i], place);
          either += first || second;
          both += first && second;
        }
    CHECK(both < 0.8 * either);
  }
}

template <class Parameters>
std::string refusal(const std::string& text, void (*read)(JsonObject&, Parameters&)) {
  const Result<nlohmann::json> document = parse_json(text, "p.json");
  REQUIRE(document);
  JsonReader reader("p.json");
  JsonObject root = reader.root(*document);
  Parameters parameters;
  read(root, parameters);
  root.finish();
  return reader.error() ? reader.error()->message : "";
}

}  // namespace

TEST_CASE("repeatable: the sequence is that of the published hash, whatever the machine") {
  // hash_uvec2({count, stream}, seed) written out, as a table of its first values would only repeat itself.
  const auto hash = [](std::uint32_t x) {
    const std::uint32_t state = x * 747796405u + 2891336453u;
    const std::uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
  };
  RandomSequence sequence(5, 9);
  for (std::uint32_t i = 0; i < 100; ++i)
    CHECK(sequence.unit() == static_cast<double>(hash(9 + hash(i + hash(5)))) / 4294967296.0);
}

TEST_CASE("repeatable: functions of additions and products are the functions they stand for") {
  for (double x = 0.0; x < 120.0; x += 0.37) {
    CAPTURE(x);
    // (1 - x/n)^n = e^-x (1 - x^2 / 2n + ...), n = 8192.
    CHECK(std::abs(falling_exponential(x) - std::exp(-x)) <= std::exp(-x) * x * x / 8192.0 + 1e-15);
  }
  for (double angle = -20.0; angle < 20.0; angle += 0.0371) {
    const SineCosine both = sine_cosine(angle);
    CHECK(std::abs(both.sine - std::sin(angle)) < 1e-9);
    CHECK(std::abs(both.cosine - std::cos(angle)) < 1e-9);
  }
}

TEST_CASE("repeatable: sizes fall with the third power, directions are of length 1 and in their band") {
  RandomSequence random(1, 1);
  constexpr int kCount = 20000;
  int small = 0;
  glm::dvec3 sum(0.0);
  for (int i = 0; i < kCount; ++i) {
    const double size = random.size(10.0, 40.0);
    CHECK((size >= 10.0 && size <= 40.0));
    small += size < 20.0;
    const glm::dvec3 direction = random.direction(-0.5, 0.5);
    CHECK(std::abs(glm::length(direction) - 1.0) < 1e-12);
    CHECK(std::abs(direction.z) <= 0.5);
    sum += direction;
  }
  // Below 20: (1/100 - 1/400) / (1/100 - 1/1600) = 0.8. Six standard deviations of a share of 20000.
  CHECK(std::abs(small / double{kCount} - 0.8) < 6.0 * std::sqrt(0.16 / kCount));
  CHECK(glm::length(sum) / kCount < 6.0 / std::sqrt(double{kCount}));
}

TEST_CASE("skin: children stand on their parents' surface, where nothing hides them, and no lower than asked") {
  std::vector<CloudBody> bodies{{{0, 0, 200}, glm::dvec3(200.0), 0.05}, {{250, 0, 200}, {150, 220, 180}, 0.05}};
  const std::vector<CloudBody> parents = bodies;
  SkinParameters skin;
  skin.generations = 1;
  skin.children = 64;
  RandomSequence random(3, 1);
  grow_skin(bodies, skin, 120.0, random);
  REQUIRE(bodies.size() > 20);
  for (std::size_t i = parents.size(); i < bodies.size(); ++i) {
    const CloudBody& child = bodies[i];
    std::array<double, 2> distance;
    for (std::size_t k = 0; k < 2; ++k)
      distance[k] = glm::length((child.center_m - parents[k].center_m) / parents[k].radius_m);
    // At place (1.1 - 0.4 share) of the parent: 0.73 to 0.85 for shares of 0.25 to 0.6; outside 0.88 of the other.
    CHECK(std::min(distance[0], distance[1]) > 0.72);
    CHECK(std::min(distance[0], distance[1]) < 0.86);
    CHECK(std::max(distance[0], distance[1]) >= 0.88);
    CHECK(child.center_m.z >= 120.0);
    CHECK(child.radius_m.z >= 0.85 * skin.smallest_m);
  }
}

TEST_CASE("skin: what overlaps nothing of the cloud is dropped") {
  std::vector<CloudBody> bodies{{{0, 0, 0}, glm::dvec3(100.0), 0.05},
                                {{900, 0, 0}, glm::dvec3(90.0), 0.05},
                                {{120, 0, 0}, glm::dvec3(60.0), 0.05}};
  keep_connected(bodies);
  REQUIRE(bodies.size() == 2);
  CHECK(bodies[1].center_m.x == 120.0);
}

TEST_CASE("grow gaussian: a cumulus with flat base and crown, other for every seed") {
  check_cumulus(GaussianParameters{}, grow_gaussian);
}

TEST_CASE("grow l_system: a cumulus with flat base and crown, other for every seed") {
  check_cumulus(LSystemParameters{}, grow_l_system);
}

TEST_CASE("grow metaballs: a cumulus with flat base and crown, other for every seed") {
  check_cumulus(MetaballParameters{}, grow_metaballs);
}

TEST_CASE("grow l_system: the published grammar leaves 128 bodies after 7 generations") {
  const std::string file = concat(NEPHELE_SOURCE_DIR, "/tools/clouds/examples/published_l_system.json");
  const Result<nlohmann::json> document = parse_json(test::read_file(file), file);
  REQUIRE(document);
  JsonReader reader(file);
  JsonObject root = reader.root(*document);
  LSystemParameters parameters;
  read_l_system(root, parameters);
  root.finish();
  REQUIRE_FALSE(reader.error());
  for (std::uint32_t generations = 0; generations <= 7; ++generations) {
    parameters.generations = generations;  // each X and each Y becomes two letters
    const Result<std::vector<CloudBody>> bodies = turtle_bodies(parameters);
    REQUIRE(bodies);
    CHECK(bodies->size() == std::size_t{1} << generations);
  }
  RandomSequence random(1, 1);
  parameters.generations = 2;
  CHECK(*expand_grammar(parameters, random) == "X+Y+X&Y");
}

TEST_CASE("grow l_system: the turtle turns as its signs say, and brackets bring it back") {
  LSystemParameters p;
  p.rules.clear();
  p.angle_deg = 90.0;
  p.angle_spread_deg = p.step_spread = p.radius_spread = 0.0;
  p.step_m = 100.0;
  const auto ends_at = [&](const char* axiom, const glm::dvec3& place) {
    CAPTURE(axiom);
    p.axiom = axiom;
    const Result<std::vector<CloudBody>> bodies = turtle_bodies(p);
    REQUIRE(bodies);
    CHECK(glm::length(bodies->back().center_m - place) < 1e-6);
  };
  ends_at("F", {0, 100, 0});  // north
  ends_at("+F", {-100, 0, 0});
  ends_at("-F", {100, 0, 0});
  ends_at("^F", {0, 0, 100});
  ends_at("&F", {0, 0, -100});
  ends_at("/+F", {0, 0, 100});  // the left side has gone up
  ends_at("\\+F", {0, 0, -100});
  ends_at("[^FFF]F", {0, 100, 0});
  ends_at("f\"F", {0, 100 + 100 * p.step_shrink, 0});
}

TEST_CASE("grow l_system: a grammar that explodes is an error, not an end of memory") {
  LSystemParameters p;
  p.axiom = std::string("F");
  p.rules = {{"F", "FFFFFFFF", 1.0}};
  p.generations = 30;
  const Result<ParticleSet> set = grow_l_system(p);
  REQUIRE_FALSE(set);
  CHECK(set.error().message.find("generations is 30") != std::string::npos);
}

TEST_CASE("grow metaballs: a lone ball's surface is at its radius, and its reach ends at three") {
  const std::vector<Metaball> ball{{{10, 20, 30}, 50.0}};
  CHECK(std::abs(metaball_field(ball, {60, 20, 30}) - 1.0) < 1e-12);
  CHECK(metaball_field(ball, {10, 20, 30 + 49}) > 1.0);
  CHECK(metaball_field(ball, {10, 20, 30 + 51}) < 1.0);
  CHECK(metaball_field(ball, {10, 20 + 150, 30}) == 0.0);
  CHECK(metaball_field(ball, {10, 20 + 149, 30}) < 1e-3);  // and ends smoothly
}

TEST_CASE("solid: depths are the distances to the nearest cell outside") {
  const Result<SolidLattice> made = lattice_around(glm::dvec3(0.0), glm::dvec3(12.0, 10.0, 9.0), 3.0);
  REQUIRE(made);
  SolidLattice solid = *made;
  RandomSequence random(2, 2);
  for (int z = 1; z + 1 < solid.size.z; ++z)
    for (int y = 1; y + 1 < solid.size.y; ++y)
      for (int x = 1; x + 1 < solid.size.x; ++x) solid.inside[solid.at(x, y, z)] = random.unit() < 0.97;
  const std::vector<float> depths = depths_m(solid);
  for (int z = 0; z < solid.size.z; ++z)
    for (int y = 0; y < solid.size.y; ++y)
      for (int x = 0; x < solid.size.x; ++x) {
        double nearest = 1e9;
        for (int c = 0; c < solid.size.z; ++c)
          for (int b = 0; b < solid.size.y; ++b)
            for (int a = 0; a < solid.size.x; ++a)
              if (!solid.inside[solid.at(a, b, c)])
                nearest = std::min(nearest, glm::length(glm::dvec3(a - x, b - y, c - z)));
        const double expected = nearest > 0.0 ? nearest - 0.5 : 0.0;
        CHECK(std::abs(depths[solid.at(x, y, z)] - expected) < 1e-4);
      }
}

TEST_CASE("grow mesh: a sphere is filled, and nothing stands out of it by more than its bumps") {
  MeshParameters p;
  p.width_m = 1000.0;
  p.up = UpAxis::z;
  p.skin.generations = 0;
  const Result<ParticleSet> set = grow_mesh(p, torus(1.0, 0.0));
  REQUIRE(set);
  CHECK(check_particle_set(*set));
  // The set is moved so that its lowest body rests at 0: find the sphere's middle from the extents, which differ from
  // the sphere's by at most what stands out on either side.
  const double out = std::max(p.fill.smallest_body_m, p.fill.bump_height * p.fill.largest_bump_m) +
                     std::sqrt(3.0) * p.fill.smallest_body_m / 3.0;
  const glm::dvec3 middle(0.0, 0.0, 0.5 * set->top_m);
  RandomSequence random(4, 4);
  int in = 0, filled = 0, beyond = 0, stray = 0;
  for (int i = 0; i < 12000; ++i) {
    const glm::dvec3 q(random.between(-900, 900), random.between(-900, 900), random.between(-900, 900));
    const double radius = glm::length(q);
    // The middle is known to `out` alone; half of it would be a coincidence, so both bounds leave all of it.
    if (radius < 500.0 - out) {
      ++in;
      filled += covered(*set, middle + q);
    } else if (radius > 500.0 + 2.0 * out) {
      ++beyond;
      stray += covered(*set, middle + q);
    }
  }
  REQUIRE(in > 300);
  REQUIRE(beyond > 300);
  CHECK(filled >= 0.97 * in);
  CHECK(stray == 0);
}

TEST_CASE("grow mesh: what is inside of a sphere is what its formula says, of a torus too, whose hole stays open") {
  const double body = 60.0, cell = body / 3.0;
  for (const bool ring : {false, true}) {
    const auto triangles = ring ? torus(600.0, 200.0) : torus(500.0, 0.0);
    const Result<SolidLattice> solid = solid_of_triangles(triangles, body);
    REQUIRE(solid);
    for (int z = 0; z < solid->size.z; ++z)
      for (int y = 0; y < solid->size.y; ++y)
        for (int x = 0; x < solid->size.x; ++x) {
          const glm::dvec3 p = solid->middle({x, y, z});
          const double distance = ring ? std::hypot(std::hypot(p.x, p.y) - 600.0, p.z) - 200.0 : glm::length(p) - 500.0;
          // Facets lie inside the round surface by at most r (1 - cos(pi / 48)), 2 m here; a thousandth more for
          // floats.
          if (std::abs(distance) > 4.0) CHECK(bool(solid->inside[solid->at(x, y, z)]) == (distance < 0.0));
        }
  }
  MeshParameters p;
  p.up = UpAxis::z;
  p.width_m = 1600.0;
  const Result<ParticleSet> set = grow_mesh(p, torus(600.0, 200.0));
  REQUIRE(set);
  for (double z = -400.0; z < 800.0; z += cell) CHECK_FALSE(covered(*set, {0.0, 0.0, z}));
  CHECK(set->particles.size() < 4000);
}

TEST_CASE("grow mesh: y up and z up are the same cloud turned") {
  MeshParameters p;
  p.fill.smallest_body_m = 90.0;
  std::vector<Triangle> lying = torus(1.0, 0.4), standing = lying;
  for (Triangle& triangle : standing)
    for (glm::dvec3& corner : triangle) corner = {corner.x, corner.z, -corner.y};
  p.up = UpAxis::z;
  const Result<ParticleSet> by_z = grow_mesh(p, lying);
  p.up = UpAxis::y;
  const Result<ParticleSet> by_y = grow_mesh(p, standing);
  REQUIRE(by_z);
  REQUIRE(by_y);
  REQUIRE(by_z->particles.size() == by_y->particles.size());
  CHECK(std::memcmp(by_z->particles.data(), by_y->particles.data(), by_z->particles.size() * sizeof(SetParticle)) == 0);
}

TEST_CASE("grow mesh: what encloses nothing is an error") {
  const Result<ParticleSet> set = grow_mesh(MeshParameters{}, {{{glm::dvec3(0), {1, 0, 0}, {0, 1, 0}}}});
  REQUIRE_FALSE(set);
  CHECK(set.error().message.find("encloses nothing") != std::string::npos);
}

TEST_CASE("generators' parameter files: a fault is one line that names key, value and what is accepted") {
  const auto names = [](const std::string& line, const std::string& part) {
    CAPTURE(line);
    CHECK(line.starts_with("p.json: "));
    CHECK(line.find(part) != std::string::npos);
    CHECK(line.find('\n') == std::string::npos);
  };
  names(refusal<GaussianParameters>("{\"widht_m\": 1}", read_gaussian), "widht_m");
  names(refusal<GaussianParameters>("{\"width_m\": 1}", read_gaussian), "width_m is 1; accepted: a number from 200");
  names(refusal<GaussianParameters>("{\"smallest_tower_m\": 500}", read_gaussian), "smallest_tower_m");
  names(refusal<GaussianParameters>("{\"skin\": {\"generations\": 9}}", read_gaussian), "skin.generations is 9");
  names(refusal<GaussianParameters>("{\"skin\": {\"largest_share\": 0.1}}", read_gaussian), "skin.largest_share");
  names(refusal<LSystemParameters>("{\"axiom\": \"F]\"}", read_l_system), "axiom");
  names(refusal<LSystemParameters>("{\"axiom\": \"F$\"}", read_l_system), "axiom");
  names(refusal<LSystemParameters>("{\"rules\": [{\"symbol\": \"FF\", \"becomes\": \"F\"}]}", read_l_system),
        "rules[0].symbol");
  names(refusal<LSystemParameters>("{\"rules\": [{\"symbol\": \"F\"}]}", read_l_system), "rules[0].becomes");
  names(refusal<MetaballParameters>("{\"fill\": {\"smallest_bump_m\": 900}}", read_metaballs), "fill.smallest_bump_m");
  names(refusal<MeshParameters>("{\"up\": \"x\"}", read_mesh_parameters), "up is \"x\"");
}

TEST_CASE("docs/generators.md: the tables of keys are the readers' own") {
  std::vector<JsonKey> keys;
  const auto add = [&]<class Parameters>(void (*read)(JsonObject&, Parameters&)) {
    Parameters parameters;
    const std::vector<JsonKey> own = JsonReader::keys_of([&](JsonObject& json) { read(json, parameters); });
    keys.insert(keys.end(), own.begin(), own.end());
  };
  add(read_gaussian);
  add(read_l_system);
  add(read_metaballs);
  add(read_mesh_parameters);
  const std::string file = concat(NEPHELE_SOURCE_DIR, "/docs/generators.md");
  test::check_key_table(test::key_table_rows(test::read_file(file)), keys);
}

TEST_CASE("generators: a set's parameters are a parameter file that makes the set again") {
  const auto again = [](auto parameters, auto read, auto grow) {
    parameters.seed = 77;
    const Result<ParticleSet> set = grow(parameters);
    REQUIRE(set);
    const Result<nlohmann::json> document = parse_json(set->parameters, "p.json");
    REQUIRE(document);
    JsonReader reader("p.json");
    JsonObject root = reader.root(*document);
    decltype(parameters) read_back;
    read(root, read_back);
    root.finish();
    if (reader.error()) FAIL(reader.error()->message);
    const Result<ParticleSet> second = grow(read_back);
    REQUIRE(second);
    CHECK(same(*set, *second));
  };
  GaussianParameters gaussian;
  gaussian.width_m = 1234.5;
  again(gaussian, read_gaussian, grow_gaussian);
  LSystemParameters grammar;
  grammar.rules.push_back({"T", "FF", 0.25});
  again(grammar, read_l_system, grow_l_system);
  again(MetaballParameters{}, read_metaballs, grow_metaballs);
}

TEST_CASE("mesh files: whole ones are read, damaged and wrong ones are one line each") {
  const test::TempDirectory directory;
  const std::string file = directory / "m.obj";
  const std::string whole = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nf 1 2 3 4\nf 1 2 5\n";
  test::write_file(file, whole);
  const Result<std::vector<Triangle>> triangles = read_mesh(file);
  REQUIRE_MESSAGE(triangles, triangles.error().message);
  CHECK(triangles->size() == 3);
  const auto refused = [](const std::string& path, const std::string& part) {
    const Result<std::vector<Triangle>> result = read_mesh(path);
    REQUIRE_FALSE(result);
    CAPTURE(result.error().message);
    CHECK(result.error().message.starts_with(path));
    CHECK(result.error().message.find(part) != std::string::npos);
    CHECK(result.error().message.find('\n') == std::string::npos);
  };
  refused(directory / "none.obj", "can't be opened");
  refused(directory / "m.stl", ".obj or .ply");
  test::write_file(file, "");
  refused(file, "");
  test::write_file(file, "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  refused(file, "no triangle with an area");
  test::write_file(file, "v 0 0 0\nv nan 0 0\nv 2 1 0\nf 1 2 3\n");
  refused(file, "");
  std::string many = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (std::size_t i = 0; i <= kMaxTriangles; ++i) many += "f 1 2 3\n";
  test::write_file(file, many);
  refused(file, "accepted: at most 200000");
  // Whatever the bytes: triangles or one line, and this process lives.
  std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n";
  RandomSequence random(6, 6);
  for (int i = 0; i < 60; ++i) {
    const bool first = i % 2 == 0;
    std::string bytes = first ? whole : ply;
    for (int k = 0; k < 3; ++k)
      bytes[random.index(static_cast<std::uint32_t>(bytes.size()))] = static_cast<char>(random.index(256));
    bytes.resize(bytes.size() - random.index(20));
    const std::string path = directory / (first ? "f.obj" : "f.ply");
    test::write_file(path, bytes);
    const Result<std::vector<Triangle>> result = read_mesh(path);
    if (!result) CHECK(result.error().message.find('\n') == std::string::npos);
  }
}
