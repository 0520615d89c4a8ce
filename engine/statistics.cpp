#include "engine/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/check.h"

namespace nephele {
namespace {

constexpr double kConfidence = 0.95;

double median_of_sorted(const std::vector<double>& values) {
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

// The largest k for which the k-th smallest and the k-th largest of `count` values hold the median with the confidence
// asked for. The values below the median are binomial: they miss when fewer than k lie on one of its sides.
std::size_t trusted_rank(std::size_t count) {
  double outside = 0, probability = std::pow(0.5, static_cast<double>(count));  // of exactly `below` values on one side
  std::size_t rank = 1;
  for (std::size_t below = 0; below < count / 2; ++below) {
    outside += 2 * probability;
    if (outside > 1 - kConfidence) break;
    rank = below + 1;
    probability *= static_cast<double>(count - below) / static_cast<double>(below + 1);
  }
  return rank;
}

}  // namespace

Percentiles percentiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto rank95 = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(values.size())));
  return {.median = median_of_sorted(values), .p95 = values[rank95 - 1], .min = values[0]};
}

MedianInterval median_interval(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t rank = trusted_rank(values.size());
  return {.median = median_of_sorted(values), .low = values[rank - 1], .high = values[values.size() - rank]};
}

std::vector<std::size_t> pareto_front(std::span<const double> x, std::span<const double> y) {
  NEPHELE_CHECK(x.size() == y.size());
  std::vector<std::size_t> order(x.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return x[a] != x[b] ? x[a] < x[b] : y[a] < y[b]; });
  std::vector<std::size_t> front;
  for (const std::size_t point : order)
    if (front.empty() || y[point] < y[front.back()]) front.push_back(point);
  return front;
}

}  // namespace nephele
