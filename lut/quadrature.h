// Gauss quadrature in double precision.
#pragma once

#include <vector>

namespace nephele {

struct QuadratureRule {
  std::vector<double> nodes, weights;
};

// Gauss-Legendre on [0, 1].
QuadratureRule gauss_legendre(int points);

// Gauss rule for the weight exp(-t) on [0, length], weights normalised to sum 1. length > 0, infinity allowed.
QuadratureRule gauss_exponential(int points, double length);

// Rules for every length in [0, inf), interpolated from a table of exact ones.
class ExponentialRules {
 public:
  explicit ExponentialRules(int points);
  int points() const { return points_; }
  // Writes points() nodes and weights.
  void evaluate(double length, double* nodes, double* weights) const;

 private:
  static constexpr int kIntervals = 512;
  int points_;
  std::vector<double> nodes_over_scale_, weights_;  // [interval][point]; nodes / (length / (length + 1))
};

}  // namespace nephele
