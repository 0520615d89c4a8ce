// The multiple scattering table: solves the sphere at every density of the axis, gathers the radiance of orders >= 2
// for every (c, h) at twelve azimuths and fits a cubic in the azimuth's cosine (shared/table_axes.h).
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <Eigen/Dense>

#include "engine/check.h"
#include "engine/parallel.h"
#include "lut/bake.h"
#include "lut/sphere_solver.h"
#include "shared/table_axes.h"

namespace nephele {

namespace {

constexpr double kThinnest = 1e-3;   // stands for optical radius 0 after division by the scale
constexpr double kThickest = 200.0;  // with the thickest finite slice it gives the limit
constexpr int kAzimuths = 12;

using Slice = std::vector<Eigen::Vector4d>;  // [h][c]

double axis_middle(const ScatteringBake& bake) { return shared::density_axis_middle(static_cast<float>(bake.g)); }

Slice solve_slice(const ScatteringBake& bake, double sigma) {
  const SphereSolution solution =
      solve_sphere({bake.phase_function, bake.g, sigma}, sphere_grid(sigma, bake.coarse_solver), bake.residual);
  Slice slice(static_cast<std::size_t>(bake.chords) * bake.cosines);
  parallel_for(bake.chords, [&](int row) {
    const double h = static_cast<double>(row) / (bake.chords - 1);
    for (int column = 0; column < bake.cosines; ++column) {
      const double c =
          shared::normal_cosine_from_axis(static_cast<float>(column) / static_cast<float>(bake.cosines - 1));
      Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
      Eigen::Vector4d rhs = Eigen::Vector4d::Zero();
      for (int k = 0; k < kAzimuths; ++k) {
        const double x = std::cos(std::acos(-1.0) * (k + 0.5) / kAzimuths);
        const double mu = c * h + std::sqrt((1 - c * c) * (1 - h * h)) * x;
        // The scale without the opacity of the chord, which chord_source leaves out too.
        const float f = static_cast<float>(h), m = static_cast<float>(mu), s = static_cast<float>(sigma);
        const double tau = 2 * sigma * h;
        const double scale = h > 0 ? shared::multiple_scattering_scale(f, m, s, static_cast<float>(bake.g)) /
                                         shared::one_minus_exp(static_cast<float>(tau))
                                   : shared::multiple_scattering_scale(1e-6f / s, m, s, static_cast<float>(bake.g)) /
                                         shared::one_minus_exp(2e-6f);
        const double value = solution.chord_source(c, h, x) / scale;
        // Fit the value times its scale: least squares of the radiance itself over the azimuths.
        const Eigen::Vector4d basis(1, x, x * x, x * x * x);
        normal += scale * scale * basis * basis.transpose();
        rhs += scale * scale * value * basis;
      }
      slice[static_cast<std::size_t>(row) * bake.cosines + column] = normal.ldlt().solve(rhs);
    }
  });
  return slice;
}

std::uint16_t half_from(double value) {
  return static_cast<std::uint16_t>(glm::packHalf2x16(glm::vec2(static_cast<float>(value), 0.0f)) & 0xffffu);
}

}  // namespace

std::vector<double> slice_optical_radii(const ScatteringBake& bake) {
  std::vector<double> radii;
  for (int k = 0; k + 1 < bake.densities; ++k) {
    const double t = static_cast<double>(k) / (bake.densities - 1);
    radii.push_back(k == 0 ? kThinnest : axis_middle(bake) * t / (1 - t));
  }
  radii.push_back(std::max(kThickest, 2 * radii.back()));
  return radii;
}

NpyArray bake_multiple_scattering_array(const ScatteringBake& bake, const std::function<void(double)>& progress) {
  const std::vector<double> radii = slice_optical_radii(bake);
  const std::size_t texels = static_cast<std::size_t>(bake.chords) * bake.cosines;
  std::vector<Slice> slices;
  // The time of a solve: about the points of its rays, a few times over.
  const auto cost = [&](double sigma) {
    const SphereGrid grid = sphere_grid(sigma, bake.coarse_solver);
    return grid.radii * grid.thetas * grid.polars * grid.modes * grid.ray_points * (1 + 0.1 * std::log1p(sigma));
  };
  double total = 0, spent = 0;
  for (double sigma : radii) total += cost(sigma);
  for (double sigma : radii) {
    slices.push_back(solve_slice(bake, sigma));
    spent += cost(sigma);
    if (progress) progress(spent / total);
  }
  // The last slice is the limit of infinite density: linear in the axis from the two thickest solutions.
  const double middle = axis_middle(bake);
  const auto axis = [&](double sigma) { return sigma / (sigma + middle); };
  const std::size_t last = slices.size() - 1;
  const double beyond = (1 - axis(radii[last])) / (axis(radii[last]) - axis(radii[last - 1]));
  for (std::size_t i = 0; i < texels; ++i) {
    slices[last][i] += beyond * (slices[last][i] - slices[last - 1][i]);
    if (slices[last][i][0] < 0) slices[last][i].setZero();  // the dark side's limit is 0
  }

  NpyArray array;
  array.type = ElementType::float16;
  array.shape = {static_cast<std::size_t>(bake.densities), static_cast<std::size_t>(bake.chords),
                 static_cast<std::size_t>(bake.cosines), 4};
  array.data.resize(array.count() * 2);
  std::byte* out = array.data.data();
  for (const Slice& slice : slices) {
    for (const Eigen::Vector4d& coefficients : slice) {
      for (int k = 0; k < 4; ++k, out += 2) {
        const std::uint16_t half = half_from(coefficients[k]);
        out[0] = static_cast<std::byte>(half & 255);
        out[1] = static_cast<std::byte>(half >> 8);
      }
    }
  }
  return array;
}

}  // namespace nephele
