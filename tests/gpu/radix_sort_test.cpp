// The radix sort against std::stable_sort.
#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "passes/kit/radix_sort.h"
#include "tests/support/test_device.h"

using namespace nephele;
using namespace nephele::test;

namespace {

using Uints = std::vector<std::uint32_t>;

struct Pairs {
  Uints keys, values;
};

Pairs sort_on_device(RadixSort& sort, const Pairs& pairs, std::uint32_t count, std::uint32_t key_bits) {
  Uints keys = pairs.keys, values = pairs.values;
  keys.resize(sort.capacity(), 0u);  // beyond the count: keys that would come first
  values.resize(sort.capacity(), 0xDEADu);
  const_cast<Buffer&>(sort.keys()).write_vector(keys);
  const_cast<Buffer&>(sort.values()).write_vector(values);
  Buffer counter(test_device(), "counter", 12);
  counter.write_vector(Uints{7, count, 9});
  FrameBuilder frame(test_device());
  const RadixSort::Sorted sorted = sort.add(frame, "sort", counter, 4, key_bits);
  FrameExecutor(test_device()).run(frame);
  const std::size_t n = std::min(count, sort.capacity());
  return {sorted.keys.read_vector<std::uint32_t>(n), sorted.values.read_vector<std::uint32_t>(n)};
}

Pairs sort_on_host(const Pairs& pairs, std::uint32_t key_bits) {
  const std::uint32_t mask = key_bits == 32 ? 0xFFFFFFFFu : (1u << key_bits) - 1u;
  std::vector<std::size_t> order(pairs.keys.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return (pairs.keys[a] & mask) < (pairs.keys[b] & mask); });
  Pairs sorted;
  for (std::size_t i : order) {
    sorted.keys.push_back(pairs.keys[i]);
    sorted.values.push_back(pairs.values[i]);
  }
  return sorted;
}

Pairs random_pairs(std::uint32_t count, std::uint32_t key_mask, std::uint32_t seed) {
  std::mt19937 random(seed);
  Pairs pairs{Uints(count), Uints(count)};
  for (std::uint32_t i = 0; i < count; ++i) {
    pairs.keys[i] = random() & key_mask;
    pairs.values[i] = i;
  }
  return pairs;
}

}  // namespace

TEST_CASE("radix sort equals std::stable_sort, values and all, with each tuning") {
  for (const TestTuning tuning : kTestTunings) {
    CAPTURE(std::string(test_tuning_name(tuning)));
    const WithTuning with(tuning);
    Workshop make(test_kernels());
    RadixSort sort(make, "test", 100000);
    for (std::uint32_t count : {0u, 1u, 2u, 63u, 64u, 65u, 511u, 512u, 513u, 4097u, 99999u, 100000u}) {
      CAPTURE(count);
      const Pairs pairs = random_pairs(count, 0xFFFFFFFFu, count);
      const Pairs expected = sort_on_host(pairs, 32), sorted = sort_on_device(sort, pairs, count, 32);
      CHECK(sorted.keys == expected.keys);
      CHECK(sorted.values == expected.values);
    }
  }
}

TEST_CASE("radix sort is stable: few and equal keys keep their order, with each tuning") {
  for (const TestTuning tuning : kTestTunings) {
    CAPTURE(std::string(test_tuning_name(tuning)));
    const WithTuning with(tuning);
    Workshop make(test_kernels());
    RadixSort sort(make, "test", 20000);
    for (std::uint32_t mask : {0u, 1u, 0x80000000u, 0x01010101u}) {
      CAPTURE(mask);
      const Pairs pairs = random_pairs(20000, mask, 3);
      CHECK(sort_on_device(sort, pairs, 20000, 32).values == sort_on_host(pairs, 32).values);
    }
  }
}

TEST_CASE("radix sort orders by the low key bits only, in as many rounds as they need") {
  Workshop make(test_kernels());
  RadixSort sort(make, "test", 5000);
  for (std::uint32_t bits : {1u, 7u, 8u, 9u, 14u, 16u, 17u, 24u, 31u}) {
    CAPTURE(bits);
    const Pairs pairs = random_pairs(5000, 0xFFFFFFFFu, bits);
    const Pairs expected = sort_on_host(pairs, bits), sorted = sort_on_device(sort, pairs, 5000, bits);
    CHECK(sorted.keys == expected.keys);
    CHECK(sorted.values == expected.values);
  }
}

TEST_CASE("radix sort handles ordered and reversed keys, and a count beyond its capacity") {
  Workshop make(test_kernels());
  RadixSort sort(make, "test", 3000);
  Pairs pairs{Uints(3000), Uints(3000)};
  std::iota(pairs.values.begin(), pairs.values.end(), 0u);
  for (bool reversed : {false, true})
    for (std::uint32_t count : {3000u, 0xFFFFFFFFu}) {
      CAPTURE(reversed);
      CAPTURE(count);
      for (std::uint32_t i = 0; i < 3000; ++i) pairs.keys[i] = reversed ? 0xFFFFFFFFu - i : i * 70000u;
      CHECK(sort_on_device(sort, pairs, count, 32).values == sort_on_host(pairs, 32).values);
    }
}
