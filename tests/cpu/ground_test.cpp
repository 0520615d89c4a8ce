// The ground's pattern keeps the scene's albedo, belongs to the world and fades before it can shimmer.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "shared/ground.h"

using namespace nephele::shared;

namespace {

struct Moments {
  dvec3 mean, deviation;
};

Moments moments(float footprint_m) {
  constexpr int kPlaces = 60000;
  std::uint32_t state = 1;
  dvec3 sum(0), squares(0);
  for (int i = 0; i < kPlaces; ++i) {
    const ivec2 origin(int(hash_next(state) % 4096u) - 2048, int(hash_next(state) % 4096u) - 2048);
    const vec2 place(uniform_float(state, -kOriginUnitM, kOriginUnitM),
                     uniform_float(state, -kOriginUnitM, kOriginUnitM));
    const dvec3 v = ground_variation(place, origin, footprint_m);
    sum += v;
    squares += v * v;
  }
  const dvec3 mean = sum / double{kPlaces};
  return {mean, sqrt(max(dvec3(0), squares / double{kPlaces} - mean * mean))};
}

}  // namespace

TEST_CASE("the ground's mean albedo is the scene's, at every distance") {
  double last = 1.0;
  for (const float footprint_m : {0.3f, 10.0f, 100.0f, 400.0f, 1500.0f, 5000.0f, 50000.0f}) {
    const Moments m = moments(footprint_m);
    CAPTURE(footprint_m);
    for (int c = 0; c < 3; ++c) CHECK(m.mean[c] == doctest::Approx(1.0).epsilon(0.03));
    CHECK(m.deviation.y < last);  // less is left of the pattern as it is seen from farther away
    last = m.deviation.y + 0.002;
  }
  CHECK(last < 0.003);
  CHECK(moments(1.0f).deviation.y > 0.15);
}

TEST_CASE("a place on the ground looks the same from any origin") {
  std::uint32_t state = 7;
  for (int i = 0; i < 2000; ++i) {
    const vec2 place(uniform_float(state, -4e4f, 4e4f), uniform_float(state, -4e4f, 4e4f));
    const ivec2 origin(int(hash_next(state)), int(hash_next(state)));
    const vec3 here = ground_variation(place, origin, 200.0f);
    const vec3 there =
        ground_variation(place - vec2(kOriginUnitM, -2.0f * kOriginUnitM), origin + ivec2(1, -2), 200.0f);
    CHECK(length(here - there) < 0.02f);  // float positions differ by 8 mm, the steepest seam is 100 m wide
  }
}

TEST_CASE("no footprint makes the pattern jump") {
  for (float footprint_m = 1.0f; footprint_m < 30000.0f; footprint_m *= 1.02f) {
    const vec3 a = ground_variation(vec2(1234.5f, -777.0f), ivec2(3, 4), footprint_m);
    const vec3 b = ground_variation(vec2(1234.5f, -777.0f), ivec2(3, 4), footprint_m * 1.02f);
    CHECK(length(a - b) < 0.04f);
  }
}
