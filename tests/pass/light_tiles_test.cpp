// Light-space tile lists: conservative, ordered from the sun, deterministic, safe when full.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/support/light_scene.h"
#include "tests/support/shapes.h"

using namespace nephele;
using namespace nephele::test;
using shared::Occluder;

namespace {

struct Lists {
  std::vector<Occluder> occluders;
  std::vector<glm::uvec2> ranges;
  std::vector<std::uint32_t> list;
  FrameCounters counters;

  bool contains(std::uint32_t tile, std::uint32_t particle) const {
    const auto begin = list.begin() + ranges[tile].x, end = list.begin() + ranges[tile].y;
    return std::find(begin, end, particle) != end;
  }
};

Lists build(const LightScene& scene, std::uint32_t pair_capacity) {
  Workshop make(test_kernels());
  LightTiles tiles(make, scene.particle_capacity(), pair_capacity);
  FrameBuilder frame(test_device());
  const LightTileLists built = tiles.add(frame, scene.constants, scene.particles, scene.counters);
  FrameExecutor(test_device()).run(frame);
  Lists lists;
  lists.counters = scene.read_counters();
  for (const shared::PackedOccluder& packed :
       built.occluders.read_vector<shared::PackedOccluder>(scene.particles_value.size()))
    lists.occluders.push_back(shared::unpack_occluder(packed));
  lists.ranges = built.ranges.read_vector<glm::uvec2>(shared::kLightTiles * shared::kLightTiles);
  lists.list = built.list.read_vector<std::uint32_t>(lists.counters.tile_pair_count);
  return lists;
}

LightScene field(std::uint32_t seed, std::uint32_t count, double elevation_deg) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> exponent(2.5f, 5.3f);
  std::vector<Particle> particles(count);
  for (Particle& particle : particles) {
    const float range = std::pow(10.0f, exponent(random));  // from beside the camera to beyond the grid
    particle = random_particle(random, range);
    particle.shape = test::scaled(particle.shape, std::max(1.0f, range / 10000.0f));
  }
  return LightScene(light_constants(220, elevation_deg), particles, {});
}

}  // namespace

TEST_CASE("tile lists hold every particle that a ray through the tile meets, from the sun on") {
  for (double elevation : {90.0, 35.0, 2.0, 0.0, -3.0}) {
    CAPTURE(elevation);
    const LightScene scene = field(17, 700, elevation);
    const Lists lists = build(scene, 400000);
    REQUIRE(lists.counters.tile_pair_demand == lists.counters.tile_pair_count);
    CHECK(lists.counters.tile_pair_groups == glm::uvec3((lists.counters.tile_pair_count + 63) / 64, 1, 1));

    // Any point of any particle finds that particle in its tile.
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    for (std::uint32_t i = 0; i < scene.particles_value.size(); ++i)
      for (int k = 0; k < 30; ++k) {
        const glm::vec3 on_sphere = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
        const glm::vec3 point = shared::particle_point(scene.particles_value[i], on_sphere);
        const glm::vec3 light = scene.constants_value.light_from_render * point;
        const std::uint32_t tile = shared::light_tile_index(shared::light_tile(glm::vec2(light), 80000.0f));
        REQUIRE_MESSAGE(lists.contains(tile, i), "particle ", i);
      }

    // Ranges cut the list into pieces without gap or overlap, each in order from the sun and without repetition.
    std::uint32_t next = 0;
    for (const glm::uvec2 range : lists.ranges) {
      if (range.x == range.y) continue;
      REQUIRE(range.x == next);
      next = range.y;
      std::set<std::uint32_t> seen;
      std::uint32_t key = 0;
      for (std::uint32_t i = range.x; i < range.y; ++i) {
        seen.insert(lists.list[i]);
        const float top = lists.occluders[lists.list[i]].top_m;
        // Keys of the device's logarithm may differ by one from the host's.
        REQUIRE(shared::sun_key(top, 80000.0f) + 1 >= key);
        key = std::max(key, shared::sun_key(top, 80000.0f));
      }
      REQUIRE(seen.size() == range.y - range.x);
    }
    CHECK(next == lists.counters.tile_pair_count);
  }
}

