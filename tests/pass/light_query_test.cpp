// Light at places that a host names: against pictures of all that surrounds the place, and against a closed form.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "engine/camera.h"
#include "passes/nephele.h"
#include "shared/light_lattice.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::test;
using glm::dvec3;

namespace {

constexpr std::uint32_t kFacePx = 24;

// The same harmonics from six square pictures.
std::array<dvec3, 9> harmonics_of_pictures(Renderer& renderer, const dvec3& at_m, const dvec3& sun) {
  std::array<dvec3, 9> sums{};
  double weights = 0.0;
  for (int face = 0; face < 6; ++face) {
    CameraState camera;
    camera.position_m = at_m;
    camera.yaw_rad = face < 4 ? face * 0.5 * std::numbers::pi : 0.0;
    camera.pitch_rad = face < 4 ? 0.0 : (face == 4 ? 0.5 : -0.5) * std::numbers::pi;
    camera.vertical_fov_rad = 0.5 * std::numbers::pi;
    const CameraMatrices matrices = camera_matrices(camera, 1.0);
    renderer.render(camera, 0.0);
    const std::vector<float> hdr = renderer.read_hdr();
    for (std::uint32_t y = 0; y < kFacePx; ++y)
      for (std::uint32_t x = 0; x < kFacePx; ++x) {
        const double u = (2.0 * x + 1.0) / kFacePx - 1.0, v = (2.0 * y + 1.0) / kFacePx - 1.0;
        const glm::vec4 far = matrices.render_from_clip * glm::vec4(u, v, 0.5f, 1.0f);
        const glm::vec3 look = glm::normalize(glm::vec3(far) / far.w);
        const double weight = std::pow(1.0 + u * u + v * v, -1.5);
        weights += weight;
        if (glm::dot(dvec3(look), sun) > std::cos(0.1)) continue;  // the disc and the glare of the haze
        const shared::LightHarmonics h = shared::light_harmonics(look);
        const std::size_t pixel = (std::size_t{y} * kFacePx + x) * 4;
        for (std::size_t k = 0; k < 9; ++k)
          sums[k] += weight * double{h.y[k]} * dvec3(hdr[pixel], hdr[pixel + 1], hdr[pixel + 2]);
      }
  }
  for (dvec3& sum : sums) sum /= weights;
  return sums;
}

}  // namespace

TEST_CASE("light at a place is the light of a picture all around it: under, among, in and above clouds") {
  Scene scene;
  scene.clouds->coverage = 0.4f;
  scene.clouds->view_distance_m = 15000.0f;
  scene.clouds->wind_m_per_s = {0.0, 0.0};
  const RenderSettings settings{.width = kFacePx, .height = kFacePx, .quality = Quality::low, .ring_size_cells = 40};
  const auto renderer = renderer_of(scene, settings);
  // Worse below and above the clouds, where haze and horizon, which the field knows but by its ordinates, are most of
  // what is seen. Low quality: cells of 75 m, which know the mean of torn matter alone, as there is around the third.
  const std::pair<dvec3, double> places[] = {{dvec3(0, 0, 300), 0.3},
                                             {dvec3(700, -300, 1000), 0.25},
                                             {dvec3(-1500, 400, 1600), 0.12},
                                             {dvec3(200, 900, 3500), 0.3}};
  for (const auto& [at_m, share] : places) {
    CAPTURE(at_m.z);
    const std::array<dvec3, 9> expected =
        harmonics_of_pictures(*renderer, at_m, direction_from_angles(scene.sun.azimuth_rad, scene.sun.elevation_rad));
    const auto light = renderer->light_at({at_m});
    REQUIRE(light);
    for (int c = 0; c < 3; ++c) {
      double square = 0.0;
      for (std::size_t k = 1; k < 4; ++k)
        square += std::pow(double{light->front().harmonics[k][c]} - expected[k][c], 2);
      MESSAGE(at_m.z << ": mean " << double{light->front().harmonics[0][c]} / expected[0][c]
                     << ", first moments off by " << std::sqrt(square) / expected[0][c]);
      CHECK(double{light->front().harmonics[0][c]} == doctest::Approx(expected[0][c]).epsilon(share));
      CHECK(std::sqrt(square) < share * expected[0][c]);
    }
  }
}

