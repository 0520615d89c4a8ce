// Statistics of measured times. All are exact functions of the values; none assumes a distribution.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace nephele {

struct Percentiles {
  double median = 0, p95 = 0, min = 0;
};
// Nearest-rank percentiles (the median of an even count is the mean of the middle two); zeros for no values.
Percentiles percentiles(std::vector<double> values);

// A median and how far it can be trusted: the narrowest pair of order statistics that holds the true median with at
// least 95 % confidence, whatever the distribution. Fewer than six values cannot give that: the interval is their
// range.
struct MedianInterval {
  double median = 0, low = 0, high = 0;
};
MedianInterval median_interval(std::vector<double> values);

inline bool overlap(const MedianInterval& a, const MedianInterval& b) { return a.low <= b.high && b.low <= a.high; }

// The points that no other point beats: none is at most as large in both coordinates and smaller in one. Indices in
// order of x; of equal points the first one stands.
std::vector<std::size_t> pareto_front(std::span<const double> x, std::span<const double> y);

}  // namespace nephele
