// The nodes of the sphere solver.
#pragma once

#include <algorithm>
#include <cmath>

namespace nephele {

inline constexpr double kTau = 6.283185307179586476925286766559;
inline constexpr double kHalfTau = kTau / 2;

// Four Lagrange weights at place x between nodes 0..3.
inline void cubic_weights(double x, double* w) {
  w[0] = -(x - 1) * (x - 2) * (x - 3) / 6;
  w[1] = x * (x - 2) * (x - 3) / 2;
  w[2] = -x * (x - 1) * (x - 3) / 2;
  w[3] = x * (x - 1) * (x - 2) / 6;
}

// The polar node that stands for one beyond either end, where the direction comes down on the other side.
inline int mirrored_node(int node, int last) { return node < 0 ? -node : (node > last ? 2 * last - node : node); }

// Radii from the surface inwards, r(u) = 1 - sinh(kappa u) / sinh(kappa): the first interval is a small part of a mean
// free path, because J varies like x log x under the surface.
class RadialAxis {
 public:
  RadialAxis(int nodes, double sigma) : last_(nodes - 1) {
    const double first = 0.04 / sigma;
    double low = 1e-3, high = 30;
    if (first < 1.0 / last_) {
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (std::sinh(middle / last_) / std::sinh(middle) > first ? low : high) = middle;
      }
    } else {
      low = 1e-3;
    }
    kappa_ = low;
    sinh_kappa_ = std::sinh(kappa_);
  }
  double radius(int i) const { return i == last_ ? 0.0 : 1 - std::sinh(kappa_ * i / last_) / sinh_kappa_; }
  double index(double r) const { return std::asinh(std::max(0.0, 1 - r) * sinh_kappa_) / kappa_ * last_; }

 private:
  int last_;
  double kappa_, sinh_kappa_;
};

// Polar angles between direction and light, graded towards the phase function's peaks.
class PolarAxis {
 public:
  PolarAxis(int nodes, double g) : last_(nodes - 1), symmetric_(g < 0) {
    const double first = std::max(0.02, 0.5 * (1 - std::abs(g)));
    if (symmetric_) {
      strength_ = std::clamp(1 - first * last_ / kHalfTau, 0.0, 0.75);
      return;
    }
    double low = 1e-3, high = 6;
    if (first < kHalfTau / last_) {
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (kHalfTau * std::sinh(middle / last_) / std::sinh(middle) > first ? low : high) = middle;
      }
    }
    strength_ = low;
  }
  // Angle at node coordinate i in [0, last], its derivative, and the inverse.
  double angle(double i) const {
    const double u = i / last_;
    return symmetric_ ? kHalfTau * u - strength_ * 0.5 * std::sin(kTau * u)
                      : kHalfTau * std::sinh(strength_ * u) / std::sinh(strength_);
  }
  double derivative(double i) const {
    const double u = i / last_;
    return (symmetric_ ? kHalfTau * (1 - strength_ * std::cos(kTau * u))
                       : kHalfTau * strength_ * std::cosh(strength_ * u) / std::sinh(strength_)) /
           last_;
  }
  double index(double angle) const {
    if (!symmetric_) return std::asinh(angle / kHalfTau * std::sinh(strength_)) / strength_ * last_;
    double low = 0, high = last_;
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      (this->angle(middle) < angle ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }
  int last() const { return last_; }

 private:
  int last_;
  bool symmetric_;
  double strength_ = 0;
};

}  // namespace nephele
