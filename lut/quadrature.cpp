#include "lut/quadrature.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/check.h"

namespace nephele {

namespace {

// Golub and Welsch 1969: nodes and weights (summing to 1) from the recurrence coefficients of the orthogonal
// polynomials.
QuadratureRule golub_welsch(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& off_diagonal) {
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, off_diagonal);
  NEPHELE_CHECK(solver.info() == Eigen::Success);
  QuadratureRule rule;
  for (Eigen::Index i = 0; i < diagonal.size(); ++i) {
    rule.nodes.push_back(solver.eigenvalues()[i]);
    rule.weights.push_back(solver.eigenvectors()(0, i) * solver.eigenvectors()(0, i));
  }
  return rule;
}

}  // namespace

QuadratureRule gauss_legendre(int points) {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(points, 0.5);
  Eigen::VectorXd off(std::max(0, points - 1));
  for (int i = 1; i < points; ++i) off[i - 1] = 0.5 * i / std::sqrt(4.0 * i * i - 1.0);
  return golub_welsch(diagonal, off);
}

QuadratureRule gauss_exponential(int points, double length) {
  // Stieltjes' procedure on a fine discretisation of the measure; e^-40 is nothing.
  const double reach = std::min(length, 40.0);
  const QuadratureRule fine = gauss_legendre(16);
  const int panels = 32;
  Eigen::VectorXd t(16 * panels), w(16 * panels);
  for (int panel = 0; panel < panels; ++panel) {
    for (int i = 0; i < 16; ++i) {
      t[panel * 16 + i] = reach * (panel + fine.nodes[i]) / panels;
      w[panel * 16 + i] = fine.weights[i] * std::exp(-t[panel * 16 + i]);
    }
  }
  w /= w.sum();
  Eigen::VectorXd diagonal(points), off(std::max(0, points - 1));
  Eigen::VectorXd before = Eigen::VectorXd::Zero(t.size()), now = Eigen::VectorXd::Ones(t.size());
  double back = 0;
  for (int i = 0; i < points; ++i) {
    const Eigen::VectorXd weighted = w.array() * now.array();
    diagonal[i] = (weighted.array() * t.array() * now.array()).sum();
    Eigen::VectorXd next = (t.array() - diagonal[i]) * now.array() - back * before.array();
    back = std::sqrt((w.array() * next.array().square()).sum());
    if (i + 1 < points) off[i] = back;
    before = now;
    now = next / back;
  }
  return golub_welsch(diagonal, off);
}

ExponentialRules::ExponentialRules(int points) : points_(points) {
  for (int k = 0; k <= kIntervals; ++k) {
    // v = length / (length + 1); towards v = 0 the scaled rule tends to Gauss-Legendre on [0, 1].
    const double v = static_cast<double>(k) / kIntervals;
    const double length = k == kIntervals ? std::numeric_limits<double>::infinity() : v / (1 - v);
    const QuadratureRule rule = k == 0 ? gauss_legendre(points) : gauss_exponential(points, length);
    for (int i = 0; i < points; ++i) {
      nodes_over_scale_.push_back(k == 0 ? rule.nodes[i] : rule.nodes[i] / v);
      weights_.push_back(rule.weights[i]);
    }
  }
}

void ExponentialRules::evaluate(double length, double* nodes, double* weights) const {
  const double v = length / (length + 1);
  const double at = v * kIntervals;
  const int k = std::min(static_cast<int>(at), kIntervals - 1);
  const double f = at - k;
  const double* lower = &nodes_over_scale_[static_cast<std::size_t>(k) * points_];
  const double* weight = &weights_[static_cast<std::size_t>(k) * points_];
  for (int i = 0; i < points_; ++i) {
    nodes[i] = std::min(length, v * (lower[i] + f * (lower[i + points_] - lower[i])));
    weights[i] = weight[i] + f * (weight[i + points_] - weight[i]);
  }
}

}  // namespace nephele
