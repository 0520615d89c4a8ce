// Statistics on numbers whose answers are known: by hand, from tables of the sign test, and by drawing samples.
#include "engine/statistics.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

using namespace nephele;

namespace {

std::vector<double> one_to(int count) {
  std::vector<double> values(static_cast<std::size_t>(count));
  std::iota(values.begin(), values.end(), 1.0);
  std::shuffle(values.begin(), values.end(), std::mt19937(3));
  return values;
}

}  // namespace

TEST_CASE("percentiles: nearest rank, the middle two averaged") {
  CHECK(percentiles({}).median == 0);
  CHECK(percentiles({7}).p95 == 7);
  const Percentiles even = percentiles({4, 1, 3, 2});
  CHECK(even.median == 2.5);
  CHECK(even.min == 1);
  CHECK(even.p95 == 4);
  CHECK(percentiles(one_to(100)).p95 == 95);
  CHECK(percentiles(one_to(20)).p95 == 19);
  CHECK(percentiles(one_to(21)).p95 == 20);
}

TEST_CASE("the median's interval is the one that tables of the sign test give") {
  struct Row {
    int count, low, high;  // ranks; two-sided 95 %
  };
  for (const Row& row :
       {Row{1, 1, 1}, Row{2, 1, 2}, Row{5, 1, 5}, Row{6, 1, 6}, Row{8, 1, 8}, Row{9, 2, 8}, Row{11, 2, 10},
        Row{12, 3, 10}, Row{15, 4, 12}, Row{20, 6, 15}, Row{25, 8, 18}, Row{50, 18, 33}, Row{100, 40, 61}}) {
    CAPTURE(row.count);
    const MedianInterval interval = median_interval(one_to(row.count));
    CHECK(interval.low == row.low);
    CHECK(interval.high == row.high);
    CHECK(interval.median == 0.5 * (row.count + 1));
  }
}

TEST_CASE("the median's interval holds the true median of a lopsided distribution as often as it says") {
  std::mt19937 random(1);
  std::exponential_distribution<double> exponential(1.0);
  constexpr int kTrials = 20000;
  for (const int count : {7, 15}) {
    int held = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::vector<double> values(static_cast<std::size_t>(count));
      for (double& value : values) value = exponential(random);
      const MedianInterval interval = median_interval(values);
      if (interval.low <= std::log(2.0) && std::log(2.0) <= interval.high) ++held;
    }
    // 1 - 2 * 2^-7 and 1 - 2 * (1 + 15 + 105 + 455) / 2^15, to four standard deviations of 20 000 trials.
    const double expected = count == 7 ? 0.984375 : 0.96484375;
    CHECK(std::abs(double(held) / kTrials - expected) < 4 * std::sqrt(expected * (1 - expected) / kTrials));
  }
}

TEST_CASE("intervals overlap when they share a point") {
  CHECK(overlap({2, 1, 3}, {4, 3, 5}));
  CHECK(overlap({2, 1, 9}, {4, 3, 5}));
  CHECK_FALSE(overlap({2, 1, 2.9}, {4, 3, 5}));
  CHECK_FALSE(overlap({4, 3, 5}, {2, 1, 2.9}));
}

TEST_CASE("the Pareto front: what no other point beats") {
  CHECK(pareto_front({}, {}).empty());
  const std::vector<double> x{3, 1, 2, 4, 2}, y{1, 9, 5, 1, 6};
  CHECK(pareto_front(x, y) == std::vector<std::size_t>{1, 2, 0});
  const std::vector<double> same_x{1, 1, 1}, same_y{2, 1, 1};
  CHECK(pareto_front(same_x, same_y) == std::vector<std::size_t>{1});
}
