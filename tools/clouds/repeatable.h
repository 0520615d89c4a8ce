// Numbers that are the same on every machine: random ones by integer hashes, and functions made of additions,
// multiplications and square roots alone, whose results the IEEE standard fixes. Compiled without contraction to fused
// operations (CMakeLists.txt). The mathematics library's own functions may differ in their last digit.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

namespace nephele::clouds {

// A sequence that depends on seed and stream alone. Sequences of different streams have nothing in common.
class RandomSequence {
 public:
  RandomSequence(std::uint32_t seed, std::uint32_t stream) : seed_(seed), stream_(stream) {}

  // In [0, 1).
  double unit();
  // In [low, high).
  double between(double low, double high) { return low + (high - low) * unit(); }
  // Of mean 0 and standard deviation 1: the sum of twelve uniform numbers, so never beyond 6.
  double normal();
  // A size between the two whose density falls with its third power, as those of convective elements about do: many
  // small, few large.
  double size(double smallest, double largest);
  // Of length 1, its upward component between the two, else anywhere.
  glm::dvec3 direction(double lowest_up = -1.0, double highest_up = 1.0);
  // 0 .. count - 1.
  std::uint32_t index(std::uint32_t count);

 private:
  std::uint32_t bits();

  std::uint32_t seed_, stream_, count_ = 0;
};

// e^-x for x >= 0, to a relative 2e-4 where x is below 1; 0 from 100 on.
double falling_exponential(double x);

struct SineCosine {
  double sine, cosine;
};
// Of any angle up to 1e6 rad, to 1e-9.
SineCosine sine_cosine(double angle_rad);

}  // namespace nephele::clouds
