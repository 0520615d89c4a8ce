// Where an ellipsoid can show and how near it comes: against rays through every pixel and points on the silhouette, in
// doubles.
#include "shared/screen_bounds.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engine/camera.h"

using namespace nephele;
using namespace nephele::shared;

namespace {

constexpr glm::uvec2 kImagePx(319, 181), kLayerPx(160, 91);  // odd: the last layer pixels hang over the edge
constexpr std::uint32_t kScale = 2;

struct View {
  glm::mat4 clip_from_render;
  glm::dmat4 render_from_clip;
};

View view_of(const CameraState& camera) {
  const CameraMatrices matrices = camera_matrices(camera, double(kImagePx.x) / kImagePx.y);
  return {matrices.clip_from_render, glm::dmat4(matrices.render_from_clip)};
}

// Direction of a layer pixel's ray; not unit.
glm::dvec3 ray(const View& view, glm::uvec2 pixel) {
  const glm::dvec2 at = (glm::dvec2(pixel) + 0.5) * double(kScale) / glm::dvec2(kImagePx);
  return glm::dvec3(view.render_from_clip * glm::dvec4(2.0 * at - 1.0, 1, 1));
}

struct Ellipsoid {
  glm::mat3 render_from_reference;
  glm::vec3 center_m;
};

// Whether the ray from the eye meets it ahead.
bool meets(const Ellipsoid& e, glm::dvec3 direction) {
  const glm::dmat3 reference_from_render = glm::inverse(glm::dmat3(e.render_from_reference));
  const glm::dvec3 o = reference_from_render * -glm::dvec3(e.center_m), d = reference_from_render * direction;
  const double a = glm::dot(d, d), b = glm::dot(o, d), q = b * b - a * (glm::dot(o, o) - 1);
  return q >= 0 && -b + std::sqrt(q) > 0;
}

glm::mat3 any_rotation(std::mt19937& random) {
  std::normal_distribution<float> n;
  const glm::vec3 x = glm::normalize(glm::vec3(n(random), n(random), n(random)));
  const glm::vec3 z = glm::normalize(glm::cross(x, glm::vec3(n(random), n(random), n(random))));
  return {x, glm::cross(z, x), z};
}

// From specks to giants around the eye, from spheres to needles, some out of view.
Ellipsoid any_ellipsoid(std::mt19937& random, const CameraState& camera) {
  std::uniform_real_distribution<float> u(0, 1);
  const CameraAxes axes = camera_axes(camera);
  const float distance_m = std::exp2(17 * u(random));
  const glm::vec3 direction = glm::vec3(axes.forward) + (2.4f * u(random) - 1.2f) * glm::vec3(axes.right) +
                              (1.4f * u(random) - 0.7f) * glm::vec3(axes.up);
  const float radius_m = distance_m * std::exp2(-9 + 10 * u(random));
  const glm::mat3 rotation = any_rotation(random);
  glm::mat3 shape = rotation;
  for (int axis = 0; axis < 3; ++axis) shape[axis] *= radius_m * std::exp2(-6 * u(random) * u(random));
  return {shape, distance_m * glm::normalize(direction)};
}

glm::uvec2 pixels_of(const View& view, const Ellipsoid& e) {
  return screen_pixels(view.clip_from_render, e.render_from_reference, e.center_m, kImagePx, kScale, kLayerPx);
}

bool inside(glm::uvec2 rectangle, glm::uvec2 pixel) {
  return glm::all(glm::greaterThanEqual(pixel, rectangle_low(rectangle))) &&
         glm::all(glm::lessThan(pixel, rectangle_high(rectangle)));
}

// Points of the layer, in pixels, that see the silhouette of an ellipsoid wholly in front of the eye.
std::vector<glm::dvec2> silhouette(const View& view, const Ellipsoid& e) {
  const glm::dmat3 shape(e.render_from_reference);
  const glm::dvec3 q = glm::inverse(shape) * -glm::dvec3(e.center_m);
  const double q2 = glm::dot(q, q);
  const glm::dvec3 axis = q / std::sqrt(q2),
                   t1 = glm::normalize(
                       glm::cross(std::abs(axis.z) < 0.7 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0), axis));
  const glm::dvec3 t2 = glm::cross(axis, t1);
  std::vector<glm::dvec2> points;
  for (int i = 0; i < 4000; ++i) {
    const double angle = i * 2 * 3.14159265358979 / 4000;
    const glm::dvec3 on_circle = q / q2 + std::sqrt(1 - 1 / q2) * (std::cos(angle) * t1 + std::sin(angle) * t2);
    const glm::dvec4 clip =
        glm::dmat4(view.clip_from_render) * glm::dvec4(glm::dvec3(e.center_m) + shape * on_circle, 1);
    points.push_back((glm::dvec2(clip) / clip.w * 0.5 + 0.5) * glm::dvec2(kImagePx) / double(kScale) - 0.5);
  }
  return points;
}

