// Truth to measure the tables against: in doubles, on the CPU, sharing no code with the bakes. Variables of a ray
// through the unit sphere: shaders/shared/scattering.h; albedo 1, irradiance 1.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "lut/sphere_solver.h"
#include "shared/prelude.h"

namespace nephele {

// Uniform numbers in [0, 1): SplitMix64 (Steele, Lea and Flood, Fast splittable pseudorandom number generators, 2014).
class UniformNumbers {
 public:
  explicit UniformNumbers(std::uint64_t seed) : state_(seed) {}
  double operator()();

 private:
  std::uint64_t state_;
};

struct SphereRay {
  double c = 0, h = 0, mu = 0;
};

// Impact parameter uniform in area, light from anywhere.
SphereRay random_sphere_ray(UniformNumbers& uniform);

// Power leaving the sphere over the incident power, for a radiance over all exit rays (c, h, mu): 2 times its integral
// over dc h dh dphi. Gauss points, dense at the terminator, by `azimuths` points around; runs on every core.
double exit_power(int azimuths, const std::function<double(const SphereRay&)>& radiance);
// The power that leaves without having been scattered.
double direct_power(double sigma);

// Per sr; the phase function's own formula, in doubles.
double exact_phase_per_sr(std::uint32_t phase_function, double mu, double g);

// Adaptive Gauss quadrature, until a panel and its two halves agree within the absolute tolerance.
double adaptive_integral(const std::function<double(double)>& f, double low, double high, double tolerance);

// Radiance of light scattered once, without its phase function: relative to the chord's bound 1e-9.
double exact_single_scattering(const SphereRay& ray, double sigma);

// Mean density of the reference particle along a chord, within about 1e-5.
double exact_mean_density(const shared::vec3& entry, const shared::vec3& exit, std::uint32_t seed);

struct Estimate {
  double mean = 0, standard_error = 0;
};

// Radiance of orders >= 2 along one view ray: walks backwards from the eye, the first collision forced into the sphere,
// the light seen from every later one.
Estimate monte_carlo_multiple(const SphereProblem& problem, const SphereRay& ray, int paths, std::uint64_t seed);

// Light followed through the sphere: what share of the incident power leaves after k scatterings, the first of them
// with asymmetry g_first.
struct OrderPowers {
  int photons = 0;
  std::vector<double> share;  // [k]; the last element holds all later orders, too
  Estimate scatterings;       // per photon: 4/3 sigma, whatever the phase function

  Estimate between(int first_order, int last_order) const;
};
OrderPowers monte_carlo_orders(const SphereProblem& problem, double g_first, int photons, std::uint64_t seed);

}  // namespace nephele
