// Volume-aware blending against a double-precision integral of overlapping constant segments.
#include "shared/blend.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <random>
#include <vector>

#include "shared/exact_blend.h"
#include "tests/support/blend_oracle.h"

using namespace nephele::shared;

namespace {

struct Image {
  glm::dvec3 color{0.0};
  double transmittance = 1.0;
};

std::vector<nephele::test::OracleSegment> in_doubles(const std::vector<BlendSegment>& segments) {
  std::vector<nephele::test::OracleSegment> list;
  for (const BlendSegment& s : segments)
    list.push_back({s.near_m, s.far_m, s.extinction_per_m, glm::dvec3(s.radiance)});
  return list;
}

Image integrate(const std::vector<BlendSegment>& segments) {
  const nephele::test::OracleRay ray = nephele::test::integrate(in_doubles(segments));
  return {glm::dvec3(ray.color), ray.color.w};
}

Image fold(std::vector<BlendSegment> segments) {
  // Back to front by centre, as particles are drawn.
  std::sort(segments.begin(), segments.end(),
            [](const auto& a, const auto& b) { return a.near_m + a.far_m > b.near_m + b.far_m; });
  BlendState state = blend_empty();
  for (const auto& s : segments) blend_add(state, s);
  blend_finish(state);
  return {glm::dvec3(state.committed), state.transmittance};
}

// In the order of beginnings, as the tiled backend walks a list: whatever begins before the next one has arrived. How
// early the next one could begin is known to `slack_m` only.
Image fold_exactly(std::vector<BlendSegment> segments, float slack_m = 0, int* stretches = nullptr) {
  std::sort(segments.begin(), segments.end(), [](const auto& a, const auto& b) { return a.near_m < b.near_m; });
  ExactState state = exact_empty();
  do {
    if (stretches) ++*stretches;
    for (const auto& s : segments) {
      exact_advance(state, s.near_m - slack_m);
      if (s.near_m - slack_m >= state.horizon_m) break;
      exact_add(state, s);
    }
    exact_advance(state, kNoMatterM);
  } while (exact_next_stretch(state));
  return {glm::dvec3(state.radiance), state.transmittance};
}

double distance(const Image& a, const Image& b) {
  const glm::dvec3 d = glm::abs(a.color - b.color);
  return std::max({d.x, d.y, d.z, std::abs(a.transmittance - b.transmittance)});
}

BlendSegment segment(float near_m, float far_m, float extinction, glm::vec3 radiance) {
  BlendSegment s;
  s.radiance = radiance;
  s.extinction_per_m = extinction;
  s.near_m = near_m;
  s.far_m = far_m;
  return s;
}

const glm::vec3 kRed(1, 0.1f, 0), kBlue(0, 0.2f, 1);

// A pixel's state between two particles: RGBA32F texels keep it, RGBA16F ones round it.
enum class Texels { full, half_colors, half };

float to_half(float x) { return glm::unpackHalf1x16(glm::packHalf1x16(x)); }
glm::vec3 to_half(glm::vec3 v) { return {to_half(v.x), to_half(v.y), to_half(v.z)}; }

Image fold_in(Texels texels, std::vector<BlendSegment> segments) {
  std::sort(segments.begin(), segments.end(),
            [](const auto& a, const auto& b) { return a.near_m + a.far_m > b.near_m + b.far_m; });
  BlendState state = blend_empty();
  for (const auto& s : segments) {
    blend_add(state, s);
    if (texels == Texels::full) continue;
    state.open.radiance = to_half(state.open.radiance);
    state.open.extinction_per_m = to_half(state.open.extinction_per_m);
    state.committed = to_half(state.committed);
    state.transmittance = to_half(state.transmittance);
    if (texels == Texels::half_colors) continue;
    state.open.near_m = to_half(state.open.near_m);
    state.open.far_m = to_half(state.open.far_m);
  }
  blend_finish(state);
  return {glm::dvec3(state.committed), state.transmittance};
}

// `count` segments of up to length_m that begin within spread_m beyond place_m; extinctions up to extinction_per_m.
struct Rays {
  int count;
  float place_m, spread_m, length_m, extinction_per_m;
};

// The worst of 300 rays against the same fold with 32 bits, NaN if there is one; what those are off is another test's.
double texels_error(const Rays& rays, Texels texels) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> u(0, 1);
  double worst = 0;
  for (int ray = 0; ray < 300; ++ray) {
    std::vector<BlendSegment> segments;
    for (int i = 0; i < rays.count; ++i) {
      const float near_m = rays.place_m + rays.spread_m * u(random);
      segments.push_back(segment(near_m, near_m + rays.length_m * u(random), rays.extinction_per_m * u(random),
                                 {u(random), u(random), u(random)}));
    }
    const double off = distance(fold_in(texels, segments), fold_in(Texels::full, segments));
    worst = std::isnan(off) ? off : std::max(worst, off);
  }
  return worst;
}

}  // namespace

