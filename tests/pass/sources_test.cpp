// Many sources of clouds in one scene: what each puts into the particle buffer is what it would put there alone.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "passes/nephele.h"
#include "passes/sources/listed_source.h"
#include "shared/ellipsoid.h"
#include "tests/support/field_run.h"
#include "tests/support/shapes.h"
#include "tests/support/source_scenes.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using nephele::shared::Particle;
using nephele::test::cloud_view;
using nephele::test::kSmall;
using nephele::test::only;
using nephele::test::ParticleRun;
using nephele::test::run_scene;
using nephele::test::same_bytes;
using nephele::test::SourcesRun;
using nephele::test::test_sky;

namespace {

constexpr std::uint32_t kSourceBits = 0xffffu << shared::kParticleSourceShift;

ListedParticle listed_at(const glm::dvec3& center_m) {
  ListedParticle particle;
  particle.center_m = center_m;
  particle.ellipsoid = shared::upright_shape({100.0f, 80.0f, 60.0f}, 0.5f);
  particle.density = 0.5f;
  return particle;
}

ParticleGroup heap(const Placement& placement) {
  ParticleGroup group{.particles = {}, .placement = placement};
  for (int i = 0; i < 150; ++i) {
    const int column = i % 13, row = i / 13;
    group.particles.push_back(listed_at({30.0 * column, 40.0 * row, 500.0 + 5.0 * i}));
    group.particles.back().base_m = 450.0f;
    group.particles.back().top_m = 1400.0f;
  }
  return group;
}

CloudSettings field(std::uint32_t seed, float base_m, glm::dvec2 wind_m_per_s = {0, 0}) {
  return {.seed = seed, .base_m = base_m, .wind_m_per_s = wind_m_per_s, .view_distance_m = 9000.0f};
}

}  // namespace

TEST_CASE("a scene of two fields, a set and listed particles has the particles of each alone, one after another") {
  const Placement place{.at_m = {800, 300, 200}, .heading_rad = 0.4, .scale = 1.5, .drifts = true};
  Scene listed;
  listed.clouds.reset();
  for (int i = 0; i < 70; ++i) listed.particles.push_back(listed_at({50.0 * i, 400.0, 1500.0}));
  Scene all = listed;
  all.clouds = field(1, 1200.0f, {7, -3});
  all.sources = {field(2, 3000.0f), heap(place), field(3, 600.0f, {-20, 0})};
  std::vector<Scene> each = {listed, only(field(1, 1200.0f, {7, -3})), only(field(2, 3000.0f)), only(heap(place)),
                             only(field(3, 600.0f, {-20, 0}))};
  std::get<ParticleGroup>(each[3].sources[0]).placement.wind_m_per_s = {7,
                                                                        -3};  // the first field's, which is not there
  const glm::dvec3 camera_m(150.0, -90.0, 1700.0);
  constexpr double kTimeS = 345.5;
  const ParticleRun together = run_scene(all, camera_m, kTimeS);
  REQUIRE(together.records.size() == each.size());
  std::uint32_t first = 0;
  for (std::uint32_t i = 0; i < each.size(); ++i) {
    CAPTURE(i);
    const ParticleRun alone = run_scene(each[i], camera_m, kTimeS);
    const shared::SourceRecord& record = together.records[i];
    CHECK(record.first == first);
    CHECK(record.count == alone.counters.particle_count);
    CHECK(record.demand == alone.counters.particle_demand);
    CHECK(record.groups == glm::uvec3((record.count + 63) / 64, 1, 1));
    CHECK(record.extinction_per_m == alone.records[0].extinction_per_m);
    REQUIRE(record.count > 60);
    first += record.count;
    std::vector<Particle> own(together.particles.begin() + record.first, together.particles.begin() + first);
    std::uint32_t foreign = 0;
    for (Particle& particle : own) {
      foreign += (particle.flags >> shared::kParticleSourceShift) != i;
      particle.flags &= ~kSourceBits;
    }
    CHECK(foreign == 0);
    CHECK(same_bytes(own, alone.particles));
  }
  CHECK(together.counters.particle_count == first);
  CHECK(together.counters.particle_groups == glm::uvec3((first + 63) / 64, 1, 1));
}

