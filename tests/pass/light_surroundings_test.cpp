// What enters the light field from outside: how open cells lie, against ways through an even slab, and the mean of what
// surrounds them, against its definition.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/gtc/packing.hpp>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "nephele_shaders.h"
#include "passes/light/light_solver.h"
#include "shared/types.h"
#include "tests/support/test_device.h"

using namespace nephele;
using namespace nephele::test;
using glm::dvec3;
using shared::LightLattice;

namespace {

template <class T>
Buffer upload(const char* name, const std::vector<T>& values) {
  Buffer buffer(test_device(), name, values.size() * sizeof(T));
  buffer.write_vector(values);
  return buffer;
}

constexpr std::uint32_t kSide = 32, kHeight = 12, kRings = 24;
constexpr float kCellM = 60.0f, kLayerM = 40.0f, kForward = 0.7f;

LightLattice one_level() {
  LightLattice lattice{};
  lattice.level_count = 1;
  lattice.side = kSide;
  lattice.height = kHeight;
  lattice.layer_m = kLayerM;
  lattice.forward = kForward;
  lattice.levels[0] = {.corner_m = glm::vec2(-0.5f * kSide * kCellM),
                       .cell_m = kCellM,
                       .reach_m = 1e30f,
                       .extinction_plane = 1,
                       .radiance_plane = 1};
  return lattice;
}

}  // namespace

TEST_CASE("openness: the mean transmittance from cells of an even slab, by rings of height over the horizon") {
  constexpr float kSigma = 0.004f;  // 1/m
  std::vector<std::uint16_t> texels(std::size_t{kSide} * kSide * (kHeight + 2), glm::packHalf1x16(0.0f));
  std::fill(texels.begin() + kSide * kSide, texels.end() - kSide * kSide, glm::packHalf1x16(kSigma));
  Image extinction(test_device(), "extinction", {VK_FORMAT_R16_SFLOAT, kSide, kSide, kHeight + 2});
  extinction.write(std::as_bytes(std::span(texels)));
  const Buffer lattice = upload("lattice", std::vector{one_level()}),
               index = upload("index", std::vector<std::uint32_t>(kSide * kSide * kHeight, 1u)),
               parts(test_device(), "parts", kRings * sizeof(glm::vec2));
  FrameBuilder frame(test_device());
  frame.compute({.name = "openness",
                 .kernel = &test_kernels().compute(shaders::light_openness_comp),
                 .bindings = {{0, lattice, Access::storage_read},
                              {1, index, Access::words},
                              {2, extinction, Access::sampled},
                              {3, parts, Access::storage_write}},
                 .push = as_push(std::uint32_t{0}),
                 .groups = {1, kRings, 1}});
  FrameExecutor(test_device()).run(frame);
  const auto got = parts.read_vector<glm::vec2>(kRings);
  for (std::uint32_t ring = 0; ring < kRings; ++ring) {
    const double u = (2.0 * ring + 1.0) / kRings - 1.0, z = u * std::abs(u), across = std::sqrt(1.0 - z * z);
    // Every 8th column, each layer, and all azimuths, of which the kernel takes one a layer.
    double sum = 0.0;
    int count = 0;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        for (std::uint32_t layer = 0; layer < kHeight; ++layer)
          for (int k = 0; k < 64; ++k, ++count) {
            const double azimuth = 2.0 * std::numbers::pi * k / 64.0;
            const dvec3 at((8 * a + 0.5) * kCellM, (8 * b + 0.5) * kCellM, (layer + 0.5) * kLayerM);
            const dvec3 d(across * std::cos(azimuth), across * std::sin(azimuth), z);
            const dvec3 size(kSide * kCellM, kSide * kCellM, kHeight * kLayerM);
            double way_m = 1e9;
            for (int axis = 0; axis < 3; ++axis)
              if (std::abs(d[axis]) > 1e-9)
                way_m = std::min(way_m, ((d[axis] > 0.0 ? size[axis] : 0.0) - at[axis]) / d[axis]);
            sum += std::exp(-(1.0 - double{kForward}) * double{kSigma} * way_m);
          }
    CAPTURE(ring);
    CHECK(double{got[ring].y} == 16.0 * kHeight);
    CHECK(double{got[ring].x / got[ring].y} == doctest::Approx(sum / count).epsilon(0.03));
  }
  // The slab is high over the horizon all the same: steeper is more open.
  CHECK(got[kRings - 1].x > 1.1f * got[kRings / 2].x);
}