TEST_CASE("tile lists: the device sees a particle as the host does") {
  const LightScene scene = field(29, 300, 20.0);
  const Lists lists = build(scene, 200000);
  for (std::size_t i = 0; i < scene.particles_value.size(); ++i) {
    shared::LightBounds bounds;
    const Occluder expected =
        shared::make_occluder(scene.particles_value[i], scene.constants_value.light_from_render, 1500.0f, bounds);
    const Occluder& occluder = lists.occluders[i];
    // Float rounding, and sin and cos of the yaw (device: 2^-11 absolute at worst, some 1e-6 here).
    const float size = bounds.extent_m.x + bounds.extent_m.y + bounds.extent_m.z;
    CHECK(glm::length(occluder.center_m - expected.center_m) < 1e-6f * glm::length(expected.center_m) + 1e-3f);
    CHECK(std::abs(occluder.top_m - expected.top_m) < 2e-5f * (size + std::abs(expected.top_m)) + 1e-3f);
    CHECK(glm::length(occluder.shape_per_m2 - expected.shape_per_m2) < 2e-4f * glm::length(expected.shape_per_m2));
    CHECK(std::abs(occluder.half_m - expected.half_m) < 2e-4f * expected.half_m);
    CHECK(glm::length(occluder.slope - expected.slope) < 2e-4f * (1.0f + glm::length(expected.slope)));
    CHECK(occluder.extinction_per_m == expected.extinction_per_m);
    CHECK(occluder.flags == expected.flags);
  }
}

TEST_CASE("tile lists: no particles, and particles without extinction") {
  const LightScene nothing(light_constants(220, 35), {}, {});
  CHECK(build(nothing, 100).counters.tile_pair_demand == 0);
  for (const glm::uvec2 range : build(nothing, 100).ranges) REQUIRE(range == glm::uvec2(0));

  std::mt19937 random(1);
  std::vector<Particle> two = {random_particle(random, 1000.0f), random_particle(random, 1000.0f)};
  two[0].extinction_per_m = 0.0f;
  const Lists lists = build(LightScene(light_constants(220, 35), two, {}), 1000);
  CHECK(lists.counters.tile_pair_count > 0);
  CHECK(std::count(lists.list.begin(), lists.list.end(), 0u) == 0);
}

TEST_CASE("tile lists: two runs are identical") {
  const LightScene a = field(41, 500, 10.0), b = field(41, 500, 10.0);
  const Lists one = build(a, 300000), two = build(b, 300000);
  CHECK(one.list == two.list);
  CHECK(one.ranges == two.ranges);
}

TEST_CASE("tile lists: a full pair buffer keeps what is nearest to the sun and reports the demand") {
  const LightScene scene = field(53, 400, 35.0);
  const Lists whole = build(scene, 300000);
  const std::uint32_t demand = whole.counters.tile_pair_demand;
  REQUIRE(demand > 1000);
  for (std::uint32_t capacity : {1u, demand / 3, demand - 1, demand}) {
    CAPTURE(capacity);
    const LightScene again = field(53, 400, 35.0);
    const Lists cut = build(again, capacity);
    CHECK(cut.counters.tile_pair_demand == demand);
    CHECK(cut.counters.tile_pair_count == capacity);
    std::uint32_t total = 0;
    for (std::size_t tile = 0; tile < cut.ranges.size(); ++tile) {
      const glm::uvec2 range = cut.ranges[tile], full = whole.ranges[tile];
      REQUIRE(range.y - range.x <= full.y - full.x);
      total += range.y - range.x;
      REQUIRE(std::equal(cut.list.begin() + range.x, cut.list.begin() + range.y, whole.list.begin() + full.x));
    }
    CHECK(total == capacity);
  }
}
