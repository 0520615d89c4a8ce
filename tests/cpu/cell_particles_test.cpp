// Particles of a cell: bounds, and what must survive a change of ring or of the number of layers.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "shared/cell_particles.h"
#include "shared/reference_particle.h"
#include "tests/support/cloud_frame.h"

using namespace nephele::shared;
using nephele::test::cloud_field;

namespace {

// As the particle pass finds it in its buffer.
CellCloud kept(const CellCloud& cloud, const GridCell& cell, const CloudField& field) {
  return unpack_cell(pack_cell(cloud, cell, field.thickness_m), cell, field.thickness_m);
}

// All particles of one ring over a square of 2 * half_m around the grid origin, whatever the camera.
std::vector<CloudParticle> ring_particles(const CloudField& field, uint ring, float half_m) {
  const CloudParams params = cloud_params(field);
  const float cell_m = ring_cell_m(field, ring);
  const int half = static_cast<int>(half_m / cell_m);
  std::vector<CloudParticle> particles;
  for (int y = -half; y < half; ++y)
    for (int x = -half; x < half; ++x) {
      GridCell cell;
      cell.ring = ring;
      cell.index = ivec2(x, y);
      cell.size_m = cell_m;
      cell.corner_m = vec2(cell.index) * cell_m;
      const CellCloud cloud = kept(cell_cloud(field, params, cell), cell, field);
      for (uint n = 0; n < particle_count(cloud); ++n) {
        const CloudParticle particle = cell_particle(field, params, cell, cloud, n);
        if (particle.density > 0.0f) particles.push_back(particle);
      }
    }
  return particles;
}

struct Columns {
  double depth = 0;          // mean optical depth along the rays
  double transmittance = 0;  // mean over the rays
  double altitude_m = 0;     // mean above the base, weighted by depth

  Columns& operator+=(const Columns& other) {
    depth += other.depth;
    transmittance += other.transmittance;
    altitude_m += other.altitude_m;
    return *this;
  }
};

// The mean density of the reference particle over spheres of radius r, in steps of 1/64.
const std::vector<float>& mean_profile() {
  static const std::vector<float> profile = [] {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    std::vector<float> means(65);
    for (std::size_t i = 0; i < means.size(); ++i)
      for (int k = 0; k < 400; ++k)
        means[i] +=
            reference_particle_density(
                normalize(vec3(normal(random), normal(random), normal(random))) * static_cast<float>(i) / 64.0f, 1u) /
            400.0f;
    return means;
  }();
  return profile;
}

// Parallel rays through the inner part of the square, leaning `lean` metres to the east a metre up; particles with the
// reference particle's mean profile, cut off at their bases.
Columns measure_columns(const std::vector<CloudParticle>& particles, float half_m, float base_m, float lean = 0.0f) {
  constexpr float kTileM = 500.0f;
  constexpr int kSteps = 12;
  const std::vector<float>& profile = mean_profile();
  const int side = static_cast<int>(2.0f * half_m / kTileM) + 1;
  std::vector<std::vector<const CloudParticle*>> tiles(static_cast<std::size_t>(side * side));
  const auto tile = [&](float x) { return clamp(static_cast<int>((x + half_m) / kTileM), 0, side - 1); };
  for (const CloudParticle& p : particles) {  // by where their rays cross the plane of the bases
    const float x = p.center_m.x - lean * (p.center_m.z - base_m);
    const float reach_y = max(p.radius_m.x, p.radius_m.y), reach_x = reach_y + lean * p.radius_m.z;
    for (int row = tile(p.center_m.y - reach_y); row <= tile(p.center_m.y + reach_y); ++row)
      for (int column = tile(x - reach_x); column <= tile(x + reach_x); ++column)
        tiles[static_cast<std::size_t>(row * side + column)].push_back(&p);
  }
  std::mt19937 random(17);
  std::uniform_real_distribution<float> place(-0.8f * half_m, 0.8f * half_m);
  Columns columns;
  constexpr int kRays = 20000;
  double sum = 0;
  for (int i = 0; i < kRays; ++i) {
    const vec2 foot(place(random), place(random));
    double depth = 0;
    for (const CloudParticle* p : tiles[static_cast<std::size_t>(tile(foot.y) * side + tile(foot.x))]) {
      // Points foot + z * (lean, 0, 1), z above base_m, in the unit space of the ellipsoid.
      const vec3 from = local_from_render(vec3(foot.x, foot.y, base_m) - p->center_m, p->yaw_rad) / p->radius_m;
      const vec3 step = local_from_render(vec3(lean, 0.0f, 1.0f), p->yaw_rad) / p->radius_m;
      const float middle = -dot(from, step) / dot(step, step);
      const vec3 closest = from + middle * step;
      const float inside = 1.0f - dot(closest, closest);
      if (inside <= 0.0f) continue;
      const float half_z = std::sqrt(inside / dot(step, step));
      for (int k = 0; k < kSteps; ++k) {
        const float z = middle + half_z * ((2.0f * static_cast<float>(k) + 1.0f) / kSteps - 1.0f);
        if (base_m + z < p->base_m) continue;
        const float r = 64.0f * length(from + z * step);
        const std::size_t at = static_cast<std::size_t>(min(r, 63.0f));
        const float density = mix(profile[at], profile[at + 1], min(r, 64.0f) - static_cast<float>(at));
        const double tau =
            static_cast<double>(0.04f * p->density * density * 2.0f * half_z / kSteps * std::sqrt(1.0f + lean * lean));
        depth += tau;
        sum += tau * static_cast<double>(z);
      }
    }
    columns.depth += depth / kRays;
    columns.transmittance += std::exp(-depth) / kRays;
  }
  columns.altitude_m = sum / (columns.depth * kRays);
  return columns;
}

constexpr float kHalfM = 18000.0f;

}  // namespace

