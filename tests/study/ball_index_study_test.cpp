// Not part of the suite: how much single particles show in the picture, the table in docs/light.md.
//   test_study --no-skip --test-case="ball index study"
// The ball index of a picture: the mean step of the radiance across the silhouettes of particles that stand visibly in
// opaque cloud, over the mean step across the same curves displaced by half a radius. 1: particles leave no mark.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "engine/camera.h"
#include "passes/nephele.h"
#include "shared/ellipsoid.h"
#include "shared/structure.h"
#include "shared/types.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::test;

namespace {

constexpr double kOpaque = 0.003;    // at most so much transmittance on both sides of a curve
constexpr double kHalfStepPx = 1.5;  // from a curve to where the radiance is taken
constexpr double kLeastRadiusPx = 6.0;
constexpr int kPlaces = 16;  // of a silhouette

struct Picture {
  std::uint32_t width, height;
  std::vector<float> layers;  // R G B T Z
  glm::mat4 clip_from_render;

  std::optional<glm::dvec2> pixel(const glm::vec3& p) const {
    const glm::vec4 clip = clip_from_render * glm::vec4(p, 1.0f);
    if (clip.w <= 0.0f) return std::nullopt;
    return glm::dvec2((double{clip.x} / clip.w + 1.0) * 0.5 * width, (double{clip.y} / clip.w + 1.0) * 0.5 * height);
  }
  const float* at(const glm::dvec2& px) const {
    if (px.x < 0 || px.y < 0 || px.x >= width || px.y >= height) return nullptr;
    return &layers[(std::size_t(px.y) * width + std::size_t(px.x)) * 5];
  }
  static double luminance(const float* p) { return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]; }
  // Step across a curve over the mean of both sides; none where one side is not opaque cloud.
  std::optional<double> step(const glm::dvec2& px, const glm::dvec2& normal) const {
    const float *a = at(px - kHalfStepPx * normal), *b = at(px + kHalfStepPx * normal);
    if (!a || !b || a[3] > kOpaque || b[3] > kOpaque) return std::nullopt;
    return std::abs(luminance(a) - luminance(b)) / std::max(0.5 * (luminance(a) + luminance(b)), 1e-9);
  }
};

struct Index {
  double ratio;
  std::size_t places;
};

// shown: where particles are seen to end, in their radii.
Index ball_index(const Picture& picture, const std::vector<shared::Particle>& particles, float shown) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> angle(0.0f, 6.2831853f);
  double steps[2] = {0.0, 0.0};
  std::size_t places = 0;
  for (const shared::Particle& p : particles) {
    const glm::vec3 eye = -(shared::unit_from_render(p.shape) * p.center_m);
    const float distance = glm::length(eye);
    if (distance < 1.2f) continue;
    const glm::vec3 axis = eye / distance;
    const glm::vec3 u =
        glm::normalize(glm::cross(axis, std::abs(axis.z) < 0.9f ? glm::vec3(0, 0, 1) : glm::vec3(1, 0, 0)));
    const glm::vec3 v = glm::cross(axis, u);
    const float across = std::sqrt(1.0f - 1.0f / (distance * distance));
    const auto on_silhouette = [&](float a) {
      const glm::vec3 unit = axis / distance + across * (std::cos(a) * u + std::sin(a) * v);
      return p.center_m + shared::shape_matrix(p.shape) * (shown * unit);
    };
    const float mean_radius_m = shared::mean_radius_m(p.shape);
    const glm::vec3 towards = glm::normalize(p.center_m);
    const glm::vec3 side = glm::normalize(glm::cross(towards, glm::vec3(0.1f, 0.2f, 1.0f)));
    for (int i = 0; i < kPlaces; ++i) {
      const float a = 6.2831853f * (float(i) + 0.5f) / kPlaces, turn = angle(random);
      const glm::vec3 place = on_silhouette(a);
      const auto center = picture.pixel(p.center_m), at = picture.pixel(place),
                 beside = picture.pixel(on_silhouette(a + 0.02f));
      if (!center || !at || !beside || glm::length(*at - *center) < kLeastRadiusPx) continue;
      const glm::dvec2 tangent = glm::normalize(*beside - *at), normal(-tangent.y, tangent.x);
      const glm::vec3 way = std::cos(turn) * side + std::sin(turn) * glm::cross(towards, side);
      const auto moved = picture.pixel(place + 0.5f * mean_radius_m * way);
      const float* seen = picture.at(*at);
      if (!moved || !seen || std::abs(seen[4] - glm::length(place)) > 0.5f * mean_radius_m) continue;
      const auto here = picture.step(*at, normal), there = picture.step(*moved, normal);
      if (!here || !there) continue;
      steps[0] += *here;
      steps[1] += *there;
      ++places;
    }
  }
  return {steps[1] > 0.0 ? steps[0] / steps[1] : 0.0, places};
}

}  // namespace

TEST_CASE("ball index study" * doctest::skip()) {
  for (const char* name : {"above_deck", "coast", "towering", "fair_weather"}) {
    const auto scene = load_scene(std::string(NEPHELE_SOURCE_DIR) + "/tools/scenes/" + name + ".json");
    REQUIRE(scene);
    std::string row = std::string("| ") + name;
    for (const bool detail : {true, false})
      for (const Light light : {Light::field, Light::tables}) {
        const RenderSettings settings{.width = 1280, .height = 720, .light = light, .detail = detail};
        auto renderer = Renderer::create(test_sky(), *scene, settings);
        REQUIRE(renderer);
        (*renderer)->render(scene->camera, 0.0);
        const Picture picture{1280, 720, (*renderer)->read_layers(),
                              camera_matrices(scene->camera, 1280.0 / 720.0).clip_from_render};
        const Index index =
            ball_index(picture, (*renderer)->read_particles(), detail ? shared::kStructureMeanRadius : 1.0f);
        char text[64];
        std::snprintf(text, sizeof text, " | %.2f", index.ratio);
        row += text;
        CHECK(index.places > 500);
      }
    std::printf("%s |\n", row.c_str());
    std::fflush(stdout);
  }
}
