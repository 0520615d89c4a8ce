// Particle sets placed in the world, as the device makes them: against places found by hand, in doubles, and against
// what must hold whatever the camera.
#include "passes/sources/set_source.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "engine/particle_set.h"
#include "passes/nephele.h"
#include "tests/support/cloud_frame.h"
#include "tests/support/field_run.h"
#include "tests/support/shapes.h"
#include "tests/support/source_scenes.h"

using namespace nephele;
using namespace nephele::test;
using shared::Particle;

namespace {

// radius_m: of all particles. All such sets have the same matter.
ParticleSet cloud(int count, float radius_m) {
  ParticleSet set;
  set.top_m = 500.0f;
  for (int i = 0; i < count; ++i)
    set.particles.push_back(
        {.center_m = {40.0f * static_cast<float>(i % 5), 30.0f * static_cast<float>(i / 5), 200.0f},
         .diagonal_m = {radius_m, 0.8f * radius_m, 0.6f * radius_m},
         .off_diagonal_m = {0.1f * radius_m, -0.2f * radius_m, 0.15f * radius_m},
         .extinction_per_m = 0.02f * 40.0f * 216000.0f / (static_cast<float>(count) * radius_m * radius_m * radius_m)});
  give_particles_base_and_top(set);
  return set;
}

SetFile shared_set(ParticleSet set) { return {"x.json", std::make_shared<const ParticleSet>(std::move(set))}; }

SetFile with_levels() {
  ParticleSet set = cloud(40, 60.0f);
  set.coarser = {cloud(10, 120.0f), cloud(2, 240.0f)};
  return shared_set(std::move(set));
}

double matter(const Particle& p) {
  return static_cast<double>(p.extinction_per_m) * glm::determinant(matrix_of(p.shape));
}

double matter(const ParticleRun& run) {
  double sum = 0.0;
  for (const Particle& p : run.particles) sum += matter(p);
  return sum;
}

double matter(const ParticleSet& set) {
  double sum = 0.0;
  for (const SetParticle& p : set.particles)
    sum += static_cast<double>(p.extinction_per_m) * glm::determinant(matrix_of(p.ellipsoid()));
  return sum;
}

}  // namespace

TEST_CASE("a set's instances stand, turn and grow where they are told, here and 10 000 km out") {
  const ParticleSet set = cloud(40, 60.0f);
  for (const double far_m : {0.0, 1e7}) {
    CAPTURE(far_m);
    PlacedSet placed{.set = shared_set(set)};
    placed.placement = {.at_m = {far_m + 1000.0, -far_m, 700.0}, .heading_rad = std::numbers::pi / 2, .scale = 2.0};
    placed.instances = {{.at_m = {0.0, 300.0, 50.0}, .heading_rad = 0.7, .scale = 1.5}, {}};
    const glm::dvec3 camera_m(far_m + 200.25, -far_m - 100.0, 1500.0);
    const ParticleRun run = run_scene(only(placed), camera_m);
    REQUIRE(run.particles.size() == 80);
    for (std::size_t i = 0; i < 80; ++i) {
      const SetParticle& own = set.particles[i % 40];
      const bool first = i < 40;
      // North of the placement is east; the instance turns on from there.
      const double heading = std::numbers::pi / 2 + (first ? 0.7 : 0.0), scale = first ? 3.0 : 2.0;
      const double c = std::cos(heading), s = std::sin(heading);
      const glm::dmat3 turn(c, -s, 0, s, c, 0, 0, 0, 1);
      const glm::dvec3 origin_m = placed.placement.at_m + (first ? glm::dvec3(600.0, 0.0, 100.0) : glm::dvec3(0.0));
      const glm::dvec3 center_m = origin_m + scale * (turn * glm::dvec3(own.center_m));
      const Particle& p = run.particles[i];
      const glm::vec3 exact = shared::render_from_offset(glm::vec3(center_m - camera_m), 1500.0f);
      CHECK(glm::length(p.center_m - exact) < 1e-3f);  // 2 km in floats, turned and scaled
      const glm::dmat3 expected = scale * turn * matrix_of(own.ellipsoid()) * glm::transpose(turn);
      const glm::dmat3 shape = matrix_of(p.shape);
      for (int k = 0; k < 3; ++k) CHECK(glm::length(shape[k] - expected[k]) < 1e-4 * 180.0);
      CHECK(p.extinction_per_m == doctest::Approx(own.extinction_per_m / scale).epsilon(1e-6));
      CHECK(p.base_m == doctest::Approx(origin_m.z));
      CHECK(p.top_m == doctest::Approx(origin_m.z + scale * 500.0));
      CHECK((p.flags & 0xffffu) == shared::kParticleDetail);
    }
    // Instances are not each other's copies where noise is seeded.
    CHECK(run.particles[0].id != run.particles[40].id);
    CHECK(run.counters.particle_count == 80);
    CHECK(run.records[0].demand == 80);
  }
}