TEST_CASE("sunlight on the ground is what the clouds let through above it, in every window and at every level") {
  Scene scene;
  scene.clouds->wind_m_per_s = {0.0, 0.0};
  scene.clouds->base_m = 2600.0f;  // as many layers over the ground as a window has
  scene.sun.elevation_rad = 1.3;
  const auto renderer =
      renderer_of(scene, {.width = kFacePx, .height = kFacePx, .quality = Quality::low, .ring_size_cells = 40});
  const dvec3 sun = direction_from_angles(scene.sun.azimuth_rad, scene.sun.elevation_rad);
  for (const double east_m : {0.0, 600.0, 1200.0}) {  // windows step by 600 m, from one store to the other and back
    CameraState camera;
    camera.position_m = {east_m, 0.0, 300.0};
    renderer->render(camera, 0.0);
    std::vector<dvec3> places;
    for (int i = 0; i < 400; ++i) {
      const dvec3 on_ground(east_m + 9000.0 * std::cos(2.4 * i) * i / 400.0, 9000.0 * std::sin(2.4 * i) * i / 400.0,
                            0.0);
      places.push_back(on_ground);
      places.push_back(on_ground + 2450.0 / sun.z * sun);  // under the bases
    }
    const auto light = renderer->light_at(places);
    REQUIRE(light);
    double square = 0.0;
    int counted = 0, shaded = 0;
    const auto apart_m = [&](const dvec3& p) { return std::max(std::abs(p.x - east_m), std::abs(p.y)); };
    for (std::size_t i = 0; i < places.size(); i += 2) {
      // Both in the finest window, or both in the next one: cells of another width make another light.
      const double a_m = apart_m(places[i]), b_m = apart_m(places[i + 1]);
      if (std::max(a_m, b_m) > 1700.0 && (std::min(a_m, b_m) < 2500.0 || std::max(a_m, b_m) > 5000.0)) continue;
      ++counted;
      square += std::pow(double{(*light)[i].sun_transmittance} - double{(*light)[i + 1].sun_transmittance}, 2);
      shaded += (*light)[i].sun_transmittance < 0.5f;
    }
    CAPTURE(east_m);
    CHECK(std::sqrt(square / counted) < 0.03);
    CHECK(shaded > counted / 8);
    CHECK(shaded < counted * 7 / 8);
  }
}

TEST_CASE("irradiance from harmonics: of even light pi times it, of a lobe what a sum over directions gives") {
  LightAt light;
  light.harmonics[0] = glm::vec3(2.0f);
  CHECK(irradiance(light, {0.6f, 0.0f, 0.8f}).x == doctest::Approx(2.0 * std::numbers::pi));
  // Light of (1 + axis . d)^2 has no degree beyond 2.
  const dvec3 axis = glm::normalize(dvec3(1.0, -2.0, 0.5)), normal = glm::normalize(dvec3(-0.3, 0.4, 1.0));
  std::array<double, 9> sums{};
  double expected = 0.0;
  constexpr int kDirections = 40000;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections, across = std::sqrt(1.0 - z * z), azimuth = 2.39996323 * i;
    const dvec3 d(across * std::cos(azimuth), across * std::sin(azimuth), z);
    const double radiance = std::pow(1.0 + glm::dot(axis, d), 2);
    const shared::LightHarmonics h = shared::light_harmonics(glm::vec3(d));
    for (std::size_t k = 0; k < 9; ++k) sums[k] += radiance * double{h.y[k]} / kDirections;
    expected += 4.0 * std::numbers::pi / kDirections * radiance * std::max(glm::dot(normal, d), 0.0);
  }
  for (std::size_t k = 0; k < 9; ++k) light.harmonics[k] = glm::vec3(float(sums[k]));
  CHECK(irradiance(light, glm::vec3(normal)).y == doctest::Approx(expected).epsilon(1e-3));
}

TEST_CASE("sunlight at a place is what a closed form leaves of it") {
  Scene scene;
  scene.clouds.reset();
  scene.atmosphere.enabled = false;
  scene.ground.enabled = false;
  scene.sun = {.azimuth_rad = 1.0, .elevation_rad = 0.9};
  ListedParticle sphere;
  sphere.center_m = {100.0, 2000.0, 1500.0};
  sphere.ellipsoid.diagonal_m = glm::vec3(500.0f);
  sphere.extinction_per_m = 0.003f;
  sphere.shape = ParticleShape::homogeneous;
  scene.particles = {sphere};
  RenderSettings settings{.width = 32, .height = 32};
  const auto renderer = renderer_of(scene, settings);
  CHECK_FALSE(renderer->light_at({dvec3(0.0)}));
  renderer->render({}, 0.0);
  const dvec3 sun = direction_from_angles(scene.sun.azimuth_rad, scene.sun.elevation_rad);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<dvec3> places;
  std::vector<double> expected;
  while (places.size() < 200) {
    const dvec3 at = dvec3(sphere.center_m) + 900.0 * dvec3(unit(random), unit(random), unit(random));
    const dvec3 from_center = at - dvec3(sphere.center_m);
    const double along = glm::dot(from_center, sun),
                 h2 = 500.0 * 500.0 - glm::dot(from_center, from_center) + along * along;
    const double end = h2 > 0.0 ? std::sqrt(h2) : 0.0;
    places.push_back(at);
    expected.push_back(std::exp(-0.003 * std::max(end - std::max(along, -end), 0.0)));
  }
  const auto light = renderer->light_at(places);
  REQUIRE(light);
  double square = 0.0, most = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double error = double{(*light)[i].sun_transmittance} - expected[i];
    square += error * error / double(places.size());
    most = std::max(most, std::abs(error));
  }
  CHECK(std::sqrt(square) < 0.015);  // what cells make of the sphere that its surface cuts
  CHECK(most < 0.15);
}
