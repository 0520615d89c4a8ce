#include "lut/oracles.h"

#include <algorithm>
#include <cmath>

#include "engine/parallel.h"
#include "lut/quadrature.h"
#include "shared/phase.h"
#include "shared/reference_particle.h"

namespace nephele {

using glm::dvec3;

namespace {

const double kCircle = std::acos(-1.0);

double panel_integral(const std::function<double(double)>& f, double low, double high) {
  static const QuadratureRule rule = gauss_legendre(8);
  double sum = 0;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) sum += rule.weights[i] * f(low + (high - low) * rule.nodes[i]);
  return (high - low) * sum;
}

double refined_integral(const std::function<double(double)>& f, double low, double high, double tolerance, double whole,
                        int depth) {
  const double middle = 0.5 * (low + high);
  const double left = panel_integral(f, low, middle), right = panel_integral(f, middle, high);
  if (depth == 0 || std::abs(left + right - whole) <= tolerance) return left + right;
  return refined_integral(f, low, middle, tolerance / 2, left, depth - 1) +
         refined_integral(f, middle, high, tolerance / 2, right, depth - 1);
}

// Henyey and Greenstein's function inverted; Cornette and Shanks' is that times 1 + mu^2, by rejection.
double scattering_cosine(std::uint32_t phase_function, double g, UniformNumbers& uniform) {
  for (;;) {
    const double u = uniform(), q = (1 - g * g) / (1 - g + 2 * g * u);
    const double mu = std::abs(g) < 1e-6 ? 2 * u - 1 : (1 + g * g - q * q) / (2 * g);
    if (phase_function != shared::kPhaseCornetteShanks || uniform() < 0.5 * (1 + mu * mu)) return mu;
  }
}

dvec3 scattered(const dvec3& w, std::uint32_t phase_function, double g, UniformNumbers& uniform) {
  const double mu = scattering_cosine(phase_function, g, uniform);
  const double sine = std::sqrt(std::max(0.0, 1 - mu * mu)), phi = 2 * kCircle * uniform();
  const dvec3 side = normalize(cross(w, std::abs(w.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0))), up = cross(w, side);
  return normalize(mu * w + sine * (std::cos(phi) * side + std::sin(phi) * up));
}

// From p inside the unit sphere to its surface, along w.
double distance_out(const dvec3& p, const dvec3& w) {
  const double b = dot(p, w);
  return -b + std::sqrt(std::max(0.0, b * b + 1 - dot(p, p)));
}

Estimate estimate(double sum, double sum_of_squares, double count) {
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, sum_of_squares / count - mean * mean) / count)};
}

}  // namespace

double UniformNumbers::operator()() {
  std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

SphereRay random_sphere_ray(UniformNumbers& uniform) {
  const double h = std::sqrt(uniform()), c = 2 * uniform() - 1;
  return {c, h, c * h + std::sqrt((1 - c * c) * (1 - h * h)) * std::cos(2 * kCircle * uniform())};
}

double exit_power(int azimuths, const std::function<double(const SphereRay&)>& radiance) {
  constexpr int kCosines = 24, kChords = 20;
  const QuadratureRule cosines = gauss_legendre(kCosines), chords = gauss_legendre(kChords);
  std::vector<double> rows(2 * kCosines);
  parallel_for(2 * kCosines, [&](int i) {
    const double y = cosines.nodes[i % kCosines], c = i < kCosines ? -y * y : y * y;
    for (int j = 0; j < kChords; ++j) {
      const double h = chords.nodes[j], sines = std::sqrt((1 - c * c) * (1 - h * h));
      double around = 0;
      for (int k = 0; k < azimuths; ++k)
        around += radiance({c, h, c * h + sines * std::cos(kCircle * (k + 0.5) / azimuths)});
      rows[i] += cosines.weights[i % kCosines] * 2 * y * chords.weights[j] * h * around;
    }
  });
  double sum = 0;
  for (double row : rows) sum += row;
  return 4 * kCircle / azimuths * sum;
}

double direct_power(double sigma) {
  if (sigma < 1e-3) return 1 - 4 * sigma / 3;
  return (1 - std::exp(-2 * sigma) * (1 + 2 * sigma)) / (2 * sigma * sigma);
}

double exact_phase_per_sr(std::uint32_t phase_function, double mu, double g) {
  const double d = 1 + g * g - 2 * g * mu, peak = (1 - g * g) / (4 * kCircle * d * std::sqrt(d));
  return phase_function == shared::kPhaseCornetteShanks ? peak * 1.5 * (1 + mu * mu) / (2 + g * g) : peak;
}

double adaptive_integral(const std::function<double(double)>& f, double low, double high, double tolerance) {
  return refined_integral(f, low, high, tolerance, panel_integral(f, low, high), 40);
}

double exact_single_scattering(const SphereRay& ray, double sigma) {
  const double chord = 2 * ray.h;
  const auto term = [&](double u) {
    const double along = ray.c - u * ray.mu;
    const double path = std::max(0.0, along + std::sqrt(along * along + std::max(0.0, u * (chord - u))));
    return std::exp(-sigma * (u + path));
  };
  // Both path lengths are concave in u: the integrand peaks at an end, as thin as 1 / sigma. The panels to start from
  // shrink towards the ends until none can hide a peak.
  std::vector<double> ends{0.5};
  for (double width = 0.125; 2 * width * sigma * chord > 1 || width > 0.01; width /= 4) ends.push_back(width);
  ends.push_back(0);
  const double tolerance = 1e-9 * std::min(chord, 1 / std::max(sigma, 1e-30)) / static_cast<double>(2 * ends.size());
  double sum = 0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    sum += adaptive_integral(term, chord * ends[i + 1], chord * ends[i], tolerance);
    sum += adaptive_integral(term, chord * (1 - ends[i]), chord * (1 - ends[i + 1]), tolerance);
  }
  return sigma * sum;
}