TEST_CASE("a set that drifts is what a camera sees that moves against the wind") {
  PlacedSet drifting{.set = with_levels()};
  drifting.placement = {.at_m = {900, 500, 100}, .drifts = true, .wind_m_per_s = glm::dvec2(2.0, 1.0)};
  PlacedSet still = drifting;
  still.placement.drifts = false;
  CHECK(same_bytes(run_scene(only(drifting), {0, 0, 1500}, 1024.0).particles,
                   run_scene(only(still), {-2048, -1024, 1500}).particles));
}

TEST_CASE("farther instances are drawn by coarser levels, and no matter is lost on the way") {
  const SetFile set = with_levels();
  const double whole = matter(*set.set);
  PlacedSet placed{.set = set};
  placed.placement.drifts = false;
  // Levels begin where particles of 120 and 240 m look smaller than 1.7 / 40 of the distance, 2.5 times as far apart.
  std::size_t before = 41;
  std::vector<std::size_t> counts;
  for (double away_m = 500.0; away_m < 60000.0; away_m *= 1.05) {
    CAPTURE(away_m);
    const ParticleRun run = run_scene(only(placed), {-away_m, 0, 1500});
    CHECK(matter(run) == doctest::Approx(whole).epsilon(1e-5));
    if (run.particles.size() == 50 || run.particles.size() == 12) continue;  // two levels, one fading into the other
    CHECK(run.particles.size() <= before);
    if (run.particles.size() != before) counts.push_back(run.particles.size());
    before = run.particles.size();
  }
  CHECK(counts == std::vector<std::size_t>{40, 10, 2});
}

TEST_CASE("levels fade into one another and into the distance without a jump") {
  PlacedSet placed{.set = with_levels(), .view_distance_m = 30000.0f};
  placed.placement.drifts = false;
  double before = matter(*placed.set.set);
  const double whole = before;
  std::vector<double> before_by_size(3, whole);
  // The fade over the last fifth is linear: 100 m are 1/60 of it.
  for (double away_m = 20000.0; away_m < 30500.0; away_m += 100.0) {
    const double now = matter(run_scene(only(placed), {-away_m, 0, 1500}));
    CHECK(now <= before * (1 + 1e-5));
    CHECK(before - now < whole * (1.0 / 60.0 + 1e-3 + shared::kLeastSetWeight));
    before = now;
  }
  CHECK(before == 0.0);
}

TEST_CASE("a scattered sky: the share of places that coverage says, the same for every camera and origin") {
  ScatteredSets scattered{.kinds = {{with_levels(), 3.0f}, {shared_set(cloud(7, 50.0f)), 1.0f}},
                          .clouds_per_km2 = 1.0f,
                          .altitude_m = 900.0f,
                          .drifts = false,
                          .view_distance_m = 20000.0f};
  const auto clouds_of = [&](float coverage) {
    scattered.coverage = coverage;
    const ParticleRun run = run_scene(only(scattered));
    CHECK(run.records[0].demand == run.records[0].count);  // found room
    return matter(run) / matter(*scattered.kinds[0].set.set);
  };
  // Within 20 km are 1257 places; the fade over the last fifth leaves a cone's frustum, 0.813 of them. A
  // scale s in .8 .. 1.2 makes s^2 of the matter that counts: extinction / s times s^3, in the mean 1.013.
  const double full = clouds_of(1.0f);
  CHECK(full > 0.9 * 1257 * 0.813 * 1.013);
  CHECK(full < 1.1 * 1257 * 0.813 * 1.013);
  // By place_taken the mean is (c - 0.027) / 0.96; three deviations of 1257 places' chance are 0.043 and 0.025.
  CHECK(std::abs(clouds_of(0.5f) / full - 0.493) < 0.043);
  CHECK(std::abs(clouds_of(0.1f) / full - 0.076) < 0.025);

  // The cloud at a place is the same from elsewhere: the nearest ones are found again by id, where the two views
  // overlap unfaded.
  scattered.coverage = 0.5f;
  scattered.kinds.resize(1);
  const glm::dvec3 here_m(0, 0, 1500), there_m(700.0, -400.0, 1500);
  const ParticleRun here = run_scene(only(scattered), here_m), there = run_scene(only(scattered), there_m);
  std::size_t near = 0, found = 0;
  for (const Particle& p : here.particles) {
    if (glm::length(p.center_m) > 1500.0f) continue;  // all of the finest level
    ++near;
    const glm::vec3 expected = p.center_m + glm::vec3(here_m - there_m);
    found += std::any_of(there.particles.begin(), there.particles.end(), [&](const Particle& q) {
      return q.id == p.id && glm::length(q.center_m - expected) < 1.0f;  // 2 km of curvature: 0.3 m
    });
  }
  CHECK(near > 100);
  CHECK(found == near);
}

