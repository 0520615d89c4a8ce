// The ground keeps the scene's albedo, belongs to the world, shows in a pixel what is in it, and its rivers hold
// together.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <vector>

#include "shared/ground.h"

using namespace nephele::shared;

namespace {

struct Moments {
  dvec3 mean, deviation;
  double water;
};

struct Place {
  vec2 ground_m;
  ivec2 origin;
};

Place random_place(std::uint32_t& state) {
  const ivec2 origin(int(hash_next(state) % 4096u) - 2048, int(hash_next(state) % 4096u) - 2048);
  return {vec2(uniform_float(state, -kOriginUnitM, kOriginUnitM), uniform_float(state, -kOriginUnitM, kOriginUnitM)),
          origin};
}

vec2 random_direction(std::uint32_t& state) {
  const float angle = uniform_float(state, 0.0f, 2.0f * kPi);
  return {std::cos(angle), std::sin(angle)};
}

Moments moments(float long_m, float short_m, int places = 60000) {
  std::uint32_t state = 1;
  dvec3 sum(0), squares(0);
  double water = 0;
  for (int i = 0; i < places; ++i) {
    const Place at = random_place(state);
    const GroundCover cover = ground_cover(at.ground_m, at.origin, random_direction(state), long_m, short_m);
    const dvec3 v(cover.albedo_factor);
    sum += v;
    squares += v * v;
    water += cover.water;
  }
  const dvec3 mean = sum / double(places);
  return {mean, sqrt(max(dvec3(0), squares / double(places) - mean * mean)), water / places};
}

// Mean over a footprint, by samples that are kStrata times as fine.
constexpr int kStrata = 12;
GroundCover supersampled(const Place& at, vec2 along, float long_m, float short_m) {
  dvec3 sum(0);
  double water = 0;
  for (int i = 0; i < kStrata; ++i)
    for (int j = 0; j < kStrata; ++j) {
      const vec2 offset = long_m * ((float(i) + 0.5f) / kStrata - 0.5f) * along +
                          short_m * ((float(j) + 0.5f) / kStrata - 0.5f) * vec2(-along.y, along.x);
      const GroundCover fine =
          ground_cover(at.ground_m + offset, at.origin, along, long_m / kStrata, short_m / kStrata);
      sum += dvec3(fine.albedo_factor);
      water += fine.water;
    }
  return {vec3(sum / double(kStrata * kStrata)), float(water / (kStrata * kStrata))};
}

}  // namespace

TEST_CASE("the ground's mean albedo is the scene's, at every distance and angle") {
  double last = 1.0;
  for (const float footprint_m : {0.3f, 10.0f, 100.0f, 400.0f, 1500.0f, 5000.0f, 50000.0f}) {
    const Moments m = moments(footprint_m, footprint_m);
    CAPTURE(footprint_m);
    // What 60 000 places leave open is 0.0025; the filter moves the woods' share by the rest.
    for (int c = 0; c < 3; ++c) CHECK(std::abs(m.mean[c] - 1.0) < 0.03);
    CHECK(m.deviation.y < last);  // less is left of the pattern as it is seen from farther away
    last = m.deviation.y + 0.002;
  }
  CHECK(last < 0.003);
  CHECK(moments(1.0f, 1.0f).deviation.y > 0.3);
  for (const float long_m : {30.0f, 1000.0f, 20000.0f}) {
    CAPTURE(long_m);
    const Moments m = moments(long_m, 0.05f * long_m);
    for (int c = 0; c < 3; ++c) CHECK(std::abs(m.mean[c] - 1.0) < 0.03);
  }
}

TEST_CASE("water covers about a hundredth, at every distance") {
  for (const float footprint_m : {1.0f, 30.0f, 300.0f, 3000.0f, 30000.0f}) {
    const double water = moments(footprint_m, footprint_m).water;
    CAPTURE(footprint_m);
    CHECK(water > 0.003);  // the mean over pixels that see none of it is 0.007; lakes shrink a little with the filter
    CHECK(water < 0.011);
  }
}

TEST_CASE("a place on the ground looks the same from any origin") {
  std::uint32_t state = 7;
  for (int i = 0; i < 2000; ++i) {
    const vec2 place(uniform_float(state, -4e4f, 4e4f), uniform_float(state, -4e4f, 4e4f));
    const ivec2 origin(int(hash_next(state)), int(hash_next(state)));
    const vec2 along = random_direction(state);
    const GroundCover here = ground_cover(place, origin, along, 60.0f, 20.0f);
    const GroundCover there =
        ground_cover(place - vec2(kOriginUnitM, -2.0f * kOriginUnitM), origin + ivec2(1, -2), along, 60.0f, 20.0f);
    // Float positions differ by 8 mm and more in the turned lattice; the steepest border is 14 m wide.
    CHECK(length(here.albedo_factor - there.albedo_factor) < 0.02f);
    CHECK(std::abs(here.water - there.water) < 0.01f);
  }
}

