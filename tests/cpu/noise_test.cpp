// Hashes and noise: distribution, continuity, periods, and exactness far from the origin.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "shared/noise.h"

using namespace nephele::shared;

TEST_CASE("hashes of neighbouring cells differ in half their bits") {
  double flipped = 0;
  int pairs = 0;
  std::set<uint> seen;
  for (int z = -8; z < 8; ++z) {
    for (int y = -8; y < 8; ++y) {
      for (int x = -8; x < 8; ++x) {
        const uint h = hash_ivec3(ivec3(x, y, z), 42u);
        seen.insert(h);
        flipped += __builtin_popcount(h ^ hash_ivec3(ivec3(x + 1, y, z), 42u));
        flipped += __builtin_popcount(h ^ hash_ivec3(ivec3(x, y, z), 43u));
        pairs += 2;
      }
    }
  }
  CHECK(seen.size() == 4096);
  CHECK(flipped / pairs == doctest::Approx(16.0).epsilon(0.01));  // 8192 pairs: standard error 0.03
}

TEST_CASE("unit floats fill [0, 1) evenly and never reach 1") {
  CHECK(unit_float(0xffffffffu) < 1.0f);
  CHECK(unit_float(0u) == 0.0f);
  uint state = 9;
  int bins[16] = {};
  for (int i = 0; i < 160000; ++i) ++bins[static_cast<int>(16 * unit_float(hash_next(state)))];
  for (int count : bins) CHECK(std::abs(count - 10000) < 500);  // five standard deviations
}

TEST_CASE("gradient noise has mean 0, a stated spread, and is continuous across cells") {
  uint state = 1;
  double sum2 = 0, sum2_plane = 0, mean = 0, largest = 0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) {
    const vec3 p(uniform_float(state, -400, 400), uniform_float(state, -400, 400), uniform_float(state, -400, 400));
    const double v = gradient_noise3(p, uvec3(0u), 7u), w = gradient_noise2(vec2(p.x, p.y), uvec2(0u), 7u);
    mean += v / n;
    sum2 += v * v / n;
    sum2_plane += w * w / n;
    largest = std::max({largest, std::abs(v), std::abs(w)});
  }
  CHECK(std::abs(mean) < 0.01);
  CHECK(std::sqrt(sum2) == doctest::Approx(0.27).epsilon(0.05));
  CHECK(std::sqrt(sum2_plane) == doctest::Approx(0.31).epsilon(0.05));
  CHECK(largest < 1.2);
  for (int i = 0; i < 1000; ++i) {
    // Either side of a cell wall: slope at most about 4 per cell.
    const vec3 p(std::floor(uniform_float(state, -50, 50)), uniform_float(state, -50, 50),
                 uniform_float(state, -50, 50));
    const vec3 step(1e-4f, 0, 0);
    CHECK(std::abs(gradient_noise3(p - step, uvec3(0u), 3u) - gradient_noise3(p + step, uvec3(0u), 3u)) < 1e-3f);
    CHECK(std::abs(billow_noise3(p - step, uvec3(0u), 3u) - billow_noise3(p + step, uvec3(0u), 3u)) < 1e-3f);
    CHECK(std::abs(gradient_noise2(vec2(p.x - 1e-4f, p.y), uvec2(0u), 3u) -
                   gradient_noise2(vec2(p.x + 1e-4f, p.y), uvec2(0u), 3u)) < 1e-3f);
  }
}

TEST_CASE("a cell base shifts the lattice exactly, in every octave, across the wrap of 32 bits") {
  const uvec3 base(0xfffffff0u, 7u, 0x80000000u);
  const vec3 p(20.25f, 3.5f, -4.75f);
  // Moving the base by whole cells and the position back is the same place.
  const uvec3 moved = base + uvec3(16u, 0u, 4u);
  const vec3 q = p - vec3(16, 0, 4);
  CHECK(fbm3(p, base, 5u, 4) == fbm3(q, moved, 5u, 4));
  CHECK(fbm2(vec2(p.x, p.y), uvec2(base.x, base.y), 5u, 4) == fbm2(vec2(q.x, q.y), uvec2(moved.x, moved.y), 5u, 4));
  CHECK(billow_noise3(p, base, 5u) == billow_noise3(q, moved, 5u));
  CHECK(fbm3(p, base, 5u, 4) != fbm3(p, base, 6u, 4));
}