TEST_CASE("a weather map says where scattered clouds are, and clouds come and go slowly as they drift through it") {
  WeatherMap map{.width = 2,
                 .height = 1,
                 .texels = {{255, 255}, {0, 255}},
                 .origin_m = {-16000, -16000},
                 .extent_m = {32000, 32000}};
  ScatteredSets scattered{.kinds = {{shared_set(cloud(7, 50.0f))}},
                          .clouds_per_km2 = 1.0f,
                          .coverage = 0.0f,
                          .drifts = true,
                          .wind_m_per_s = glm::dvec2(10, 0),
                          .view_distance_m = 15000.0f,
                          .weather_map = map};
  SourcesRun sources([&](Workshop& make) { return make_sources(make, only(scattered), kSmall); });
  const auto at = [&](double time_s) { return sources.run(cloud_view(CameraState{}), {{0, 0, 1500}, time_s}); };
  const ParticleRun start = at(0.0);
  double west = 0.0, east = 0.0;
  for (const Particle& p : start.particles) (p.center_m.x < 0 ? west : east) += matter(p);
  CHECK(west > 3.0 * east);
  // In 10 s a cloud drifts 100 m, through a 160th of coverage, a sixth of the way over which a place is taken: that
  // many of the places, 1 of 160, change in all, some here and some there.
  double before = matter(start);
  for (double time_s = 10.0; time_s < 100.0; time_s += 10.0) {
    const double now = matter(at(time_s));
    CHECK(std::abs(now - before) < 0.02 * before);
    before = now;
  }
}

TEST_CASE("what a set's source says of its extent holds for its particles") {
  PlacedSet placed{.set = with_levels()};
  placed.placement = {.at_m = {0, 0, 300}, .scale = 1.5};
  placed.instances = {{.at_m = {0, 0, 0}}, {.at_m = {3000, 0, 500}, .scale = 2.0}};
  SourcesRun sources([&](Workshop& make) { return make_sources(make, only(placed), kSmall); });
  const ParticleRun run = sources.run(cloud_view(CameraState{}), {{0, 0, 1500}, 0.0});
  const CloudSource& source = *sources.pass().sources()[0];
  const CloudExtent extent = source.extent();
  REQUIRE(source.bounds());
  for (const Particle& p : run.particles) {
    const float altitude = shared::altitude_m(p.center_m, 1500.0f);
    const float up_m = shared::ellipsoid_extent(p.shape, {0, 0, 1});
    CHECK(std::max(p.base_m, altitude - up_m) >= extent.lowest_m - 0.1f);
    CHECK(altitude + up_m <= extent.highest_m + 0.5f);
    const glm::dvec2 reach(shared::ellipsoid_extent(p.shape, {1, 0, 0}), shared::ellipsoid_extent(p.shape, {0, 1, 0}));
    CHECK(glm::all(glm::greaterThan(glm::dvec2(p.center_m) - reach, source.bounds()->low_m - 1.0)));
    CHECK(glm::all(glm::lessThan(glm::dvec2(p.center_m) + reach, source.bounds()->high_m + 1.0)));
  }
}
