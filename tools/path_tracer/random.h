// Random numbers of one path: a stream of its own for every seed, pixel and sample, so that an image is the same
// whichever thread traces what.
#pragma once

#include <cstdint>

namespace nephele::truth {

// SplitMix64 (Steele, Lea and Flood, Fast splittable pseudorandom number generators, 2014).
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t pixel, std::uint64_t sample)
      : state_(mix(mix(mix(seed + kStep) + pixel) + sample)) {}

  // Uniform in [0, 1).
  float operator()() { return static_cast<float>(mix(state_ += kStep) >> 40) * 0x1p-24f; }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15u;
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

}  // namespace nephele::truth