TEST_CASE("one segment is the closed form") {
  const Image image = fold({segment(10, 30, 0.05f, kRed)});
  CHECK(image.transmittance == doctest::Approx(std::exp(-1.0)).epsilon(1e-6));
  CHECK(image.color.x == doctest::Approx(1 - std::exp(-1.0)).epsilon(1e-6));
}

TEST_CASE("two segments: apart, touching, overlapping, nested and coincident are exact") {
  const std::vector<std::pair<BlendSegment, BlendSegment>> cases = {
      {segment(10, 20, 0.1f, kRed), segment(30, 50, 0.05f, kBlue)},
      {segment(10, 20, 0.1f, kRed), segment(20, 50, 0.05f, kBlue)},
      {segment(10, 30, 0.1f, kRed), segment(20, 50, 0.05f, kBlue)},
      {segment(10, 60, 0.1f, kRed), segment(20, 50, 0.05f, kBlue)},
      {segment(20, 50, 0.1f, kRed), segment(10, 90, 0.05f, kBlue)},
      {segment(10, 30, 0.1f, kRed), segment(10, 30, 0.05f, kBlue)},
      {segment(10, 30, 1e4f, kRed), segment(20, 50, 1e-6f, kBlue)},
      {segment(0, 1e5f, 1e-6f, kRed), segment(50, 50.01f, 1e4f, kBlue)}};
  for (const auto& [a, b] : cases) {
    CAPTURE(a.near_m);
    CAPTURE(b.near_m);
    // 1e-5: a handful of float roundings of values up to 1.
    CHECK(distance(fold({a, b}), integrate({a, b})) < 1e-5);
    CHECK(distance(fold({b, a}), integrate({a, b})) < 1e-5);
  }
}

TEST_CASE("random pairs are exact") {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> u(0, 1);
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<BlendSegment> pair;
    for (int k = 0; k < 2; ++k) {
      const float near_m = 1000 * u(random);
      pair.push_back(segment(near_m, near_m + 500 * u(random), std::exp2(-12 + 10 * u(random)),
                             {u(random), u(random), u(random)}));
    }
    worst = std::max(worst, distance(fold(pair), integrate(pair)));
  }
  CHECK(worst < 2e-5);  // float sums of distances near 1000 m: 6e-5 m times extinctions up to 0.25 / m
}

TEST_CASE("transmittance is exact for any number of segments, colour stays a convex mean") {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> u(0, 1);
  for (int scene = 0; scene < 200; ++scene) {
    std::vector<BlendSegment> segments;
    for (int i = 0; i < 40; ++i) {
      const float near_m = 1000 * u(random);
      segments.push_back(segment(near_m, near_m + 200 * u(random), 2e-3f * u(random), glm::vec3(1.0f)));
    }
    const Image image = fold(segments);
    CHECK(image.transmittance == doctest::Approx(integrate(segments).transmittance).epsilon(1e-4));
    // White segments: colour and transmittance are complements whatever the order.
    CHECK(image.color.x + image.transmittance == doctest::Approx(1.0).epsilon(1e-5));
  }
}

// Why the state has 32 bits, and what the figures in docs/blending.md are.
TEST_CASE("half floats hold the colours of a few segments, not those of a thousand, and no distances") {
  const Rays pairs{2, 1000, 500, 500, 2e-3f}, dense{2, 1000, 5, 300, 1e4f}, beyond_half{2, 7e4f, 2000, 3000, 3e-4f};
  const Rays thousand{1000, 1000, 3000, 600, 5e-6f}, layers{4096, 1000, 8000, 6, 1.2e-4f};
  CHECK(texels_error(pairs, Texels::half_colors) == doctest::Approx(2.8e-4).epsilon(0.2));
  CHECK(texels_error(dense, Texels::half_colors) == doctest::Approx(2.4e-4).epsilon(0.2));
  CHECK(texels_error(thousand, Texels::half_colors) == doctest::Approx(3.0e-2).epsilon(0.2));
  CHECK(texels_error(layers, Texels::half_colors) == doctest::Approx(0.14).epsilon(0.2));
  CHECK(texels_error(pairs, Texels::half) == doctest::Approx(1.5e-3).epsilon(0.2));
  CHECK(texels_error(dense, Texels::half) > 0.5);               // nearer and farther change places
  CHECK_FALSE(texels_error(beyond_half, Texels::half) < 1e30);  // 65 504 m is the largest half
}

TEST_CASE("empty and degenerate segments change nothing") {
  BlendState state = blend_empty();
  blend_add(state, segment(10, 20, 0, kRed));
  blend_add(state, segment(20, 20, 1, kRed));
  blend_add(state, segment(30, 20, 1, kRed));
  blend_finish(state);
  CHECK(state.transmittance == 1.0f);
  CHECK(state.committed == glm::vec3(0.0f));
  CHECK(state.first_m == kNoMatterM);
}