TEST_CASE("a cell's n-th particle is its n-th slot") {
  CellCloud cloud{};
  for (const uint slots : {0u, 1u, 0x80000000u, 0x80008001u, 0xffffffffu}) {
    cloud.slots = slots;
    uint n = 0;
    for (uint slot = 0; slot < 32u; ++slot)
      if ((slots >> slot & 1u) != 0u) CHECK(particle_slot(cloud, n++) == slot);
    CHECK(particle_count(cloud) == n);
  }
}

TEST_CASE("particles stand inside the cloud layer and near their cell") {
  for (const float thickness_m : {1.0f, 700.0f, 2400.0f, 15000.0f})
    for (uint ring = 0; ring < 4u; ++ring) {
      CAPTURE(thickness_m);
      CAPTURE(ring);
      CloudField field = cloud_field();
      field.ring_count = 4;
      field.thickness_m = thickness_m;
      const float cell_m = ring_cell_m(field, ring);
      const std::vector<CloudParticle> particles = ring_particles(field, ring, 8000.0f);
      REQUIRE(!particles.empty());
      uint bad_radius = 0, bad_density = 0, bad_place = 0, bad_top = 0;
      for (const CloudParticle& p : particles) {
        const float height = p.top_m - p.base_m;
        bad_radius += !(min(p.radius_m.x, min(p.radius_m.y, p.radius_m.z)) > 0.0f &&
                        max(p.radius_m.x, p.radius_m.y) <= 2.0f * cell_m);
        bad_density += !(p.density > 0.0f && p.density <= kMaxGain * kAdiabaticMost);
        // Wisps fly as if every cloud were 180 m high; what stands on domes rises at most 0.75 of the height above it.
        bad_place += !(p.center_m.z >= p.base_m - 15.0f &&
                       p.center_m.z + p.radius_m.z <= p.base_m + max(1.75f * height, 200.0f) + 50.0f);
        bad_top += !(height >= 0.0f && height <= thickness_m * 1.0001f + 1e-3f);
      }
      CHECK(bad_radius == 0u);
      CHECK(bad_density == 0u);
      CHECK(bad_place == 0u);
      CHECK(bad_top == 0u);
    }
}