TEST_CASE("no footprint makes the pattern jump") {
  std::uint32_t state = 11;
  for (int i = 0; i < 40; ++i) {
    const Place at = random_place(state);
    const vec2 along = random_direction(state);
    for (float footprint_m = 1.0f; footprint_m < 30000.0f; footprint_m *= 1.02f) {
      const auto seen = [&](float long_m) {
        return ground_cover(at.ground_m, at.origin, along, long_m, 0.3f * long_m);
      };
      const GroundCover a = seen(footprint_m), b = seen(footprint_m * 1.02f);
      CAPTURE(footprint_m);
      // A footprint 2 % wider moves a border by 1 % of a pixel; rivers and their districts move with lost octaves.
      CHECK(length(a.albedo_factor - b.albedo_factor) < 0.12f);
      CHECK(std::abs(a.water - b.water) < 0.12f);
    }
  }
}

TEST_CASE("neighbouring places look alike: no border is sharper than a pixel") {
  std::uint32_t state = 13;
  for (const float footprint_m : {3.0f, 40.0f, 300.0f}) {
    float steepest = 0.0f, wettest = 0.0f;
    for (int line = 0; line < 60; ++line) {
      const Place at = random_place(state);
      const vec2 along = random_direction(state);
      GroundCover last = ground_cover(at.ground_m, at.origin, along, footprint_m, footprint_m);
      for (int i = 1; i < 800; ++i) {
        const vec2 p = at.ground_m + along * (float(i) * footprint_m / 16.0f);
        const GroundCover here = ground_cover(p, at.origin, along, footprint_m, footprint_m);
        steepest = std::max(steepest, length(here.albedo_factor - last.albedo_factor));
        wettest = std::max(wettest, std::abs(here.water - last.water));
        last = here;
      }
    }
    CAPTURE(footprint_m);
    // Contrasts of up to 3 over half a pixel are 0.4 a sixteenth of a pixel; a hard border would be 1 to 3.
    CHECK(steepest < 0.55f);
    CHECK(wettest < 0.25f);  // a shore is a pixel wide: 1 / 16; where rivers bend in it, three times that
  }
}

TEST_CASE("a pixel shows the mean of what is in it") {
  for (const float aspect : {1.0f, 0.15f})
    for (const float long_m : {20.0f, 80.0f, 300.0f}) {
      std::uint32_t state = 17;
      double wrong = 0, contrast = 0, wrong_water = 0;
      constexpr int kPlaces = 1500;
      for (int i = 0; i < kPlaces; ++i) {
        const Place at = random_place(state);
        const vec2 along = random_direction(state);
        const GroundCover seen = ground_cover(at.ground_m, at.origin, along, long_m, aspect * long_m);
        const GroundCover mean = supersampled(at, along, long_m, aspect * long_m);
        wrong += std::pow(double(seen.albedo_factor.y) - mean.albedo_factor.y, 2);
        contrast += std::pow(double(mean.albedo_factor.y) - 1.0, 2);
        wrong_water += std::abs(double(seen.water) - mean.water);
      }
      CAPTURE(aspect);
      CAPTURE(long_m);
      // Borders give way to the mean and not to the neighbour, and octaves fade by the longer side: what is missing is
      // contrast. Relative to what a pixel should show, by measurement and a fifth more; a pattern of the wrong place
      // would have 1.4, none at all 1.
      CHECK(std::sqrt(wrong / contrast) < (long_m > 200.0f ? 0.78 : long_m > 50.0f ? 0.5 : 0.3));
      CHECK(wrong_water / kPlaces < 0.003);
    }
}

TEST_CASE("rivers hold together") {
  constexpr int kSide = 512;
  constexpr float kStepM = 14.0f;  // a region of 7 km
  std::uint32_t state = 23;
  int wet = 0, connected = 0;
  for (int region = 0; region < 8; ++region) {
    const Place at = random_place(state);
    std::vector<int> label(std::size_t{kSide} * kSide, 0);  // 1: water
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const vec2 p = at.ground_m + kStepM * vec2(float(x), float(y));
        label[std::size_t(y) * kSide + x] = ground_cover(p, at.origin, vec2(1, 0), kStepM, kStepM).water > 0.3f;
      }
    for (int start = 0; start < kSide * kSide; ++start) {
      if (label[start] != 1) continue;
      std::vector<int> stack{start};
      label[start] = 2;
      int size = 0;
      ivec2 low(kSide), high(0);
      while (!stack.empty()) {
        const int i = stack.back();
        stack.pop_back();
        const ivec2 p(i % kSide, i / kSide);
        ++size;
        low = min(low, p), high = max(high, p);
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const ivec2 q = p + ivec2(dx, dy);
            if (q.x < 0 || q.y < 0 || q.x >= kSide || q.y >= kSide || label[q.y * kSide + q.x] != 1) continue;
            label[q.y * kSide + q.x] = 2;
            stack.push_back(q.y * kSide + q.x);
          }
      }
      wet += size;
      if (std::max(high.x - low.x, high.y - low.y) * kStepM > 1500.0f) connected += size;
    }
  }
  CHECK(wet > 2000);
  CHECK(connected > 0.8 * wet);  // the rest: small rings, and corners of regions
}