TEST_CASE("periodic noise repeats and meets itself at the seam") {
  uint state = 11;
  for (int i = 0; i < 500; ++i) {
    const vec3 p(uniform_float(state, 0, 4), uniform_float(state, 0, 4), uniform_float(state, 0, 4));
    CHECK(fbm3_periodic(p, 4u, 3u, 3) == doctest::Approx(fbm3_periodic(p + vec3(4, 0, 8), 4u, 3u, 3)).epsilon(1e-3));
    CHECK(worley_fbm_periodic(p, 4u, 3u, 3) ==
          doctest::Approx(worley_fbm_periodic(p + vec3(0, 4, 0), 4u, 3u, 3)).epsilon(1e-3));
    const vec3 left(0.0f, p.y, p.z), right(3.9999f, p.y, p.z);
    CHECK(std::abs(fbm3_periodic(left, 4u, 3u, 3) - fbm3_periodic(right, 4u, 3u, 3)) < 4e-3f);
    CHECK(std::abs(worley_f1_periodic(left, 4u, 3u) - worley_f1_periodic(right, 4u, 3u)) < 1e-3f);
  }
}

TEST_CASE("Worley distance is that to the nearest feature of a wide search") {
  uint state = 21;
  double mean = 0;
  for (int i = 0; i < 2000; ++i) {
    const vec3 p(uniform_float(state, 2, 60), uniform_float(state, 2, 60), uniform_float(state, 2, 60));
    const vec3 cell = floor(p);
    float nearest = 1e9f;
    for (int z = -2; z <= 2; ++z)
      for (int y = -2; y <= 2; ++y)
        for (int x = -2; x <= 2; ++x)
          nearest = std::min(nearest,
                             worley_distance2(uvec3(ivec3(cell)) + uvec3(ivec3(x, y, z)), vec3(x, y, z), p - cell, 4u));
    const float f1 = worley_f1_periodic(p, 64u, 4u);
    if (nearest < 1.0f) CHECK(f1 == doctest::Approx(std::sqrt(nearest)));
    mean += f1 / 2000;
  }
  CHECK(mean == doctest::Approx(0.52).epsilon(0.03));
}

TEST_CASE("billows are those of a wide search, with the mean of their kernel") {
  uint state = 22;
  double mean = 0, variance = 0;
  for (int i = 0; i < 20000; ++i) {
    const vec3 p(uniform_float(state, -50, 50), uniform_float(state, -50, 50), uniform_float(state, -50, 50));
    const vec3 cell = floor(p);
    double wide = 0;
    for (int z = -2; z <= 2; ++z)
      for (int y = -2; y <= 2; ++y)
        for (int x = -2; x <= 2; ++x) {
          const double d2 = worley_distance2(uvec3(ivec3(cell)) + uvec3(ivec3(x, y, z)), vec3(x, y, z), p - cell, 4u);
          if (d2 < 1) wide += std::pow(1 - d2, 3);
        }
    const float billows = billow_noise3(p, uvec3(0u), 4u);
    CHECK(billows == doctest::Approx(wide).epsilon(1e-4));
    mean += billows / 20000;
    variance += (billows - kBillowMean) * (billows - kBillowMean) / 20000;
  }
  CHECK(std::sqrt(variance) < 0.5);                           // so that the mean is known within 0.004
  CHECK(mean == doctest::Approx(kBillowMean).epsilon(0.02));  // the integral of (1 - r^2)^3 over the unit ball
}
