// Particles of a cell: bounds, and what must survive a change of ring or of the number of layers.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

#include "shared/cloud_particles.h"
#include "tests/support/cloud_frame.h"

using namespace nephele::shared;
using nephele::test::cloud_frame;

namespace {

// All particles of one ring over a square of 2 * half_m around the grid origin, whatever the camera.
std::vector<CloudParticle> ring_particles(const FrameConstants& frame, uint ring, float half_m) {
  const CloudParams params = cloud_params(frame);
  const float cell_m = ring_cell_m(frame, ring);
  const int half = static_cast<int>(half_m / cell_m);
  std::vector<CloudParticle> particles;
  for (int y = -half; y < half; ++y)
    for (int x = -half; x < half; ++x) {
      GridCell cell;
      cell.ring = ring;
      cell.index = ivec2(x, y);
      cell.size_m = cell_m;
      cell.corner_m = vec2(cell.index) * cell_m;
      const CellParts parts = cell_parts(frame, params, cell);
      for (uint slot = 0; slot < particle_count(parts); ++slot) {
        const CloudParticle particle = cell_particle(frame, params, cell, parts, slot);
        if (particle.density > 0.0f) particles.push_back(particle);
      }
    }
  return particles;
}

struct Columns {
  double mean_depth = 0;   // of vertical rays
  double covered = 0;      // share of vertical rays with a depth above 1
  double altitude_m = 0;   // mean above the base, weighted by depth
};

// Vertical rays through the inner part of the square; particles as homogeneous ellipsoids with 0.3 of the extinction
// (the reference particle's mean fill), cut off at their bases.
Columns measure_columns(const std::vector<CloudParticle>& particles, float half_m, float base_m) {
  constexpr float kTileM = 500.0f;
  const int side = static_cast<int>(2.0f * half_m / kTileM) + 1;
  std::vector<std::vector<const CloudParticle*>> tiles(static_cast<std::size_t>(side * side));
  const auto tile = [&](float x) { return clamp(static_cast<int>((x + half_m) / kTileM), 0, side - 1); };
  for (const CloudParticle& p : particles) {
    const float reach = max(p.radius_m.x, p.radius_m.y);
    for (int y = tile(p.center_m.y - reach); y <= tile(p.center_m.y + reach); ++y)
      for (int x = tile(p.center_m.x - reach); x <= tile(p.center_m.x + reach); ++x)
        tiles[static_cast<std::size_t>(y * side + x)].push_back(&p);
  }
  std::mt19937 random(17);
  std::uniform_real_distribution<float> place(-0.8f * half_m, 0.8f * half_m);
  Columns columns;
  constexpr int kRays = 20000;
  double sum = 0;
  for (int i = 0; i < kRays; ++i) {
    const vec2 ray(place(random), place(random));
    double depth = 0;
    for (const CloudParticle* p : tiles[static_cast<std::size_t>(tile(ray.y) * side + tile(ray.x))]) {
      const vec3 unit = local_from_render(vec3(ray.x - p->center_m.x, ray.y - p->center_m.y, 0.0f), p->yaw_rad) / p->radius_m;
      const float inside = 1.0f - dot(unit, unit);
      if (inside <= 0.0f) continue;
      const float half_chord = p->radius_m.z * std::sqrt(inside);
      const float low = max(p->center_m.z - half_chord, p->base_m), high = p->center_m.z + half_chord;
      if (high <= low) continue;
      const double tau = static_cast<double>(0.04f * 0.3f * p->density * (high - low));
      depth += tau;
      sum += tau * static_cast<double>(0.5f * (low + high) - base_m);
    }
    columns.mean_depth += depth / kRays;
    columns.covered += depth > 1.0 ? 1.0 / kRays : 0.0;
  }
  columns.altitude_m = sum / (columns.mean_depth * kRays);
  return columns;
}

constexpr float kHalfM = 18000.0f;

}  // namespace

TEST_CASE("a cell's parts survive packing") {
  for (uint levels = 0; levels <= kMaxLevels; ++levels)
    for (uint turn = 0; turn <= 2u; ++turn)
      for (uint crown = 0; crown <= kMaxCrown; crown += 5u)
        for (uint depth = 0; depth <= 15u; depth += 3u) {
          const CellParts parts{levels, turn, crown, crown & 1u, depth};
          const CellParts back = unpack_parts(pack_parts(parts));
          CHECK((back.levels == levels && back.turn == turn && back.crown == crown && back.wisps == (crown & 1u) && back.depth == depth));
        }
  // Two neighbours that take turns share the levels above their bases.
  for (uint levels = 1; levels <= kMaxLevels; ++levels)
    CHECK(column_count({levels, 1u, 0u, 0u, 0u}) + column_count({levels, 2u, 0u, 0u, 0u}) == levels + 1u);
}

