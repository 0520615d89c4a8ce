// The prefix sum against std::exclusive_scan.
#include <doctest/doctest.h>

#include <numeric>
#include <random>

#include "passes/kit/prefix_sum.h"
#include "tests/support/test_device.h"

using namespace nephele;
using namespace nephele::test;

namespace {

constexpr std::uint32_t kGuard = 0xABCD1234u;

struct Scanned {
  std::vector<std::uint32_t> values;  // all of the buffer
  std::vector<std::uint32_t> total;   // four uints, the total at index 2
};

Scanned scan_on_device(PrefixSum& scan, const std::vector<std::uint32_t>& values, std::uint32_t n) {
  Buffer buffer(test_device(), "values", values.size() * 4);
  buffer.write_vector(values);
  Buffer total(test_device(), "total", 16);
  total.write_vector(std::vector<std::uint32_t>(4, kGuard));
  FrameBuilder frame(test_device());
  scan.add(frame, "scan", buffer, n, total, 8);
  FrameExecutor(test_device()).run(frame);
  return {buffer.read_vector<std::uint32_t>(values.size()), total.read_vector<std::uint32_t>(4)};
}

}  // namespace

TEST_CASE("prefix sum equals std::exclusive_scan at every level boundary, with each tuning") {
  for (const TestTuning tuning : kTestTunings) {
    CAPTURE(std::string(test_tuning_name(tuning)));
    const WithTuning with(tuning);
    Workshop make(test_kernels());
    PrefixSum scan(make, "test", 300000);
    std::mt19937 random(7);
    for (std::uint32_t n :
         {0u, 1u, 63u, 64u, 65u, 255u, 256u, 257u, 4095u, 4096u, 4097u, 65536u, 65537u, 262144u, 262145u, 300000u}) {
      CAPTURE(n);
      std::vector<std::uint32_t> values(n + 3);
      for (auto& value : values) value = random() % 1000;

      std::vector<std::uint32_t> expected = values;  // beyond n nothing changes
      std::exclusive_scan(values.begin(), values.begin() + n, expected.begin(), 0u);
      const std::uint32_t total = std::accumulate(values.begin(), values.begin() + n, 0u);

      const Scanned scanned = scan_on_device(scan, values, n);
      CHECK(scanned.values == expected);
      CHECK(scanned.total == std::vector<std::uint32_t>{kGuard, kGuard, total, kGuard});
    }
  }
}

TEST_CASE("prefix sum wraps like 32-bit integers") {
  Workshop make(test_kernels());
  PrefixSum scan(make, "test", 1000);
  const Scanned scanned = scan_on_device(scan, std::vector<std::uint32_t>(1000, 0x80000001u), 1000);
  CHECK(scanned.values[1] == 0x80000001u);
  CHECK(scanned.values[2] == 2u);
  CHECK(scanned.values[999] == 0x80000000u + 999u);
  CHECK(scanned.total[2] == 1000u);
}

TEST_CASE("one prefix sum object serves several sums of a frame") {
  Workshop make(test_kernels());
  PrefixSum scan(make, "test", 5000);
  Buffer a(test_device(), "a", 5000 * 4), b(test_device(), "b", 200 * 4), totals(test_device(), "totals", 8);
  a.write_vector(std::vector<std::uint32_t>(5000, 2));
  b.write_vector(std::vector<std::uint32_t>(200, 3));
  FrameBuilder frame(test_device());
  scan.add(frame, "a", a, 5000, totals, 0);
  scan.add(frame, "b", b, 200, totals, 4);
  FrameExecutor(test_device()).run(frame);
  CHECK(a.read_vector<std::uint32_t>(5000)[4999] == 9998);
  CHECK(b.read_vector<std::uint32_t>(200)[199] == 597);
  CHECK(totals.read_vector<std::uint32_t>(2) == std::vector<std::uint32_t>{10000, 600});
}
