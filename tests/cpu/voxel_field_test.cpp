// The voxels as a medium for the path tracer, against integrals along straight lines by hand.
#include "tools/path_tracer/voxel_field.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <numbers>
#include <utility>
#include <vector>

#include "tools/path_tracer/random.h"

using namespace nephele;
using namespace nephele::truth;
using glm::vec3;

namespace {

// Three by two by two voxels of 100, 200 and 50 to 150 m: the first has 0.01 /m, the last 0.03, the others nothing.
Voxels few_voxels() {
  Voxels voxels;
  voxels.bounds_m = {std::vector<double>{0, 100, 200, 300}, {0, 200, 400}, {0, 50, 200}};
  voxels.extinction_per_m.assign(12, 0.0f);
  voxels.extinction_per_m.front() = 0.01f;
  voxels.extinction_per_m.back() = 0.03f;
  return voxels;
}

// The mean of many rays, and how far it may be off: four of its standard deviations.
template <class Sample>
std::pair<double, double> mean_of(Sample&& sample) {
  constexpr int kRays = 20000;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kRays; ++i) {
    const double x = static_cast<double>(sample());
    sum += x;
    squares += x * x;
  }
  const double mean = sum / kRays;
  return {mean, 4.0 * std::sqrt((squares / kRays - mean * mean) / kRays) + 1e-6};
}

}  // namespace

TEST_CASE("voxel field: places, heading and scale are those of a placed set") {
  Placement at;
  at.at_m = {1000.0, 2000.0, 500.0};
  const glm::dvec3 camera_m(900.0, 1900.0, 600.0);
  const VoxelField plain(few_voxels(), at, camera_m, vec3(0, 0, 1));
  CHECK(plain.extinction_per_m(vec3(150.0f, 200.0f, -80.0f)) == 0.01f);  // 50, 100, 20 in the volume
  CHECK(plain.extinction_per_m(vec3(150.0f, 200.0f, -40.0f)) == 0.0f);   // above the low layer
  CHECK(plain.extinction_per_m(vec3(350.0f, 400.0f, 50.0f)) == 0.03f);
  CHECK(plain.extinction_per_m(vec3(-50.0f, 0.0f, 0.0f)) == 0.0f);
  // Turned by a quarter clockwise: its x points south, its y east; twice as large, half as dense.
  at.heading_rad = std::numbers::pi / 2;
  at.scale = 2.0;
  const VoxelField turned(few_voxels(), at, camera_m, vec3(0, 0, 1));
  const vec3 origin(at.at_m - camera_m);
  CHECK(turned.extinction_per_m(origin + 2.0f * vec3(100.0f, -50.0f, 20.0f)) == 0.005f);
  CHECK(turned.extinction_per_m(origin + 2.0f * vec3(300.0f, -250.0f, 150.0f)) == 0.015f);
}

TEST_CASE("voxel field: transmittance and free paths along rays are those of the voxels that they cross") {
  Placement at;
  at.at_m = {0.0, 0.0, 1000.0};
  const glm::dvec3 camera_m(-500.0, 100.0, 1025.0);
  const VoxelField field(few_voxels(), at, camera_m, vec3(0, 0, 1));
  Random random(7, 1, 0);
  // Along x through the first voxel alone: a depth of 1.
  const auto [t, t_error] = mean_of([&] { return field.transmittance(vec3(0.0f), vec3(1, 0, 0), 2000.0f, random); });
  CHECK(std::abs(t - std::exp(-1.0)) < t_error);
  const auto [hit, hit_error] = mean_of([&] {
    const float at_m = field.collide(vec3(0.0f), vec3(1, 0, 0), 2000.0f, random);
    if (at_m != Medium::kNever) CHECK((at_m >= 499.9f && at_m <= 600.1f));
    return at_m == Medium::kNever ? 0.0f : 1.0f;
  });
  CHECK(std::abs(hit - (1.0 - std::exp(-1.0))) < hit_error);
  // Up to its middle, and aslant through both: lengths by the planes that the ray crosses.
  const auto [half, half_error] =
      mean_of([&] { return field.transmittance(vec3(0.0f), vec3(1, 0, 0), 550.0f, random); });
  CHECK(std::abs(half - std::exp(-0.5)) < half_error);
  const vec3 from(500.0f, -100.0f, -25.0f), to(800.0f, 300.0f, 175.0f);  // corner to corner
  const float length_m = glm::length(to - from);
  const double low = 0.01 * 0.25 * static_cast<double>(length_m);  // leaves the low layer after a quarter of the way
  const double high = 0.03 / 3.0 * static_cast<double>(length_m);  // x from 200 to 300
  const auto [both, both_error] =
      mean_of([&] { return field.transmittance(from - (to - from), glm::normalize(to - from), 1e5f, random); });
  CHECK(std::abs(both - std::exp(-low - high)) < both_error);
  // Looked for in steps of a 16th of a cell's least side, which is 400 m here.
  CHECK(std::abs(field.first_matter_m(vec3(0.0f), vec3(1, 0, 0), 1e5f) - 500.0f) < 25.1f);
  CHECK(field.first_matter_m(vec3(0.0f), vec3(0, 0, 1), 1e5f) == Medium::kNever);
}