TEST_CASE("adjacent rings agree in optical depth, transmittance and altitude") {
  struct Sky {
    float thickness_m, coverage;
    uint first_ring, regions;
  };
  constexpr uint kRings = 5;
  // A region of 29 km has some 400 places of the last ring. Four regions know the area under clouds that cover half of
  // it to 2.5 % only, which is most of the bound, so there it takes twelve.
  for (const Sky sky : {Sky{900.0f, 0.25f, 0u, 4u}, Sky{1400.0f, 0.4f, 0u, 4u}, Sky{2000.0f, 0.5f, 1u, 12u}}) {
    std::vector<Columns> vertical(kRings), slanted(kRings);
    for (uint ring = sky.first_ring; ring < kRings; ++ring)
      for (uint seed = 11; seed < 11 + sky.regions; ++seed) {
        CloudField field = cloud_field();
        field.ring_count = kRings;
        field.seed = seed;
        field.thickness_m = sky.thickness_m;
        field.coverage = sky.coverage;
        const std::vector<CloudParticle> particles = ring_particles(field, ring, 1.2f * kHalfM);
        vertical[ring] += measure_columns(particles, kHalfM, field.base_m);
        slanted[ring] += measure_columns(particles, kHalfM, field.base_m, 1.0f);
      }
    for (uint ring = sky.first_ring; ring + 1u < kRings; ++ring) {
      CAPTURE(sky.thickness_m);
      CAPTURE(ring);
      const Columns &fine = vertical[ring], &coarse = vertical[ring + 1u], &fine_slanted = slanted[ring],
                    &coarse_slanted = slanted[ring + 1u];
      MESSAGE("rings ", ring, ", ", ring + 1u, ": depth ", fine.depth / sky.regions, " ", coarse.depth / sky.regions,
              ", transmittance ", fine.transmittance / sky.regions, " ", coarse.transmittance / sky.regions,
              ", at 45 degrees ", fine_slanted.transmittance / sky.regions, " ",
              coarse_slanted.transmittance / sky.regions, ", altitude ", fine.altitude_m / sky.regions, " ",
              coarse.altitude_m / sky.regions);
      // What a flight must not show: 3 % of the light through a region, 2 % of the layer's thickness in altitude.
      CHECK(std::fabs(coarse.transmittance / fine.transmittance - 1.0) < 0.03);
      CHECK(std::fabs(coarse_slanted.transmittance / fine_slanted.transmittance - 1.0) < 0.03);
      CHECK(std::fabs(coarse.depth / fine.depth - 1.0) < 0.03);
      CHECK(std::fabs(coarse.altitude_m - fine.altitude_m) / sky.regions < 0.02 * static_cast<double>(sky.thickness_m));
    }
  }
}

TEST_CASE("fewer layers keep columns closed") {
  CloudField field = cloud_field();
  field.thickness_m = 2400.0f;
  field.layer_count = 7;
  const Columns full = measure_columns(ring_particles(field, 0, 8000.0f), 8000.0f, field.base_m);
  for (const uint layers : {3u, 5u}) {
    CAPTURE(layers);
    field.layer_count = layers;
    const Columns few = measure_columns(ring_particles(field, 0, 8000.0f), 8000.0f, field.base_m);
    MESSAGE("layers ", layers, ": depth ", few.depth, " (", full.depth, "), transmittance ", few.transmittance, " (",
            full.transmittance, ")");
    // Depth is given by the gains, as long as they stay within their bound; transmittance by the extent.
    CHECK(few.depth == doctest::Approx(full.depth).epsilon(0.05));
    CHECK(few.transmittance == doctest::Approx(full.transmittance).epsilon(0.03));
  }
}