double exact_mean_density(const shared::vec3& entry, const shared::vec3& exit, std::uint32_t seed) {
  // Panels of an eighth of a radius: the billows' third derivatives jump some three times a radius.
  const int panels = 1 + static_cast<int>(8 * length(exit - entry));
  const auto density = [&](double t) {
    return static_cast<double>(
        shared::reference_particle_density(entry + (exit - entry) * static_cast<float>(t), seed));
  };
  double sum = 0;
  for (int i = 0; i < panels; ++i)
    sum += adaptive_integral(density, static_cast<double>(i) / panels, (i + 1.0) / panels, 1e-5 / panels);
  return sum;
}

Estimate monte_carlo_multiple(const SphereProblem& problem, const SphereRay& ray, int paths, std::uint64_t seed) {
  const double sigma = problem.sigma, c = ray.c, h = ray.h;
  const double sin_c = std::sqrt(std::max(0.0, 1 - c * c)), sin_h = std::sqrt(std::max(0.0, 1 - h * h));
  const double x = sin_c * sin_h > 0 ? std::clamp((ray.mu - c * h) / (sin_c * sin_h), -1.0, 1.0) : 0.0;
  // Light travels along +z.
  const dvec3 normal(sin_c, 0, c);
  const dvec3 omega(h * sin_c - sin_h * x * c, sin_h * std::sqrt(1 - x * x), h * c + sin_h * x * sin_c);
  const double opacity = -std::expm1(-2 * sigma * h);
  UniformNumbers uniform(seed);
  double sum = 0, squares = 0;
  for (int i = 0; i < paths; ++i) {
    double t = -std::log1p(-opacity * uniform()) / sigma, value = 0;
    dvec3 p = normal, w = -omega;  // w: the way we walk, against the light's
    for (int order = 1;; ++order) {
      p += t * w;
      const double depth = sigma * (p.z + std::sqrt(std::max(0.0, 1 - p.x * p.x - p.y * p.y)));
      if (order >= 2 && depth < 40)  // exp(-40) is nothing
        value += exact_phase_per_sr(problem.phase_function, -w.z, problem.g) * std::exp(-depth);
      w = scattered(w, problem.phase_function, problem.g, uniform);
      t = -std::log1p(-uniform()) / sigma;
      if (t > distance_out(p, w)) break;
    }
    sum += value;
    squares += value * value;
  }
  const Estimate mean = estimate(sum, squares, paths);
  return {opacity * mean.mean, opacity * mean.standard_error};
}

Estimate OrderPowers::between(int first_order, int last_order) const {
  double sum = 0;
  for (int k = first_order; k <= std::min(last_order, static_cast<int>(share.size()) - 1); ++k) sum += share[k];
  return {sum, std::sqrt(sum * (1 - sum) / photons)};
}

OrderPowers monte_carlo_orders(const SphereProblem& problem, double g_first, int photons, std::uint64_t seed) {
  constexpr int kStreams = 64, kOrders = 256;
  struct Tally {
    std::vector<double> leaving = std::vector<double>(kOrders);
    double sum = 0, squares = 0;
  };
  std::vector<Tally> tallies(kStreams);
  const int each = std::max(1, photons / kStreams);
  parallel_for(kStreams, [&](int stream) {
    UniformNumbers uniform(seed * kStreams + stream);
    Tally& tally = tallies[stream];
    for (int i = 0; i < each; ++i) {
      const double b2 = uniform(), azimuth = 2 * kCircle * uniform(), b = std::sqrt(b2);
      dvec3 p(b * std::cos(azimuth), b * std::sin(azimuth), -std::sqrt(1 - b2)), w(0, 0, 1);
      int order = 0;
      for (;; ++order) {
        const double t = -std::log1p(-uniform()) / problem.sigma;
        if (t > distance_out(p, w)) break;
        p += t * w;
        w = scattered(w, problem.phase_function, order == 0 ? g_first : problem.g, uniform);
      }
      tally.leaving[std::min(order, kOrders - 1)] += 1;
      tally.sum += order;
      tally.squares += static_cast<double>(order) * order;
    }
  });
  OrderPowers powers;
  powers.photons = each * kStreams;
  powers.share.resize(kOrders);
  double sum = 0, squares = 0;
  for (const Tally& tally : tallies) {
    for (int k = 0; k < kOrders; ++k) powers.share[k] += tally.leaving[k] / powers.photons;
    sum += tally.sum;
    squares += tally.squares;
  }
  powers.scatterings = estimate(sum, squares, powers.photons);
  return powers;
}

}  // namespace nephele