TEST_CASE("particles stand inside the cloud layer and near their cell") {
  for (const float thickness_m : {1.0f, 700.0f, 2400.0f, 15000.0f})
    for (uint ring = 0; ring < 4u; ++ring) {
      CAPTURE(thickness_m);
      CAPTURE(ring);
      FrameConstants frame = cloud_frame();
      frame.ring_count = 4;
      frame.thickness_m = thickness_m;
      const float cell_m = ring_cell_m(frame, ring);
      const std::vector<CloudParticle> particles = ring_particles(frame, ring, 8000.0f);
      REQUIRE(!particles.empty());
      uint bad_radius = 0, bad_density = 0, bad_place = 0, bad_top = 0;
      for (const CloudParticle& p : particles) {
        const float height = p.top_m - p.base_m;
        bad_radius += !(min(p.radius_m.x, min(p.radius_m.y, p.radius_m.z)) > 0.0f && max(p.radius_m.x, p.radius_m.y) <= 2.0f * cell_m);
        bad_density += !(p.density > 0.0f && p.density <= 3.0f);
        // Wisps fly as if every cloud were 180 m high; crown particles rise at most 0.45 of the height above it.
        bad_place += !(p.center_m.z >= p.base_m - 15.0f && p.center_m.z + p.radius_m.z <= p.base_m + max(1.45f * height, 200.0f) + 50.0f);
        bad_top += !(height >= 0.0f && height <= thickness_m * 1.0001f + 1e-3f);
      }
      CHECK(bad_radius == 0u);
      CHECK(bad_density == 0u);
      CHECK(bad_place == 0u);
      CHECK(bad_top == 0u);
    }
}

TEST_CASE("a change of ring keeps optical depth, extent and height") {
  FrameConstants frame = cloud_frame();
  frame.ring_count = 4;
  const Columns finest = measure_columns(ring_particles(frame, 0, kHalfM), kHalfM, frame.base_m);
  CHECK(finest.covered == doctest::Approx(0.36).epsilon(0.15));  // of a coverage of 0.4
  for (uint ring = 1; ring < 4u; ++ring) {
    CAPTURE(ring);
    const Columns coarse = measure_columns(ring_particles(frame, ring, kHalfM), kHalfM, frame.base_m);
    MESSAGE("ring ", ring, ": depth ", coarse.mean_depth, " (", finest.mean_depth, "), covered ", coarse.covered, " (", finest.covered,
            "), altitude ", coarse.altitude_m, " (", finest.altitude_m, ")");
    // One place a cell is tested, so that rings differ by chance as well: some 1 000 clouds are in the square.
    CHECK(coarse.mean_depth == doctest::Approx(finest.mean_depth).epsilon(0.2));
    CHECK(coarse.covered == doctest::Approx(finest.covered).epsilon(0.15));
    CHECK(std::fabs(coarse.altitude_m - finest.altitude_m) < 0.05 * static_cast<double>(frame.thickness_m));
  }
}

TEST_CASE("fewer layers keep columns closed") {
  FrameConstants frame = cloud_frame();
  frame.thickness_m = 2400.0f;
  frame.layer_count = 7;
  const Columns full = measure_columns(ring_particles(frame, 0, 8000.0f), 8000.0f, frame.base_m);
  for (const uint layers : {3u, 5u}) {
    CAPTURE(layers);
    frame.layer_count = layers;
    const Columns few = measure_columns(ring_particles(frame, 0, 8000.0f), 8000.0f, frame.base_m);
    MESSAGE("layers ", layers, ": depth ", few.mean_depth, " (", full.mean_depth, "), covered ", few.covered, " (", full.covered, ")");
    CHECK(few.mean_depth == doctest::Approx(full.mean_depth).epsilon(0.3));
    CHECK(few.covered == doctest::Approx(full.covered).epsilon(0.03));
  }
}

TEST_CASE("the same cell has the same particles from every origin") {
  const FrameConstants frame = cloud_frame();
  FrameConstants shifted = frame;
  shifted.origin_index = frame.origin_index + ivec2(1, 0);
  const CloudParams params = cloud_params(frame), params_shifted = cloud_params(shifted);
  uint same = 0, all = 0;
  for (uint ring = 0; ring < 3u; ++ring)
    for (int i = 0; i < 4000; ++i) {
      const int per_unit = static_cast<int>(ring_lattice(frame, ring));
      GridCell a;
      a.ring = ring;
      a.size_m = ring_cell_m(frame, ring);
      a.index = ivec2(i % 63 + per_unit / 2 - 30, i / 63 - 30);
      a.corner_m = vec2(a.index) * a.size_m;
      GridCell b = a;
      b.index.x -= per_unit;
      b.corner_m = vec2(b.index) * b.size_m;
      const CellParts parts = cell_parts(frame, params, a), parts_shifted = cell_parts(shifted, params_shifted, b);
      if (parts.levels == 0u && parts_shifted.levels == 0u) continue;
      ++all;
      if (pack_parts(parts) != pack_parts(parts_shifted)) continue;  // a threshold met exactly: rounding decides
      ++same;
      const CloudParticle p = cell_particle(frame, params, a, parts, particle_count(parts) - 1u);
      const CloudParticle q = cell_particle(shifted, params_shifted, b, parts, particle_count(parts) - 1u);
      CHECK(p.id == q.id);
      CHECK(std::fabs(p.center_m.x - kOriginUnitM - q.center_m.x) < 2.0f);
      CHECK(std::fabs(p.center_m.y - q.center_m.y) < 2.0f);
    }
  CHECK(all > 1000u);
  CHECK(same >= all * 99u / 100u);
}