TEST_CASE("each source has its own room and counts what finds none") {
  const ParticleGroup group = heap({});
  SourcesRun all([&](Workshop& make) {
    std::vector<std::unique_ptr<CloudSource>> sources;
    sources.push_back(std::make_unique<ListedSource>(make, "set", group, glm::dvec2(0), glm::dvec2(0), 20u));
    sources.push_back(std::make_unique<test::GivenField>(make, test::cloud_frame(), 500));
    sources.push_back(std::make_unique<ListedSource>(make, "set_2", group, glm::dvec2(0), glm::dvec2(0), 1000u));
    return sources;
  });
  CHECK(all.pass().capacity() == 20 + 500 + 150);
  const ParticleRun run = all.run(cloud_view());
  CHECK(run.records[0].count == 20);
  CHECK(run.records[0].demand == 150);
  CHECK(run.records[1].first == 20);
  CHECK(run.records[1].count <= 500);
  CHECK(run.records[1].count > 0);
  CHECK(run.records[1].demand > 10000);
  CHECK(run.records[2].count == 150);
  CHECK(run.records[2].demand == 150);
  CHECK(run.counters.particle_demand == 150 + run.records[1].demand + 150);
  CHECK(run.counters.particle_count == 20 + run.records[1].count + 150);
  const std::vector<Particle> last(run.particles.end() - 150, run.particles.end() - 130);
  std::vector<Particle> first(run.particles.begin(), run.particles.begin() + 20);
  for (Particle& particle : first) particle.flags |= 2u << shared::kParticleSourceShift;
  CHECK(same_bytes(first, last));
}

TEST_CASE("a placed group stands, turns and grows where it is told") {
  ParticleGroup group{.particles = {listed_at({0.0, 100.0, 50.0})}, .placement = {}};
  group.particles[0].base_m = 20.0f;
  group.particles[0].top_m = 400.0f;
  group.particles[0].orientation = glm::vec4(0.0f, 0.0f, 1.0f, 0.0f);
  const glm::dvec3 camera_m(1000.0, -500.0, 1500.0);
  group.placement = {.at_m = {1100.0, -200.0, 900.0}, .heading_rad = M_PI / 2, .scale = 2.0};
  const ParticleRun run = run_scene(only(group), camera_m);
  REQUIRE(run.particles.size() == 1);
  const Particle& p = run.particles[0];
  // North in the set is east in the world.
  const glm::vec3 exact = shared::render_from_offset(
      glm::vec3(glm::dvec3(1100.0 + 200.0, -200.0, 900.0 + 100.0) - camera_m), static_cast<float>(camera_m.z));
  CHECK(glm::length(p.center_m - exact) < 2e-4f);
  // North in the group is east in the world: its axes turn along, twice as long.
  const glm::dmat3 turn(0, -1, 0, 1, 0, 0, 0, 0, 1);
  const glm::dmat3 own = test::matrix_of(group.particles[0].ellipsoid), shape = test::matrix_of(p.shape);
  const glm::dmat3 expected = 2.0 * turn * own * glm::transpose(turn);
  for (int k = 0; k < 3; ++k) CHECK(glm::length(shape[k] - expected[k]) < 1e-4);
  CHECK(p.extinction_per_m == 0.5f * 0.05f / 2.0f);
  CHECK(p.base_m == 940.0f);
  CHECK(p.top_m == 1700.0f);
  // What is inside turns along: half a turn about the vertical, and a quarter of one clockwise.
  const glm::vec4 q = shared::unpack_orientation(p.orientation);
  CHECK(glm::length(shared::quaternion_rotate(q, {1, 0, 0}) - glm::vec3(0, 1, 0)) < 0.02f);
  CHECK(run.records[0].extinction_per_m == p.extinction_per_m);
}

TEST_CASE("what drifts is what a camera sees that moves against the wind") {
  const Placement still{.at_m = {900, 500, 100}};
  Placement drifting = still;
  drifting.drifts = true;
  Scene scene = only(heap(drifting));
  scene.sources.emplace_back(field(4, 1200.0f, {12.5, -3.25}));
  const glm::dvec3 camera_m(0, 0, 1500), moved_m(-12.5 * 1024, 3.25 * 1024, 1500);
  const ParticleRun later = run_scene(scene, camera_m, 1024.0), moved = run_scene(scene, moved_m, 0.0);
  CHECK(later.records[0].count == 150);
  CHECK(same_bytes(later.particles, moved.particles));
  // One that does not drift stays; one with a wind of its own goes with that.
  const ParticleRun standing = run_scene(only(heap(still)), camera_m, 1024.0);
  CHECK(same_bytes(standing.particles, run_scene(only(heap(still)), camera_m, 0.0).particles));
  drifting.wind_m_per_s = {2.0, 1.0};
  const ParticleRun own = run_scene(only(heap(drifting)), camera_m, 1024.0);
  CHECK(same_bytes(own.particles, run_scene(only(heap(still)), {-2048, -1024, 1500}).particles));
}