CameraState tilted_camera(int scene) {
  CameraState camera;
  camera.yaw_rad = 0.7 * scene;
  camera.pitch_rad = 0.3 * (scene % 9 - 4);
  camera.vertical_fov_rad = scene % 3 == 0 ? 0.05 : 1.0;
  return camera;
}

}  // namespace

TEST_CASE("every pixel whose ray meets an ellipsoid lies in its rectangle") {
  std::mt19937 random(1);
  int seen = 0;
  for (int scene = 0; scene < 600; ++scene) {
    const CameraState camera = tilted_camera(scene);
    const View view = view_of(camera);
    const Ellipsoid e = any_ellipsoid(random, camera);
    const glm::uvec2 rectangle = pixels_of(view, e);
    int outside = 0;
    for (std::uint32_t y = 0; y < kLayerPx.y; ++y)
      for (std::uint32_t x = 0; x < kLayerPx.x; ++x) {
        const bool shows = meets(e, ray(view, {x, y}));
        seen += shows;
        outside += shows && !inside(rectangle, {x, y});
      }
    CAPTURE(scene);
    CHECK(outside == 0);
  }
  CHECK(seen > 100000);
}

TEST_CASE("the rectangle is tight around an ellipsoid in front of the eye") {
  std::mt19937 random(2);
  int checked = 0;
  for (int scene = 0; scene < 600; ++scene) {
    const CameraState camera = tilted_camera(scene);
    const View view = view_of(camera);
    const Ellipsoid e = any_ellipsoid(random, camera);
    const glm::dvec3 forward = camera_axes(camera).forward;
    const double depth_m = glm::dot(forward, glm::dvec3(e.center_m)),
                 extent_m = glm::length(glm::transpose(glm::dmat3(e.render_from_reference)) * forward);
    if (depth_m < 1.05 * extent_m) continue;
    ++checked;
    glm::dvec2 low(1e30), high(-1e30);
    for (const glm::dvec2& p : silhouette(view, e)) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    // The slack of covered_pixels, 0.01 of a pixel, and as much for the silhouette's sampling.
    const glm::dvec2 first = glm::clamp(glm::ceil(low - 0.02), glm::dvec2(0), glm::dvec2(kLayerPx));
    const glm::dvec2 past = glm::clamp(glm::floor(high + 0.02) + 1.0, glm::dvec2(0), glm::dvec2(kLayerPx));
    const glm::uvec2 rectangle = pixels_of(view, e);
    CAPTURE(scene);
    if (rectangle == kNoTiles) continue;  // that nothing is left out is the other test's
    CHECK(glm::all(glm::greaterThanEqual(glm::dvec2(rectangle_low(rectangle)), first)));
    CHECK(glm::all(glm::lessThanEqual(glm::dvec2(rectangle_high(rectangle)), past)));
  }
  CHECK(checked > 300);
}

TEST_CASE("around the eye an ellipsoid may cover everything, behind it nothing") {
  const View view = view_of({});
  const glm::vec3 forward(camera_axes({}).forward);
  const glm::uvec2 everything = tile_rectangle(glm::uvec2(0), kLayerPx);
  CHECK(pixels_of(view, {glm::mat3(100), glm::vec3(0)}) == everything);
  CHECK(pixels_of(view, {glm::mat3(100), -99.0f * forward}) == everything);
  CHECK(pixels_of(view, {glm::mat3(100), -101.0f * forward}) == kNoTiles);
  CHECK(pixels_of(view, {glm::mat3(1e5f), -1.1e5f * forward}) == kNoTiles);
  CHECK(pixels_of(view, {glm::mat3(1e-2f), -1e3f * forward}) == kNoTiles);
}

TEST_CASE("a tile's mask has every pixel of the tile whose ray meets the ellipsoid, and hardly another") {
  std::mt19937 random(4);
  double met = 0, masked = 0;
  for (int scene = 0; scene < 600; ++scene) {
    const CameraState camera = tilted_camera(scene);
    const View view = view_of(camera);
    const Ellipsoid e = any_ellipsoid(random, camera);
    const glm::uvec2 pixels = pixels_of(view, e), tiles = tiles_of_pixels(pixels);
    const glm::dvec3 forward = camera_axes(camera).forward;
    const bool in_front = glm::dot(forward, glm::dvec3(e.center_m)) >
                          1.05 * glm::length(glm::transpose(glm::dmat3(e.render_from_reference)) * forward);
    int missing = 0, outside = 0;
    for (std::uint32_t ty = rectangle_low(tiles).y; ty < rectangle_high(tiles).y; ++ty)
      for (std::uint32_t tx = rectangle_low(tiles).x; tx < rectangle_high(tiles).x; ++tx) {
        const glm::uvec2 mask =
            tile_mask(view.clip_from_render, glm::mat4(view.render_from_clip), glm::inverse(e.render_from_reference),
                      e.center_m, pixels, {tx, ty}, kImagePx, kScale, kLayerPx);
        for (std::uint32_t y = 0; y < kScreenTilePx; ++y)
          for (std::uint32_t x = 0; x < kScreenTilePx; ++x) {
            const glm::uvec2 pixel = glm::uvec2(tx, ty) * kScreenTilePx + glm::uvec2(x, y);
            const bool in_mask = ((y < 4 ? mask.x : mask.y) >> (kScreenTilePx * (y % 4) + x)) & 1;
            outside += in_mask && !inside(pixels, pixel);
            if (glm::any(glm::greaterThanEqual(pixel, kLayerPx))) continue;
            const bool shows = meets(e, ray(view, pixel));
            missing += shows && !in_mask;
            met += in_front && shows;
            masked += in_front && in_mask;
          }
      }
    CAPTURE(scene);
    CHECK(missing == 0);
    CHECK(outside == 0);
  }
  CHECK(met > 100000);
  CHECK(masked <
        1.03 * met);  // needles askew keep their rectangles; a rectangle about an ellipse has 1.27 times its area
}

