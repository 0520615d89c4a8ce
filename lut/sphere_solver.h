// Multiple scattering in a homogeneous unit sphere lit by a beam of irradiance 1 along +z, albedo 1: solves for the
// source function J of all orders >= 2,
//   J = J2 + K J,   J2 = scattering integral of the once-scattered radiance,   K = scatter (trace J along rays).
//
// J(r, theta, alpha, m) are cosine modes of the azimuth beta = azimuth(direction) - azimuth(position); alpha is the
// angle between direction and light. In this global frame alpha is constant along a ray and the light's forward peak
// stays on the first alpha nodes, whatever the place. One application of K:
//   1. Lambda: mean of J along the backward ray with weight exp(-t), by Gauss points for that very weight; only this
//      smooth function is interpolated;
//   2. radiance L = Lambda (1 - exp(-T)): the opacity, with its kink at the horizon, enters by its azimuth modes;
//   3. the phase matrix per mode by product integration: exact integrals of the phase function times cubic bases.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace nephele {

struct SphereGrid {
  int radii, thetas, polars;
  int modes;       // 8 or 16, as many as azimuth samples
  int ray_points;  // of the Gauss rule along a ray
};

// The grid that suits an optical radius; `coarse` takes the cheapest one at any.
SphereGrid sphere_grid(double sigma, bool coarse);

struct SphereProblem {
  std::uint32_t phase_function = 0;
  double g = 0.85;
  double sigma = 1;               // > 0
  std::optional<double> g_first;  // of the first scattering, where it is not g
};

class SphereSolution {
 public:
  SphereSolution();
  SphereSolution(SphereSolution&&) noexcept;
  SphereSolution& operator=(SphereSolution&&) noexcept;
  ~SphereSolution();

  // Mean of J along the chord of the view ray (variables of shaders/shared/scattering.h; x = azimuth cosine). The
  // radiance of orders >= 2 is this times 1 - exp(-2 sigma h).
  double chord_source(double c, double h, double x) const;

  int applications() const;
  double residual() const;

 private:
  friend SphereSolution solve_sphere(const SphereProblem&, const SphereGrid&, double);
  friend SphereSolution sum_orders(const SphereProblem&, const SphereGrid&, int);
  struct State;
  std::unique_ptr<State> state_;
};

// residual: relative, at which GMRES stops. Without its diffusion preconditioner the residual would hardly see the dark
// side of thick spheres (at 1e-3 and sigma = 50 that side is still 78 % too dark); with it 3e-5 leaves 0.5 %.
SphereSolution solve_sphere(const SphereProblem& problem, const SphereGrid& grid, double residual);

// Orders 2 to last_order alone, one application of K for each after the second; no residual.
SphereSolution sum_orders(const SphereProblem& problem, const SphereGrid& grid, int last_order);

}  // namespace nephele