TEST_CASE("what enters along an ordinate: the mean of what cells see, and the clouds' own light for what they hide") {
  constexpr std::uint32_t kOfOrdinate = 5;
  struct Seen {  // LightSeen of shaders/light/light_openness.glsl
    glm::vec3 radiance, of_ground;
    float openness;
  };
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  std::vector<Seen> seen;
  std::vector<std::uint32_t> first_of;
  for (std::uint32_t k = 0; k <= shared::kLightOrdinates; ++k) first_of.push_back(k * kOfOrdinate);
  for (std::uint32_t i = 0; i < first_of.back(); ++i)
    seen.push_back({glm::vec3(unit(random), unit(random), unit(random)), glm::vec3(0.0f), 1.5f * unit(random)});
  const glm::vec4 of_cells(0.3f, 0.5f, 0.7f, 0.9f);  // mean, of seven cells
  std::vector<glm::vec4> sums(64 * (shared::kLightPairs + 2), glm::vec4(0.0f));
  sums[64 * shared::kLightPairs + 5] = 3.0f * of_cells;
  sums[64 * shared::kLightPairs + 60] = 4.0f * of_cells;
  sums[64 * (shared::kLightPairs + 1) + 7] = glm::vec4(7.0f);
  shared::FrameConstants constants{};
  constants.light_unit = 0.5f;
  const Image none(test_device(), "none", {});
  const auto boundary_of = [&](const std::vector<Seen>& around, const std::vector<glm::vec4>& of_sweep, bool swept) {
    const Buffer lattice = upload("lattice", std::vector{one_level()}),
                 frame_constants = upload("frame", std::vector{constants}), surroundings = upload("seen", around),
                 ranges = upload("ranges", first_of),
                 pairs = upload("pairs", light_pairs(kSide, kHeight, double{kCellM}, double{kLayerM})),
                 sum = upload("sums", of_sweep), floor = upload("floor", std::vector<float>(1, 0.0f)),
                 boundary(test_device(), "boundary", 2 * shared::kLightOrdinates * sizeof(glm::vec4));
    const SpecConstant without_air[] = {{0, false}};
    FrameBuilder frame(test_device());
    frame.compute({.name = "boundary",
                   .kernel = &test_kernels().compute(shaders::light_boundary_comp, without_air),
                   .bindings = {{0, lattice, Access::storage_read},
                                {1, frame_constants, Access::uniform},
                                {2, none, Access::sampled},
                                {3, none, Access::sampled},
                                {4, surroundings, Access::storage_read},
                                {5, ranges, Access::storage_read},
                                {6, pairs, Access::storage_read},
                                {7, sum, Access::storage_read},
                                {8, floor, Access::storage_read},
                                {9, boundary, Access::storage_write}},
                   .push = as_push(glm::uvec2(1, swept))});
    FrameExecutor(test_device()).run(frame);
    return boundary.read_vector<glm::vec4>(shared::kLightOrdinates);
  };
  for (const bool swept : {false, true}) {
    const auto got = boundary_of(seen, sums, swept);
    for (std::uint32_t k = 0; k < shared::kLightOrdinates; ++k) {
      glm::dvec4 direct(0.0), plain(0.0);
      double open = 0.0;
      for (std::uint32_t i = first_of[k]; i < first_of[k + 1]; ++i) {
        const glm::dvec4 radiance(0.0, glm::dvec3(seen[i].radiance) / 0.5);
        direct += double{seen[i].openness} * radiance / double{kOfOrdinate};
        plain += radiance / double{kOfOrdinate};
        open += double{seen[i].openness} / kOfOrdinate;
      }
      const glm::dvec4 expected =
          glm::max(direct + (1.0 - open) * (swept ? glm::dvec4(of_cells) : plain), glm::dvec4(0.0));
      for (int c = 0; c < 4; ++c) CHECK(double{got[k][c]} == doctest::Approx(expected[c]).epsilon(1e-5));
    }
  }
  // A white furnace: all that is seen and all cells are 1, and so is what enters, however open cells lie.
  for (Seen& s : seen) s.radiance = glm::vec3(0.5f);
  for (auto& s : sums) s.x = 0.0f;
  for (glm::vec4* s : {&sums[64 * shared::kLightPairs + 5], &sums[64 * shared::kLightPairs + 60]})
    *s = glm::vec4(0.0f, glm::vec3(3.5f));
  sums[64 * (shared::kLightPairs + 1) + 7] = glm::vec4(7.0f);
  for (const glm::vec4& b : boundary_of(seen, sums, true))
    for (int c = 1; c < 4; ++c) CHECK(double{b[c]} == doctest::Approx(1.0).epsilon(1e-6));
}