TEST_CASE("listed particles come first, in world space without loss") {
  for (const double far_m : {0.0, 1e7}) {
    CAPTURE(far_m);
    const glm::dvec3 camera_m(far_m + 10.25, -far_m, 1500.0);
    Scene scene;
    scene.clouds = field(1, 1200.0f);
    for (int i = 0; i < 200; ++i)
      scene.particles.push_back(listed_at(camera_m + glm::dvec3(3.0 * i, 500.0 + i, -10.0 * (i % 7))));
    scene.particles[1].radiance = glm::vec3(1, 2, 3);
    scene.particles[2].shape = ParticleShape::homogeneous;
    scene.particles[3].density = 0.0f;
    const ParticleRun run = run_scene(scene, camera_m);
    REQUIRE(run.particles.size() > 1000);
    for (std::size_t i = 0; i < scene.particles.size(); ++i) {
      const ListedParticle& listed = scene.particles[i];
      const Particle& p = run.particles[i];
      const glm::vec3 exact = shared::render_from_offset(glm::vec3(listed.center_m - camera_m), 1500.0f);
      CHECK(glm::length(p.center_m - exact) < 2e-4f);  // 900 m in floats
      CHECK(p.extinction_per_m == listed.density * listed.extinction_per_m);
      CHECK(p.base_m == shared::kNoBaseM);
      CHECK(p.top_m == doctest::Approx(listed.center_m.z + 60.0));
    }
    CHECK(run.particles[0].flags == shared::kParticleDetail);
    CHECK(run.particles[1].flags == (shared::kParticleEmissive | shared::kParticleDetail));
    CHECK(run.particles[1].radiance_per_sr == glm::vec3(1, 2, 3));
    CHECK(run.particles[2].flags == shared::kParticleHomogeneous);
    CHECK(run.visible[0] == 0);
    CHECK(run.visible[3] == 4);  // the third has no extinction
    CHECK(run.counters.particle_demand == run.counters.particle_count);
  }
}

TEST_CASE("what sources say of their extent holds for their particles") {
  Scene scene;
  scene.clouds = field(1, 1200.0f);
  scene.sources = {heap({.at_m = {0, 0, 300}}), field(2, 4000.0f)};
  const glm::dvec3 camera_m(0, 0, 1500);
  SourcesRun sources([&](Workshop& make) { return make_sources(make, scene, kSmall); });
  const ParticleRun run = sources.run(cloud_view(), {camera_m, 0.0});
  const CloudParticles& pass = sources.pass();
  for (std::size_t i = 0; i < pass.sources().size(); ++i) {
    CAPTURE(i);
    const CloudExtent own = pass.sources()[i]->extent();
    std::uint32_t outside = 0;
    for (std::uint32_t k = run.records[i].first; k < run.records[i].first + run.records[i].count; ++k) {
      const Particle& p = run.particles[k];
      const float altitude = shared::altitude_m(p.center_m, 1500.0f);
      outside += std::max(p.base_m, altitude - shared::ellipsoid_extent(p.shape, {0, 0, 1})) < own.lowest_m - 0.1f;
      outside += altitude + shared::ellipsoid_extent(p.shape, {0, 0, 1}) > own.highest_m;
    }
    CHECK(outside == 0);
  }
  const CloudExtent all = pass.extent();
  CHECK(all.lowest_m == 750.0f);  // of the set, whose base is at 450 m over its place
}

TEST_CASE("a renderer shows all sources and tells of each") {
  Scene scene;
  scene.clouds = field(1, 1200.0f);
  for (int i = 0; i < 5; ++i) scene.particles.push_back(listed_at({60.0 * i, 700.0, 1600.0}));
  scene.sources = {field(2, 3000.0f), heap({.at_m = {0, 900, 600}}), heap({.at_m = {900, 900, 600}}),
                   heap({.at_m = {-900, 900, 600}})};
  auto renderer = Renderer::create(test_sky(), scene, kSmall);
  REQUIRE(renderer);
  (*renderer)->render(scene.camera, 10.0);
  const FrameStats& stats = (*renderer)->stats();
  const std::vector<std::string> names = {"particles", "field", "field_2", "particles_2", "particles_3", "particles_4"};
  REQUIRE(stats.sources.size() == names.size());
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    CHECK(stats.sources[i].name == names[i]);
    CHECK(stats.sources[i].overflow == 0);
    CHECK(std::count_if(stats.passes.begin(), stats.passes.end(),
                        [&](const PassTime& pass) { return pass.name == names[i]; }) == 1);
    sum += stats.sources[i].particles_generated;
  }
  CHECK(sum == stats.particles_generated);
  CHECK((*renderer)->read_particles().size() == sum);
  CHECK(stats.overflow.at("particles") == 0);

  // A camera that stands still while a set drifts by must not be shown the last frame again.
  Scene drifting = only(heap({.at_m = {0, 900, 900}, .drifts = true, .wind_m_per_s = glm::dvec2(30, 0)}));
  auto passing = Renderer::create(test_sky(), drifting, kSmall);
  REQUIRE(passing);
  (*passing)->render(drifting.camera, 0.0);
  const std::vector<float> before = (*passing)->read_layers();
  (*passing)->render(drifting.camera, 10.0);
  CHECK((*passing)->read_layers() != before);
}
