// The cloud field: coverage means area, heights stay in their bounds, nothing jumps, places keep their clouds.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "shared/cloud_field.h"
#include "tests/support/cloud_frame.h"

using namespace nephele::shared;
using nephele::test::cloud_field;

namespace {

CloudParams params_for(float coverage, uint seed) {
  CloudField field = cloud_field();
  field.coverage = coverage;
  field.seed = seed;
  return cloud_params(field);
}

// Share of 120 km by 120 km under clouds.
double area_fraction(float coverage, uint seed) {
  const CloudParams params = params_for(coverage, seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-60000.0f, 60000.0f);
  int covered = 0;
  constexpr int kPoints = 3000;
  for (int i = 0; i < kPoints; ++i) covered += cloud_sample(params, vec2(place(random), place(random))).d > 0.0f;
  return covered / static_cast<double>(kPoints);
}

}  // namespace

TEST_CASE("coverage is the fraction of the area under clouds") {
  for (const float coverage : {0.02f, 0.1f, 0.25f, 0.4f, 0.55f, 0.7f, 0.8f, 0.9f, 0.97f}) {
    CAPTURE(coverage);
    double sum = 0;
    for (uint seed = 101; seed <= 104; ++seed) sum += area_fraction(coverage, seed);
    // 12 000 points: standard deviation 0.005; four skies of 120 km differ by 0.02 at most.
    CHECK(std::fabs(sum / 4 - static_cast<double>(coverage)) < 0.03);
  }
  CHECK(area_fraction(0.0f, 7) == 0.0);
  CHECK(area_fraction(1.0f, 7) > 0.995);
}

TEST_CASE("coverage maps monotonically, without jumps") {
  for (float coverage = 0.001f; coverage < 1.0f; coverage += 0.001f) {
    const float fuller = fullness_for(coverage + 0.001f) - fullness_for(coverage);
    const float deck = deck_for(coverage + 0.001f) - deck_for(coverage);
    CHECK(fuller >= -1e-6f);
    CHECK(fuller < 0.02f);
    CHECK(deck >= -1e-6f);
    if (deck_for(coverage) > -1.0f) CHECK(deck < 0.04f);
  }
}

TEST_CASE("samples and heights stay within bounds") {
  for (const float coverage : {0.1f, 0.5f, 1.0f}) {
    const CloudParams params = params_for(coverage, 3);
    std::mt19937 random(1);
    std::uniform_real_distribution<float> place(-60000.0f, 60000.0f);
    std::vector<float> heights;
    uint bad_sample = 0, bad_warp = 0, bad_height = 0, bad_base = 0;
    for (int i = 0; i < 10000; ++i) {
      const vec2 p(place(random), place(random));
      const CloudSample s = cloud_sample(params, p);
      const auto in_unit = [](float x) { return x >= 0.0f && x <= 1.0f; };
      bad_sample += !(in_unit(s.d) && in_unit(s.size) && in_unit(s.vigour) && s.edge_m >= 0.0f &&
                      s.edge_m <= 1.06f * lattice_cell_m(kFeatureCells0));
      bad_warp += !(length(s.warp_m) < 1.5f * kWarpM);  // what the feature window allows for
      const float height = cloud_height_m(params, p, s);
      bad_height += !(height >= 0.0f && height <= params.thickness_m && (height > 0.0f) == (s.d > 0.0f));
      if (height > 0.0f) heights.push_back(height);
      bad_base += !(std::fabs(cloud_base_m(params, p) - params.base_m) < 120.0f);
    }
    CHECK(bad_sample == 0u);
    CHECK(bad_warp == 0u);
    CHECK(bad_height == 0u);
    CHECK(bad_base == 0u);
    std::sort(heights.begin(), heights.end());
    // Humilis to congestus: half are low, the tallest use most of the thickness.
    CHECK(heights[heights.size() / 2] < 0.4f * params.thickness_m);
    CHECK(heights.back() > 0.6f * params.thickness_m);
  }
}

TEST_CASE("the outline is continuous") {
  const CloudParams params = params_for(0.5f, 4);
  std::mt19937 random(2);
  std::uniform_real_distribution<float> place(-40000.0f, 40000.0f);
  std::vector<float> steps;
  for (int i = 0; i < 20000; ++i) {
    const vec2 p(place(random), place(random));
    const CloudSample a = cloud_sample(params, p), b = cloud_sample(params, p + vec2(0.7f, 0.7f));
    steps.push_back(std::fabs(a.d - b.d));
  }
  std::sort(steps.begin(), steps.end());
  // Along 1 m, d changes by up to 1 / 80 m (the smallest feature) times the warp's and lobes' stretching. Only where
  // the core itself ends may lobes stop short: d = lobes there, which are negative nearly everywhere.
  CHECK(steps[steps.size() * 999 / 1000] < 0.03f);
  CHECK(steps.back() < 0.3f);
}

