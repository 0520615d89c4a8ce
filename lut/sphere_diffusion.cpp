#include "lut/sphere_diffusion.h"

#include <cmath>

#include <Eigen/SparseCholesky>

#include "engine/check.h"

namespace nephele {

struct SphereDiffusion::Factorization {
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
};

SphereDiffusion::SphereDiffusion(const RadialAxis& radial, int radii, int thetas, double sigma, double transport_sigma)
    : factorization_(std::make_unique<Factorization>()), volumes_(static_cast<std::size_t>(radii) * thetas) {
  const double diffusivity = 1 / (3 * transport_sigma);
  const double step = kHalfTau / (thetas - 1);
  const auto outer = [&](int i) { return i == 0 ? 1.0 : 0.5 * (radial.radius(i - 1) + radial.radius(i)); };
  const auto inner = [&](int i) { return i == radii - 1 ? 0.0 : 0.5 * (radial.radius(i) + radial.radius(i + 1)); };
  const auto lower = [&](int j) { return j == 0 ? 0.0 : (j - 0.5) * step; };
  const auto upper = [&](int j) { return j == thetas - 1 ? kHalfTau : (j + 0.5) * step; };
  std::vector<Eigen::Triplet<double>> entries;
  const auto couple = [&](int a, int b, double conductance) {
    entries.emplace_back(a, a, conductance);
    entries.emplace_back(b, b, conductance);
    entries.emplace_back(a, b, -conductance);
    entries.emplace_back(b, a, -conductance);
  };
  for (int i = 0; i < radii; ++i) {
    for (int j = 0; j < thetas; ++j) {
      const int cell = i * thetas + j;
      const double band = std::cos(lower(j)) - std::cos(upper(j));  // solid angle / 2 pi
      volumes_[cell] = sigma * band * (std::pow(outer(i), 3) - std::pow(inner(i), 3)) / 3;
      if (i == 0) entries.emplace_back(cell, cell, 0.5 * band);
      if (i + 1 < radii)
        couple(cell, cell + thetas,
               diffusivity * band * inner(i) * inner(i) / (radial.radius(i) - radial.radius(i + 1)));
      if (j + 1 < thetas) {
        const double face = std::sin(upper(j)) * (outer(i) * outer(i) - inner(i) * inner(i)) / 2;
        couple(cell, cell + 1, diffusivity * face / (0.5 * (outer(i) + inner(i)) * step));
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(radii * thetas, radii * thetas);
  matrix.setFromTriplets(entries.begin(), entries.end());
  factorization_->solver.compute(matrix);
  NEPHELE_CHECK(factorization_->solver.info() == Eigen::Success, sigma, ' ', transport_sigma);
}

SphereDiffusion::~SphereDiffusion() = default;

std::vector<double> SphereDiffusion::solve(const std::vector<double>& source) const {
  Eigen::VectorXd rhs(static_cast<Eigen::Index>(source.size()));
  for (std::size_t i = 0; i < source.size(); ++i) rhs[static_cast<Eigen::Index>(i)] = volumes_[i] * source[i];
  const Eigen::VectorXd flux = factorization_->solver.solve(rhs);
  return {flux.begin(), flux.end()};
}

}  // namespace nephele