TEST_CASE("the same cell has the same particles from every origin") {
  const CloudField field = cloud_field();
  CloudField shifted = field;
  shifted.origin_index = field.origin_index + ivec2(1, 0);
  const CloudParams params = cloud_params(field), params_shifted = cloud_params(shifted);
  uint same = 0, all = 0;
  for (uint ring = 0; ring < 3u; ++ring)
    for (int i = 0; i < 4000; ++i) {
      const int per_unit = static_cast<int>(ring_lattice(field, ring));
      GridCell a;
      a.ring = ring;
      a.size_m = ring_cell_m(field, ring);
      a.index = ivec2(i % 63 + per_unit / 2 - 30, i / 63 - 30);
      a.corner_m = vec2(a.index) * a.size_m;
      GridCell b = a;
      b.index.x -= per_unit;
      b.corner_m = vec2(b.index) * b.size_m;
      const CellCloud cloud = cell_cloud(field, params, a), cloud_shifted = cell_cloud(shifted, params_shifted, b);
      if (cloud.slots == 0u && cloud_shifted.slots == 0u) continue;
      ++all;
      if (cloud.slots != cloud_shifted.slots) continue;  // a threshold met exactly: rounding decides
      ++same;
      const CloudParticle p = cell_particle(field, params, a, cloud, particle_count(cloud) - 1u);
      const CloudParticle q = cell_particle(shifted, params_shifted, b, cloud_shifted, particle_count(cloud) - 1u);
      CHECK(p.id == q.id);
      CHECK(std::fabs(p.center_m.x - kOriginUnitM - q.center_m.x) < 2.0f);
      CHECK(std::fabs(p.center_m.y - q.center_m.y) < 2.0f);
    }
  CHECK(all > 1000u);
  CHECK(same >= all * 99u / 100u);
}

TEST_CASE("particles move, grow and fade without a step as clouds grow and decay") {
  // Two states a hair apart: all that a particle is may differ by a hair only, and one that is missing has no density.
  struct Change {
    float growth_turns, coverage;
  };
  for (const Change& change : {Change{0.0123f, 0.35f}, Change{0.31f, 0.35f}, Change{0.77f, 0.6f}}) {
    CAPTURE(change.growth_turns);
    double worst = 0;
    int seen = 0;
    for (uint ring = 0; ring < 3u; ++ring)
      for (int y = -30; y < 30; ++y)
        for (int x = -30; x < 30; ++x) {
          std::map<uint, CloudParticle> states[2];
          for (int k = 0; k < 2; ++k) {
            CloudField field = cloud_field();
            field.growth_turns = change.growth_turns + float(k) * 1.2e-7f;
            field.coverage = change.coverage;
            const CloudParams params = cloud_params(field);
            GridCell cell;
            cell.ring = ring;
            cell.index = ivec2(x, y);
            cell.size_m = ring_cell_m(field, ring);
            cell.corner_m = vec2(cell.index) * cell.size_m;
            const CellCloud cloud = kept(cell_cloud(field, params, cell), cell, field);
            for (uint n = 0; n < particle_count(cloud); ++n) {
              const CloudParticle p = cell_particle(field, params, cell, cloud, n);
              states[k][p.id] = p;
            }
          }
          for (int k = 0; k < 2; ++k)
            for (const auto& [id, p] : states[k]) {
              const auto other = states[1 - k].find(id);
              double change_of = p.density;
              if (other != states[1 - k].end()) {
                const CloudParticle& q = other->second;
                const double moved_m = length(p.center_m - q.center_m) + length(p.radius_m - q.radius_m);
                change_of = std::abs(p.density - q.density) + double(p.density) * moved_m / double(p.radius_m.x);
              }
              worst = std::max(worst, change_of);
              ++seen;
            }
        }
    CHECK(seen > 10000);
    // Of a density of some 1; 16 bits of the places' heights and of the gains leave 0.005. Choices that flipped moved
    // particles by 100 m.
    MESSAGE("at turn " << change.growth_turns << ": worst change " << worst << " of " << seen << " particles");
    CHECK(worst < 0.01);
  }
}
