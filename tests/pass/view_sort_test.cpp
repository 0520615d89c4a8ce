// The order of drawing against distances on the host.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>

#include "passes/layer/view_sort.h"
#include "shared/types.h"
#include "tests/support/test_device.h"

using namespace nephele;
using nephele::test::test_device;
using nephele::test::test_kernels;
using shared::FrameCounters;
using shared::Particle;

namespace {

std::vector<std::uint32_t> draw_order(const std::vector<Particle>& particles, const std::vector<std::uint32_t>& seen) {
  const std::uint32_t count = static_cast<std::uint32_t>(seen.size());
  Buffer particle_buffer(test_device(), "particles", std::max<std::size_t>(particles.size(), 1) * sizeof(Particle));
  if (!particles.empty()) particle_buffer.write_vector(particles);
  Buffer visible(test_device(), "visible", (count + 1) * sizeof(std::uint32_t));
  std::vector<std::uint32_t> padded = seen;
  padded.push_back(0);
  visible.write_vector(padded);
  FrameCounters counts{};
  counts.visible_count = count;
  counts.visible_groups = glm::uvec3((count + 63) / 64, 1, 1);
  Buffer counters(test_device(), "counters", sizeof counts);
  counters.write(std::as_bytes(std::span(&counts, 1)));

  Workshop make(test_kernels());
  ViewSort sort(make, count + 10);
  FrameBuilder frame(test_device());
  const Buffer& order = sort.add(frame, particle_buffer, visible, counters);
  FrameExecutor(test_device()).run(frame);
  return order.read_vector<std::uint32_t>(count);
}

Particle at(glm::vec3 center_m) {
  Particle particle;
  std::memset(&particle, 0, sizeof particle);
  particle.center_m = center_m;
  return particle;
}

}  // namespace

TEST_CASE("drawing order is back to front by true distance, equal distances by slot") {
  std::mt19937 random(4);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> exponent(0.0f, 6.5f);
  for (std::uint32_t count : {0u, 1u, 2u, 777u, 20000u}) {
    CAPTURE(count);
    std::vector<Particle> particles(count + 5);
    for (std::size_t i = 0; i < particles.size(); ++i) {
      const glm::vec3 direction = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
      // A quarter share a place with an earlier one.
      particles[i] = i % 4 == 3 ? particles[i / 2] : at(std::pow(10.0f, exponent(random)) * direction);
    }
    std::vector<std::uint32_t> seen(count);
    std::iota(seen.begin(), seen.end(), 5u);
    std::shuffle(seen.begin(), seen.end(), random);

    const std::vector<std::uint32_t> order = draw_order(particles, seen);
    std::vector<std::uint32_t> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (std::uint32_t slot = 0; slot < count; ++slot) REQUIRE(sorted[slot] == slot);
    for (std::uint32_t k = 1; k < count; ++k) {
      const glm::vec3 before = particles[seen[order[k - 1]]].center_m, after = particles[seen[order[k]]].center_m;
      const double farther = glm::length(glm::dvec3(before)), nearer = glm::length(glm::dvec3(after));
      REQUIRE(nearer <= farther * (1.0 + 2.5e-6));  // the key's 19 bits of mantissa
      if (before == after) REQUIRE(order[k - 1] < order[k]);
    }
    CHECK(draw_order(particles, seen) == order);
  }
}

TEST_CASE("drawing order at the ends of the range: at the eye, and across the planet") {
  const std::vector<Particle> particles = {at({0, 0, 0}),    at({1e30f, 0, 0}),  at({0, 0, 0.5f}),
                                           at({0, 3e7f, 0}), at({0, 1e-30f, 0}), at({6.4e6f, 0, 0})};
  CHECK(draw_order(particles, {0, 1, 2, 3, 4, 5}) == std::vector<std::uint32_t>{1, 3, 5, 2, 0, 4});
}