TEST_CASE("opacity keeps thin segments' precision") {
  for (const float x : {1e-6f, 1e-4f, 1e-2f, 0.0399f, 0.0401f, 1.0f, 100.0f})
    CHECK(opacity_of(x) == doctest::Approx(-std::expm1(-double(x))).epsilon(2e-6));
}

TEST_CASE("the exact blend is the integral of any number of segments, more than it has slots included") {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> u(0, 1);
  for (const int count : {1, 2, 3, 8, 16, 17, 64, 1000, 4096}) {
    for (const float length_m : {3.0f, 300.0f, 3000.0f}) {
      CAPTURE(count);
      CAPTURE(length_m);
      std::vector<BlendSegment> segments;
      const float extinction = 3.0f / (length_m * float(count));  // the whole is some optical depths, never opaque
      for (int i = 0; i < count; ++i) {
        const float near_m = 1000 * u(random);
        segments.push_back(segment(near_m, near_m + length_m * u(random), 2 * extinction * u(random),
                                   {u(random), u(random), u(random)}));
      }
      int stretches = 0;
      // 5e-5: distances near 1000 m are rounded by 3e-5 m, times extinctions up to 1 / m; thousands of factors of T.
      CHECK(distance(fold_exactly(segments, 0, &stretches), integrate(segments)) < 1e-4);
      CHECK(distance(fold_exactly(segments, 100), integrate(segments)) < 1e-4);
      CHECK((count <= kExactSlots ? stretches == 1 : stretches <= 2 * count));
    }
  }
}

TEST_CASE("what an opaque front hides is hidden: less than kOpaqueTransmittance shines through in front of it") {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> u(0, 1);
  int hidden = 0, past_opaque = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<BlendSegment> met;
    OpaqueFront front = opaque_front_empty();
    CHECK_FALSE(opaque_front_hides(front, 1e9f));
    for (int i = 0; i < 12; ++i) {
      const float near_m = 100.0f * float(i) * u(random), length_m = std::exp2(10 * u(random));
      met.push_back(segment(near_m, near_m + length_m, std::exp2(-10 + 9 * u(random)), {1, 1, 1}));
      opaque_front_add(front, met.back());
      const float begin_m = 2000 * u(random);
      std::vector<BlendSegment> before = met;
      for (BlendSegment& s : before) s.far_m = std::max(s.near_m, std::min(s.far_m, begin_m));
      const double transmittance = integrate(before).transmittance;
      if (opaque_front_hides(front, begin_m)) CHECK(transmittance <= kOpaqueTransmittance * 1.001);
      hidden += opaque_front_hides(front, begin_m);
      past_opaque += transmittance <= kOpaqueTransmittance;
    }
  }
  CHECK(hidden > 0.8 * past_opaque);  // a bound that is of use
}

TEST_CASE("the exact blend: coincident, concentric, thin and opaque segments") {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> u(0, 1);
  for (const int count : {2, 40, 300})
    for (const bool concentric : {false, true})
      for (const float depth : {1e-6f, 1.0f, 1e4f}) {
        CAPTURE(count);
        CAPTURE(depth);
        std::vector<BlendSegment> segments;
        for (int i = 0; i < count; ++i) {
          const float inset = concentric ? 40.0f * float(i) / float(count) : 0.0f;
          segments.push_back(
              segment(100 + inset, 200 - inset, depth / (100.0f * float(count)), {u(random), u(random), u(random)}));
        }
        // What shines through the last 1e-4 is left out.
        CHECK(distance(fold_exactly(segments), integrate(segments)) < 1.2e-4);
      }
}

TEST_CASE("the exact blend is continuous where segments swap order") {
  const auto pair = [](float offset_m) {
    return fold_exactly({segment(100 + offset_m, 150, 0.1f, kRed), segment(100, 150 + offset_m, 0.2f, kBlue),
                         segment(90, 120, 0.05f, kBlue)});
  };
  for (float offset_m = -0.01f; offset_m < 0.01f; offset_m += 0.001f)
    CHECK(distance(pair(offset_m), pair(offset_m + 0.001f)) < 1e-3);
}

TEST_CASE("past its slots and told to merge, the exact blend keeps every optical depth") {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> u(0, 1);
  for (int scene = 0; scene < 50; ++scene) {
    ExactState state = exact_empty();
    state.merges = true;
    std::vector<BlendSegment> segments;
    for (int i = 0; i < 200; ++i) {
      const float near_m = 1000 * u(random);
      segments.push_back(
          segment(near_m, near_m + 300 * u(random), 1e-4f * u(random), {u(random), u(random), u(random)}));
      exact_add(state, segments.back());
    }
    exact_advance(state, kNoMatterM);
    CHECK_FALSE(exact_next_stretch(state));
    const Image truth = integrate(segments);
    CHECK(state.transmittance == doctest::Approx(truth.transmittance).epsilon(1e-4));
    // Only the order within merged segments is lost: random colours of mean 1/2 are off by far less.
    CHECK(distance({glm::dvec3(state.radiance), state.transmittance}, truth) < 0.03);
  }
}
