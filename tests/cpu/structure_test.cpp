// The air's structure: what its tile is like, that it knows neither an origin nor a camera, and the path tracer's
// sampling of it against an oracle in doubles.
#include "shared/structure.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "tests/support/structure_oracle.h"
#include "tools/path_tracer/structure_noise.h"

using namespace nephele;
using namespace nephele::shared;

TEST_CASE("structure: the tile is in [0, 1], even on average, and repeats") {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(0.0f, float(kStructureCells));
  double sum = 0, squares = 0;
  constexpr int kPlaces = 20000;
  for (int i = 0; i < kPlaces; ++i) {
    const double v = structure_tile({place(random), place(random), place(random)});
    CHECK((v >= 0.0 && v <= 1.0));
    sum += v;
    squares += (v - 0.5) * (v - 0.5);
  }
  CHECK(std::abs(sum / kPlaces - 0.5) < 0.01);
  CHECK(std::abs(std::sqrt(squares / kPlaces) - 0.15) < 0.01);
  for (int i = 0; i < 50; ++i) {  // its border fits its other border
    const float y = place(random), z = place(random);
    CHECK(structure_tile({1e-4f, y, z}) == doctest::Approx(structure_tile({3.9999f, y, z})).epsilon(0.01));
  }
}

TEST_CASE("structure: the path tracer samples what the oracle says, near and far, and whatever the grid's origin") {
  const vec3 camera(12345.6f, -40000.25f, 900.0f);
  const truth::StructureNoise noise(camera), shifted(camera - vec3(kOriginUnitM, 0.0f, 0.0f));
  std::mt19937 random(2);
  std::uniform_real_distribution<float> u(-1.0f, 1.0f);
  double worst = 0, worst_shifted = 0;
  for (int i = 0; i < 3000; ++i) {
    const float reach = i % 2 == 0 ? 500.0f : 20000.0f;
    const vec3 p(reach * u(random), reach * u(random), 500.0f * u(random));
    const double drop_m = (double(p.x) * p.x + double(p.y) * p.y) / (2.0 * 6360000.0);
    const double wanted = test::structure_oracle()(dvec3(camera) + dvec3(p) + dvec3(0, 0, drop_m));
    worst = std::max(worst, std::abs(double(noise(p)) - wanted));
    worst_shifted = std::max(worst_shifted, std::abs(double(noise(p)) - double(shifted(p))));
    const double broad = test::structure_oracle().broad(dvec3(camera) + dvec3(p) + dvec3(0, 0, drop_m));
    worst = std::max(worst, std::abs(double(noise.broad(p)) - broad));
    worst_shifted = std::max(worst_shifted, std::abs(double(noise.broad(p)) - double(shifted.broad(p))));
  }
  // Floats know a place 60 km out to 4 mm, a fiftieth of the smaller tile's texel.
  CHECK(worst < 0.02);
  CHECK(worst_shifted < 0.02);
}

TEST_CASE("structure: octaves give way before a pixel hides their billows") {
  for (uint octave = 0; octave < kStructureOctaves; ++octave) {
    const float largest_m = structure_tile_m(octave) / float(kStructureCells);
    CHECK(structure_share(octave, 0.0f) == 1.0f);
    CHECK(structure_share(octave, largest_m) == 0.0f);
    float before = 1.0f;
    for (float pixel_m = 0.0f; pixel_m < largest_m; pixel_m += 0.01f * largest_m) {
      CHECK(structure_share(octave, pixel_m) <= before);
      before = structure_share(octave, pixel_m);
    }
  }
}

TEST_CASE("structure: a displaced ball keeps its mean radius whatever its size, and its bounds") {
  for (const float radius_m : {20.0f, 150.0f, 220.0f, 1000.0f, 5000.0f}) {
    const float depth = structure_depth(radius_m, kParticleDetail);
    CHECK((depth > 0.0f && depth <= kStructureDeepest));
    CHECK(displaced_radius(depth, kStructureMean, 0.0f) == kStructureMeanRadius);
    for (float noise = 0.0f; noise <= 1.0f; noise += 0.01f) {
      const float r = displaced_radius(depth, noise, noise - 0.5f);
      CHECK((r > 0.2f && r <= 1.0f));
      CHECK(structured_density(1.0f, r, structure_skin(depth)) == 0.0f);
      CHECK(structured_density(0.0f, r, structure_skin(depth)) == 1.0f);
    }
  }
  CHECK(structure_depth(100.0f, 0u) == 0.0f);
  CHECK(structure_depth(100.0f, kParticleDetail | (kMostTorn << kParticleTornShift)) == kTornDepth);
}

TEST_CASE("structure: detail varies a soft particle's density about its mean and never below nothing") {
  const uint full = kParticleSoft | kMostSoftDetail << kParticleSoftShift;
  CHECK(soft_detail(0u) < 0.0f);
  CHECK(soft_detail(kParticleSoft) == 0.0f);
  CHECK(soft_detail(full) == kSoftDetail);
  CHECK(soft_variation(kSoftDetail, 0.0f) >= 0.0f);
  CHECK(soft_variation(kSoftDetail, kStructureMean) == 1.0f);
  // The noise's mean over the air is kStructureMean, so matter stays: over a lattice that no octave has a period of.
  double sum = 0.0;
  const nephele::test::StructureOracle& noise = nephele::test::structure_oracle();
  constexpr int kSide = 24;
  for (int x = 0; x < kSide; ++x)
    for (int y = 0; y < kSide; ++y)
      for (int z = 0; z < kSide; ++z)
        sum += static_cast<double>(
            soft_variation(kSoftDetail, static_cast<float>(noise(dvec3(x, y, z) * 53.7 + dvec3(0.3, 11.0, 900.0)))));
  CHECK(std::abs(sum / (kSide * kSide * kSide) - 1.0) < 0.02);
}