TEST_CASE("a world place has the same cloud from every origin") {
  const CloudParams params = params_for(0.5f, 6);
  CloudParams shifted = params;
  shifted.origin_index = params.origin_index + ivec2(1, -1);
  std::mt19937 random(8);
  std::uniform_real_distribution<float> place(-40000.0f, 40000.0f);
  int jumps = 0;
  for (int i = 0; i < 5000; ++i) {
    const vec2 p(std::round(place(random)), std::round(place(random)));
    const vec2 q = p - vec2(1, -1) * kOriginUnitM;
    const CloudSample a = cloud_sample(params, p), b = cloud_sample(shifted, q);
    jumps += std::fabs(a.d - b.d) > 1e-3f || std::fabs(a.edge_m - b.edge_m) > 2.0f;
    jumps += std::fabs(cloud_height_m(params, p, a) - cloud_height_m(shifted, q, b)) > 20.0f;
  }
  CHECK(jumps <= 10);  // steep walls, where the 8 mm between floats matter
}

TEST_CASE("features keep their precision in a buffer") {
  const CloudParams params = params_for(0.5f, 6);
  for (uint lattice = 0; lattice < kCloudLattices; ++lattice)
    for (int i = 0; i < 400; ++i) {
      const CloudFeature f = cloud_feature(params, lattice, ivec2(i % 20 - 10, i / 20 - 10));
      const CloudFeature g = unpack_feature(pack_feature(f));
      CHECK(f.center_m == g.center_m);
      CHECK(f.radius_m == g.radius_m);
      // Half a step of 6, 12 and 14 bits. What a cloud's outline moves by is a few metres, and the same for everyone.
      CHECK(std::fabs(g.stretch - f.stretch) < 0.008f);
      CHECK(std::fabs(g.axis_x - f.axis_x) < 2.5e-4f);
      CHECK(std::fabs(g.vigour - f.vigour) < 1e-4f);
      const float spacing = lattice_cell_m(feature_cells(lattice));
      CHECK(f.radius_m * f.stretch <= 1.0501f * spacing);  // else the 3 x 3 neighbourhood cuts it
    }
}

TEST_CASE("growth is periodic, slow and out of step, and keeps the coverage") {
  CloudField field = cloud_field();
  field.coverage = 0.4f;
  const auto at = [&](float turns) {
    field.growth_turns = turns;
    return cloud_params(field);
  };
  std::mt19937 random(12);
  std::uniform_real_distribution<float> place(-60000.0f, 60000.0f);
  constexpr int kPoints = 6000;
  int covered = 0, grown = 0, changed = 0;
  float largest = 0.0f;
  for (int i = 0; i < kPoints; ++i) {
    const vec2 p(place(random), place(random));
    const float still = cloud_sample(at(-1.0f), p).d, now = cloud_sample(at(0.3f), p).d,
                later = cloud_sample(at(0.55f), p).d;
    covered += (now > 0.0f) - (still > 0.0f);
    grown += later > now + 1e-3f;
    changed += std::fabs(later - now) > 1e-3f;
    largest = max(largest, std::fabs(cloud_sample(at(0.3001f), p).d - now));
  }
  CHECK(std::abs(covered) < kPoints * 3 / 100);  // of the area; the same bound as for the coverage itself
  CHECK(changed > kPoints / 5);
  CHECK(grown > changed / 3);
  CHECK(grown < changed * 2 / 3);
  // A ten-thousandth of a turn moves edges by up to kGrowth * pi / 10 000 / 0.4 of a radius (areas shrink to 0.4), but
  // for cores that lobes cut short.
  CHECK(largest < 0.05f);
  for (int i = 0; i < 50; ++i) {  // the turn's end is its beginning
    const ivec2 cell(i % 10, i / 10);
    CHECK(cloud_feature(at(0.0f), 0u, cell).radius_m ==
          doctest::Approx(cloud_feature(at(0.9999999f), 0u, cell).radius_m).epsilon(1e-5));
  }
}