TEST_CASE("the bound of what lies above a base holds all of it, near and far on the curved planet, and little else") {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> u(0, 1);
  double inside = 0, outside = 0;
  int cut_off = 0;
  for (int scene = 0; scene < 2000; ++scene) {
    const float camera_altitude_m = 12000 * u(random), distance_m = std::exp2(17 * u(random)),
                angle = 6.28f * u(random);
    const glm::vec3 center_m = distance_m * glm::vec3(std::cos(angle), std::sin(angle), u(random) - 0.5f);
    const glm::vec3 radius_m = 20.0f * glm::exp2(6.0f * glm::vec3(u(random), u(random), u(random)));
    glm::mat3 scale(0);
    for (int k = 0; k < 3; ++k) scale[k][k] = 1 / radius_m[k];
    const glm::mat3 reference_from_render = any_rotation(random) * scale;
    const float base_m = altitude_m(center_m, camera_altitude_m) + radius_m.z * (2.4f * u(random) - 1.2f);
    const BaseBound bound = bound_above_base(reference_from_render, center_m, base_m, camera_altitude_m);
    const bool cut = bound.center_m != center_m;
    cut_off += cut;
    int missing = 0;
    const glm::dmat3 render_from_reference = glm::inverse(glm::dmat3(reference_from_render));
    for (int i = 0; i < 300; ++i) {
      const glm::dvec3 in_ball(2 * u(random) - 1, 2 * u(random) - 1, 2 * u(random) - 1);
      if (glm::length(in_ball) > 1) continue;
      const glm::dvec3 offset_m = render_from_reference * in_ball;
      const glm::dvec3 p_m = glm::dvec3(center_m) + offset_m;
      const double altitude =
          glm::length(p_m + glm::dvec3(0, 0, double(kPlanetRadiusM) + camera_altitude_m)) - double(kPlanetRadiusM);
      const bool above = altitude >= base_m, bounded = glm::length(glm::dmat3(bound.reference_from_render) *
                                                                   (p_m - glm::dvec3(bound.center_m))) <= 1;
      missing += above && !bounded;
      inside += cut && above;
      outside += cut && !above && bounded;
    }
    CAPTURE(scene);
    CAPTURE(cut);
    CHECK(missing == 0);
  }
  CHECK(cut_off > 1000);
  CHECK(outside < 0.15 * inside);  // half of the balls' volume lies below
}

TEST_CASE("what two rectangles have in common") {
  CHECK(rectangle_both(tile_rectangle({1, 2}, {9, 8}), tile_rectangle({3, 0}, {12, 5})) ==
        tile_rectangle({3, 2}, {9, 5}));
  CHECK(rectangle_both(tile_rectangle({1, 2}, {3, 8}), tile_rectangle({3, 2}, {12, 8})) == kNoTiles);
  CHECK(rectangle_both(kNoTiles, tile_rectangle({0, 0}, {12, 8})) == kNoTiles);
}

TEST_CASE("the tiles of a rectangle of pixels") {
  CHECK(tiles_of_pixels(tile_rectangle({7, 8}, {9, 16})) == tile_rectangle({0, 1}, {2, 2}));
  CHECK(rectangle_area(tiles_of_pixels(kNoTiles)) == 0);
}

TEST_CASE("no point of an ellipsoid is nearer than its bound, and the bound is near where it points at the eye") {
  std::mt19937 random(3);
  std::normal_distribution<float> n;
  for (int i = 0; i < 300; ++i) {
    const Ellipsoid e = any_ellipsoid(random, {});
    const glm::vec3 towards = e.center_m / glm::length(e.center_m);
    const float bound_m = near_bound_m(e.center_m, glm::length(glm::transpose(e.render_from_reference) * towards));
    double nearest_m = 1e30;
    for (int k = 0; k < 2000; ++k) {
      const glm::dvec3 on_sphere = glm::normalize(glm::dvec3(n(random), n(random), n(random)));
      nearest_m =
          std::min(nearest_m, glm::length(glm::dvec3(e.center_m) + glm::dmat3(e.render_from_reference) * on_sphere));
    }
    CHECK(double(bound_m) <= nearest_m);
  }
  CHECK(near_bound_m({0, 1000, 0}, 100) == doctest::Approx(900).epsilon(3e-5));
  CHECK(near_bound_m({0, 10, 0}, 100) == 0);
}
