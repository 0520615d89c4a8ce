// Volume-aware blending against a double-precision integral of overlapping constant segments.
#include "shared/blend.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

using namespace nephele::shared;

namespace {

struct Image {
  glm::dvec3 color{0.0};
  double transmittance = 1.0;
};

// The emission-absorption integral of any number of overlapping segments: between consecutive events the extinction
// is the sum, the source the extinction-weighted mean.
Image integrate(const std::vector<BlendSegment>& segments) {
  std::vector<double> events;
  for (const auto& s : segments) events.insert(events.end(), {s.near_m, s.far_m});
  std::sort(events.begin(), events.end());
  Image image;
  for (std::size_t i = 0; i + 1 < events.size(); ++i) {
    const double middle = 0.5 * (events[i] + events[i + 1]);
    double extinction = 0;
    glm::dvec3 source(0.0);
    for (const auto& s : segments)
      if (s.near_m <= middle && middle <= s.far_m) {
        extinction += s.extinction_per_m;
        source += glm::dvec3(s.radiance) * double(s.extinction_per_m);
      }
    if (extinction <= 0) continue;
    const double alpha = -std::expm1(-extinction * (events[i + 1] - events[i]));
    image.color += image.transmittance * alpha * source / extinction;
    image.transmittance *= 1 - alpha;
  }
  return image;
}

Image fold(std::vector<BlendSegment> segments) {
  // Back to front by centre, as particles are drawn.
  std::sort(segments.begin(), segments.end(), [](const auto& a, const auto& b) { return a.near_m + a.far_m > b.near_m + b.far_m; });
  BlendState state = blend_empty();
  for (const auto& s : segments) blend_add(state, s);
  blend_finish(state);
  return {glm::dvec3(state.committed), state.transmittance};
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

}  // namespace

TEST_CASE("one segment is the closed form") {
  const Image image = fold({segment(10, 30, 0.05f, kRed)});
  CHECK(image.transmittance == doctest::Approx(std::exp(-1.0)).epsilon(1e-6));
  CHECK(image.color.x == doctest::Approx(1 - std::exp(-1.0)).epsilon(1e-6));
}

TEST_CASE("two segments: apart, touching, overlapping, nested and coincident are exact") {
  const std::vector<std::pair<BlendSegment, BlendSegment>> cases = {
      {segment(10, 20, 0.1f, kRed), segment(30, 50, 0.05f, kBlue)}, {segment(10, 20, 0.1f, kRed), segment(20, 50, 0.05f, kBlue)},
      {segment(10, 30, 0.1f, kRed), segment(20, 50, 0.05f, kBlue)}, {segment(10, 60, 0.1f, kRed), segment(20, 50, 0.05f, kBlue)},
      {segment(20, 50, 0.1f, kRed), segment(10, 90, 0.05f, kBlue)}, {segment(10, 30, 0.1f, kRed), segment(10, 30, 0.05f, kBlue)},
      {segment(10, 30, 1e4f, kRed), segment(20, 50, 1e-6f, kBlue)}, {segment(0, 1e5f, 1e-6f, kRed), segment(50, 50.01f, 1e4f, kBlue)}};
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
      pair.push_back(segment(near_m, near_m + 500 * u(random), std::exp2(-12 + 10 * u(random)), {u(random), u(random), u(random)}));
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
