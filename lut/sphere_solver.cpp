#include "lut/sphere_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "engine/parallel.h"
#include "lut/gmres.h"
#include "lut/quadrature.h"
#include "lut/sphere_axes.h"
#include "lut/sphere_diffusion.h"
#include "lut/sphere_kernels.h"
#include "shared/phase.h"

namespace nephele {

namespace {

double phase_per_sr(const SphereProblem& problem, double mu, double g) {
  return shared::phase_per_sr(problem.phase_function, static_cast<float>(mu), static_cast<float>(g));
}

constexpr int kRefine = 3;  // fine polar nodes per coarse interval: they resolve the horizon's kink

}  // namespace

struct SphereSolution::State {
  State(const SphereProblem& p, const SphereGrid& g);

  // Indices. J: [polar][radius][theta][mode]; slices carry a ghost row on either side of theta.
  std::size_t slice_floats() const { return static_cast<std::size_t>(grid.radii) * (grid.thetas + 2) * grid.modes; }
  std::size_t size() const { return static_cast<std::size_t>(grid.polars) * grid.radii * grid.thetas * grid.modes; }
  double theta(int j) const { return kHalfTau * j / (grid.thetas - 1); }

  void build();
  void build_rays();
  void build_opacity_modes();
  void build_phase_matrices();
  std::vector<float> second_order_source();
  void apply(const float* source, float* scattered);
  void add_diffusion(const float* rest, float* corrected) const;
  void fill_slice(const float* source, int polar, float* slice) const;
  void keep(const float* source);
  RayPoint locate(double x, double y, double z, double azimuth) const;
  void scatter_cell(int cell, const float* fine_lambda, const AlignedFloats& matrix, float* scattered) const;

  SphereProblem problem;
  SphereGrid grid;
  RadialAxis radial;
  PolarAxis polar;
  int fine_polars;
  SphereDiffusion diffusion;
  std::vector<double> polar_weights;  // of the integral over all directions of a cubic through the polar nodes
  ExponentialRules ray_rules, gather_rules;
  CosineTable cosines;
  std::vector<RayPoint> rays;   // [polar][radius][theta][azimuth][point]
  AlignedFloats opacity_modes;  // [radius][theta][fine polar][2 modes]: of 1 - exp(-T)
  AlignedFloats phase_matrix;   // [polar][fine polar][mode]
  AlignedFloats beam_matrix;    // the same, with the beam's phase function inside the integral
  AlignedFloats lambda;         // [radius][theta][polar][mode], scratch
  AlignedFloats slices;         // J with ghosts: [polar][radius][theta + 2][mode]
  int applications = 0;
  double residual = 0;
};

SphereSolution::State::State(const SphereProblem& p, const SphereGrid& g)
    : problem(p),
      grid(g),
      radial(g.radii, p.sigma),
      polar(g.polars, p.g),
      fine_polars((g.polars - 1) * kRefine + 1),
      diffusion(radial, g.radii, g.thetas, p.sigma,
                p.sigma * (1 - shared::phase_mean_cosine(p.phase_function, static_cast<float>(p.g)))),
      ray_rules(g.ray_points),
      gather_rules(16),
      cosines(g.modes) {
  lambda.resize(size());
  slices.resize(slice_floats() * grid.polars);
  polar_weights.assign(grid.polars, 0.0);
  const QuadratureRule rule = gauss_legendre(6);
  for (int interval = 0; interval < polar.last(); ++interval) {
    for (std::size_t q = 0; q < rule.nodes.size(); ++q) {
      const double place = interval + rule.nodes[q];
      const double measure = rule.weights[q] * polar.derivative(place) * kTau * std::sin(polar.angle(place));
      double w[4];
      cubic_weights(rule.nodes[q] + 1, w);
      for (int tap = 0; tap < 4; ++tap)
        polar_weights[mirrored_node(interval - 1 + tap, polar.last())] += measure * w[tap];
    }
  }
}

// Distance from p = (r, at angle with cosine `cosine` to the direction) backwards along the direction to the surface.
static double backward_distance(double r, double cosine) {
  const double along = r * cosine;
  return std::max(0.0, along + std::sqrt(std::max(0.0, 1 - r * r + along * along)));
}

RayPoint SphereSolution::State::locate(double x, double y, double z, double azimuth) const {
  const double rho = std::hypot(x, y);
  const double r = std::min(1.0, std::hypot(rho, z));
  RayPoint point;
  const double at = radial.index(r);
  const int i = std::clamp(static_cast<int>(std::floor(at)) - 1, 0, grid.radii - 4);
  const double theta_at = std::atan2(rho, z) / kHalfTau * (grid.thetas - 1);
  const int j = std::clamp(static_cast<int>(std::floor(theta_at)), 0, grid.thetas - 2);
  double w[4];
  cubic_weights(at - i, w);
  for (int k = 0; k < 4; ++k) point.radius_weights[k] = static_cast<float>(w[k]);
  cubic_weights(theta_at - (j - 1), w);
  for (int k = 0; k < 4; ++k) point.theta_weights[k] = static_cast<float>(w[k]);
  point.offset = (i * (grid.thetas + 2) + j) * grid.modes;
  point.cosine_at = cosines.place(azimuth - std::atan2(y, x));
  return point;
}

void SphereSolution::State::build() {
  build_rays();
  build_opacity_modes();
  build_phase_matrices();
}

void SphereSolution::State::build_rays() {
  const int azimuths = grid.modes, points = grid.ray_points;
  const int cells = grid.radii * grid.thetas;
  rays.resize(static_cast<std::size_t>(grid.polars) * cells * azimuths * points);
  parallel_for(grid.polars * grid.radii, [&](int task) {
    const int a = task / grid.radii, i = task % grid.radii;
    const double alpha = polar.angle(a), r = radial.radius(i);
    double t[32], w[32];
    for (int j = 0; j < grid.thetas; ++j) {
      for (int b = 0; b < azimuths; ++b) {
        const double beta = kHalfTau * (b + 0.5) / azimuths;
        const double ox = std::sin(alpha) * std::cos(beta), oy = std::sin(alpha) * std::sin(beta), oz = std::cos(alpha);
        const double px = r * std::sin(theta(j)), pz = r * std::cos(theta(j));
        const double cosine = std::sin(theta(j)) * ox + std::cos(theta(j)) * oz;
        ray_rules.evaluate(problem.sigma * backward_distance(r, cosine), t, w);
        RayPoint* out = &rays[((static_cast<std::size_t>(a) * cells + i * grid.thetas + j) * azimuths + b) * points];
        for (int k = 0; k < points; ++k) {
          const double u = t[k] / problem.sigma;
          out[k] = locate(px - u * ox, -u * oy, pz - u * oz, beta);
          for (float& weight : out[k].radius_weights) weight *= static_cast<float>(w[k]);
        }
      }
    }
  });
}

// Azimuth modes of 1 - exp(-T): quadrature on either side of the horizon, dense towards it.
void SphereSolution::State::build_opacity_modes() {
  const int modes = 2 * grid.modes;
  const QuadratureRule rule = gauss_legendre(20);
  opacity_modes.assign(static_cast<std::size_t>(grid.radii) * grid.thetas * fine_polars * modes, 0.0f);
  parallel_for(grid.radii * grid.thetas, [&](int cell) {
    const double r = radial.radius(cell / grid.thetas), th = theta(cell % grid.thetas);
    std::vector<double> sums(modes);
    for (int f = 0; f < fine_polars; ++f) {
      const double alpha = polar.angle(static_cast<double>(f) / kRefine);
      const double a = std::cos(th) * std::cos(alpha), b = std::sin(th) * std::sin(alpha);
      // The horizon: cosine between direction and radius = 0.
      const double horizon = b > 1e-9 ? std::acos(std::clamp(-a / b, -1.0, 1.0)) : kHalfTau / 2;
      std::fill(sums.begin(), sums.end(), 0.0);
      for (const double end : {0.0, kHalfTau}) {
        const double range = end - horizon;
        for (std::size_t k = 0; k < rule.nodes.size(); ++k) {
          const double x = rule.nodes[k];
          const double beta = horizon + range * x * x;
          const double weight = std::abs(range) * 2 * x * rule.weights[k];
          const double t = problem.sigma * backward_distance(r, a + b * std::cos(beta));
          const double value = -std::expm1(-t) * weight;
          double before = std::cos(beta), now = 1;
          const double twice = 2 * before;
          for (int m = 0; m < modes; ++m) {
            sums[m] += value * now;
            const double next = twice * now - before;
            before = now;
            now = next;
          }
        }
      }
      float* out = &opacity_modes[(static_cast<std::size_t>(cell) * fine_polars + f) * modes];
      for (int m = 0; m < modes; ++m) out[m] = static_cast<float>(sums[m] * (m == 0 ? 1 : 2) / kHalfTau);
    }
  });
}

void SphereSolution::State::build_phase_matrices() {
  const int modes = grid.modes;
  const double g = std::abs(problem.g);
  // The trapezoid in azimuth converges like exp(-n (1 - g) / sqrt(g)).
  const int azimuths = std::clamp(static_cast<int>(12 * std::sqrt(g) / (1 - g)) + 2 * modes, 32, 512);
  const QuadratureRule rule = gauss_legendre(12);
  const int fine_last = fine_polars - 1;
  phase_matrix.assign(static_cast<std::size_t>(grid.polars) * fine_polars * modes, 0.0f);
  beam_matrix = phase_matrix;
  std::vector<double> cosine(azimuths * modes);
  for (int k = 0; k < azimuths; ++k)
    for (int m = 0; m < modes; ++m) cosine[k * modes + m] = std::cos(m * kHalfTau * (k + 0.5) / azimuths);
  parallel_for(grid.polars, [&](int i) {
    const double alpha = polar.angle(i);
    std::vector<double> kernel(modes), row(fine_polars * modes, 0.0), beam_row(fine_polars * modes, 0.0);
    for (int interval = 0; interval < fine_last; ++interval) {
      for (std::size_t q = 0; q < rule.nodes.size(); ++q) {
        const double place = interval + rule.nodes[q];
        const double other = polar.angle(place / kRefine);
        const double weight = rule.weights[q] * polar.derivative(place / kRefine) / kRefine * std::sin(other);
        const double a = std::cos(alpha) * std::cos(other), b = std::sin(alpha) * std::sin(other);
        std::fill(kernel.begin(), kernel.end(), 0.0);
        for (int k = 0; k < azimuths; ++k) {
          // Average over the sub-interval is what the trapezoid means; cos of the scattering angle is at most 1.
          const double p = phase_per_sr(problem, std::min(1.0, a + b * cosine[k * modes + 1]), problem.g);
          for (int m = 0; m < modes; ++m) kernel[m] += p * cosine[k * modes + m];
        }
        const double beam = phase_per_sr(problem, std::cos(other), problem.g_first.value_or(problem.g));
        double w[4];
        cubic_weights(rule.nodes[q] + 1, w);
        for (int tap = 0; tap < 4; ++tap) {
          // Beyond a pole the direction is the one on the other side: odd modes change sign.
          const bool mirrored = interval - 1 + tap < 0 || interval - 1 + tap > fine_last;
          const int node = mirrored_node(interval - 1 + tap, fine_last);
          for (int m = 0; m < modes; ++m) {
            const double sign = mirrored && (m & 1) ? -1.0 : 1.0;
            const double value = sign * w[tap] * weight * kernel[m] * kTau / azimuths;
            row[node * modes + m] += value;
            beam_row[node * modes + m] += value * beam;
          }
        }
      }
    }
    double isotropic = 0;
    for (int f = 0; f < fine_polars; ++f) isotropic += row[f * modes];
    for (int k = 0; k < fine_polars * modes; ++k) {
      phase_matrix[static_cast<std::size_t>(i) * fine_polars * modes + k] = static_cast<float>(row[k] / isotropic);
      beam_matrix[static_cast<std::size_t>(i) * fine_polars * modes + k] = static_cast<float>(beam_row[k] / isotropic);
    }
  });
}

// One (radius, theta): multiplies Lambda on the fine polar nodes by the opacity and applies a phase matrix.
void SphereSolution::State::scatter_cell(int cell, const float* fine_lambda, const AlignedFloats& matrix,
                                         float* scattered) const {
  const int modes = grid.modes;
  alignas(64) std::array<float, 16 * 128> radiance;
  alignas(64) std::array<float, 16 * 48> result;
  multiply_opacity(modes, fine_polars, fine_lambda,
                   &opacity_modes[static_cast<std::size_t>(cell) * fine_polars * 2 * modes], radiance.data());
  multiply_phase(modes, grid.polars, fine_polars, matrix.data(), radiance.data(), result.data());
  const std::size_t cells = static_cast<std::size_t>(grid.radii) * grid.thetas;
  for (int a = 0; a < grid.polars; ++a) std::copy_n(&result[a * modes], modes, scattered + (a * cells + cell) * modes);
}

// J2: the once-scattered radiance at every cell is exact, p(alpha) S(r, theta, alpha, beta).
std::vector<float> SphereSolution::State::second_order_source() {
  const int modes = grid.modes, azimuths = grid.modes;
  const QuadratureRule rule = gauss_legendre(10);
  const double sigma = problem.sigma;
  std::vector<float> source(size());
  parallel_for(grid.radii * grid.thetas, [&](int cell) {
    const double r = radial.radius(cell / grid.thetas), th = theta(cell % grid.thetas);
    const double px = r * std::sin(th), pz = r * std::cos(th);
    const auto light_path = [](double x, double y, double z) {
      const double inside = std::max(0.0, 1 - x * x - y * y);
      return std::max(0.0, z + std::sqrt(inside));
    };
    std::vector<float> fine(fine_polars * modes, 0.0f);
    for (int f = 0; f < fine_polars; ++f) {
      const double alpha = polar.angle(static_cast<double>(f) / kRefine);
      for (int b = 0; b < azimuths; ++b) {
        const double beta = kHalfTau * (b + 0.5) / azimuths;
        const double ox = std::sin(alpha) * std::cos(beta), oy = std::sin(alpha) * std::sin(beta), oz = std::cos(alpha);
        const double reach = backward_distance(r, std::sin(th) * ox + std::cos(th) * oz);
        // Mean over the ray of exp(-sigma d) with weight exp(-sigma u), substituting the mean slope of u + d.
        const double near = light_path(px, 0, pz);
        const double far = light_path(px - reach * ox, -reach * oy, pz - reach * oz);
        const double slope = reach > 1e-9 ? std::clamp((reach + far - near) / reach, 0.01, 1.0) : 1.0;
        const double opacity = -std::expm1(-slope * sigma * reach);
        double sum = 0;
        for (std::size_t k = 0; k < rule.nodes.size(); ++k) {
          const double peeled = -std::log1p(-opacity * rule.nodes[k]);
          const double u = std::min(reach, peeled / (slope * sigma));
          sum += rule.weights[k] * std::exp(peeled - sigma * (u + light_path(px - u * ox, -u * oy, pz - u * oz)));
        }
        const double full = -std::expm1(-sigma * reach);
        const double mean = full > 1e-12 ? sum * opacity / (slope * full) : std::exp(-sigma * near);
        const int entry = cosines.exact(grid.modes, b);
        for (int m = 0; m < modes; ++m)
          fine[f * modes + m] += static_cast<float>(mean * (m == 0 ? 1 : 2) / azimuths) * cosines.samples[entry + m];
      }
    }
    scatter_cell(cell, fine.data(), beam_matrix, source.data());
  });
  return source;
}

// One polar slice of J with ghost rows: beyond a pole of position lies the meridian opposite.
void SphereSolution::State::fill_slice(const float* source, int a, float* slice) const {
  const int modes = grid.modes, row = grid.thetas + 2;
  for (int i = 0; i < grid.radii; ++i) {
    const float* from = source + (static_cast<std::size_t>(a) * grid.radii + i) * grid.thetas * modes;
    float* to = slice + static_cast<std::size_t>(i) * row * modes;
    std::copy_n(from, grid.thetas * modes, to + modes);
    for (int m = 0; m < modes; ++m) {
      const float sign = (m & 1) ? -1.0f : 1.0f;
      to[m] = sign * from[modes + m];
      to[(row - 1) * modes + m] = sign * from[(grid.thetas - 2) * modes + m];
    }
  }
}

void SphereSolution::State::apply(const float* source, float* scattered) {
  const int modes = grid.modes, azimuths = grid.modes, points = grid.ray_points;
  const int cells = grid.radii * grid.thetas;
  parallel_for(grid.polars, [&](int a) { fill_slice(source, a, &slices[a * slice_floats()]); });
  parallel_for(grid.polars * grid.radii, [&](int task) {
    const int a = task / grid.radii, i = task % grid.radii;
    float values[16];
    for (int j = 0; j < grid.thetas; ++j) {
      const int cell = i * grid.thetas + j;
      trace_rays(modes, azimuths, points, &slices[a * slice_floats()], (grid.thetas + 2) * modes,
                 cosines.entries.data(), &rays[(static_cast<std::size_t>(a) * cells + cell) * azimuths * points],
                 values);
      float* out = &lambda[(static_cast<std::size_t>(cell) * grid.polars + a) * modes];
      std::fill_n(out, modes, 0.0f);
      for (int b = 0; b < azimuths; ++b) {
        const float* cosine = &cosines.samples[cosines.exact(azimuths, b)];
        for (int m = 0; m < modes; ++m) out[m] += values[b] * cosine[m];
      }
      for (int m = 0; m < modes; ++m) out[m] *= (m == 0 ? 1.0f : 2.0f) / static_cast<float>(azimuths);
    }
  });
  static const auto kFineWeights = [] {
    std::array<std::array<float, 4>, kRefine> weights{};
    for (int k = 0; k < kRefine; ++k) {
      double w[4];
      cubic_weights(1 + static_cast<double>(k) / kRefine, w);
      for (int tap = 0; tap < 4; ++tap) weights[k][tap] = static_cast<float>(w[tap]);
    }
    return weights;
  }();
  parallel_for(grid.radii * grid.thetas, [&](int cell) {
    const float* coarse = &lambda[static_cast<std::size_t>(cell) * grid.polars * modes];
    alignas(64) std::array<float, 16 * 128> fine;
    const int last = grid.polars - 1;
    for (int f = 0; f < fine_polars; ++f) {
      const int base = f / kRefine, k = f % kRefine;
      float* out = &fine[f * modes];
      if (k == 0) {
        std::copy_n(coarse + base * modes, modes, out);
        continue;
      }
      std::fill_n(out, modes, 0.0f);
      for (int tap = 0; tap < 4; ++tap) {
        const bool mirrored = base - 1 + tap < 0 || base - 1 + tap > last;
        const int node = mirrored_node(base - 1 + tap, last);
        const float even = kFineWeights[k][tap], odd = mirrored ? -even : even;
        for (int m = 0; m < modes; m += 2) {
          out[m] += even * coarse[node * modes + m];
          out[m + 1] += odd * coarse[node * modes + m + 1];
        }
      }
    }
    scatter_cell(cell, fine.data(), phase_matrix, scattered);
  });
}

// Diffusion synthetic acceleration (Larsen 1984) as a preconditioner: what is left over spreads like diffusing light,
// the one thing that successive scattering takes thousands of steps for in a thick sphere.
void SphereSolution::State::add_diffusion(const float* rest, float* corrected) const {
  const int modes = grid.modes, cells = grid.radii * grid.thetas;
  std::vector<double> source(cells, 0.0);
  for (int a = 0; a < grid.polars; ++a)
    for (int cell = 0; cell < cells; ++cell)
      source[cell] += polar_weights[a] * rest[(static_cast<std::size_t>(a) * cells + cell) * modes];
  const std::vector<double> flux = diffusion.solve(source);
  std::copy_n(rest, size(), corrected);
  for (int a = 0; a < grid.polars; ++a)
    for (int cell = 0; cell < cells; ++cell)
      corrected[(static_cast<std::size_t>(a) * cells + cell) * modes] += static_cast<float>(flux[cell] / (2 * kTau));
}

// The solution: only the slices and axes are needed from here on.
void SphereSolution::State::keep(const float* source) {
  for (int a = 0; a < grid.polars; ++a) fill_slice(source, a, &slices[a * slice_floats()]);
  rays = {};
  opacity_modes = {};
  phase_matrix = {};
  beam_matrix = {};
  lambda = {};
}

SphereSolution::SphereSolution() = default;
SphereSolution::SphereSolution(SphereSolution&&) noexcept = default;
SphereSolution& SphereSolution::operator=(SphereSolution&&) noexcept = default;
SphereSolution::~SphereSolution() = default;

int SphereSolution::applications() const { return state_->applications; }
double SphereSolution::residual() const { return state_->residual; }

SphereGrid sphere_grid(double sigma, bool coarse) {
  if (coarse || sigma <= 5) return {14, 16, 16, 8, 6};
  if (sigma <= 12) return {20, 24, 20, 16, 8};
  return {28, 32, 20, 16, 8};
}

SphereSolution solve_sphere(const SphereProblem& problem, const SphereGrid& grid, double residual) {
  SphereSolution solution;
  solution.state_ = std::make_unique<SphereSolution::State>(problem, grid);
  SphereSolution::State& state = *solution.state_;
  state.build();
  const std::vector<float> second = state.second_order_source();
  // (1 - K) M y = second, J = M y, with M = 1 + diffusion.
  std::vector<float> corrected(state.size());
  GmresResult solved = gmres(
      [&](const float* in, float* out) {
        state.add_diffusion(in, corrected.data());
        state.apply(corrected.data(), out);
        for (std::size_t i = 0; i < corrected.size(); ++i) out[i] += in[i] - corrected[i];
      },
      second, residual, 100, 1000);
  state.add_diffusion(solved.x.data(), corrected.data());
  state.keep(corrected.data());
  state.applications = solved.applications;
  state.residual = solved.residual;
  return solution;
}

SphereSolution sum_orders(const SphereProblem& problem, const SphereGrid& grid, int last_order) {
  SphereSolution solution;
  solution.state_ = std::make_unique<SphereSolution::State>(problem, grid);
  SphereSolution::State& state = *solution.state_;
  state.build();
  std::vector<float> order = state.second_order_source(), next(order.size()), sum = order;
  for (int k = 3; k <= last_order; ++k) {
    state.apply(order.data(), next.data());
    std::swap(order, next);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += order[i];
  }
  state.keep(sum.data());
  state.applications = std::max(0, last_order - 2);
  return solution;
}

double SphereSolution::chord_source(double c, double h, double x) const {
  const State& s = *state_;
  const double st = std::sqrt(std::max(0.0, 1 - c * c)), sh = std::sqrt(std::max(0.0, 1 - h * h));
  const double y = std::sqrt(std::max(0.0, 1 - x * x));
  const double ox = h * st - sh * x * c, oy = sh * y, oz = h * c + sh * x * st;
  const double alpha_at = s.polar.index(std::acos(std::clamp(oz, -1.0, 1.0)));
  const double beta = std::atan2(oy, ox);
  const int base = std::clamp(static_cast<int>(std::floor(alpha_at)), 0, s.polar.last() - 1);
  double aw[4];
  cubic_weights(alpha_at - (base - 1), aw);
  double t[16], w[16];
  s.gather_rules.evaluate(2 * s.problem.sigma * h, t, w);
  double sum = 0;
  for (int k = 0; k < 16; ++k) {
    const double u = t[k] / s.problem.sigma;
    const RayPoint point = s.locate(st - u * ox, -u * oy, c - u * oz, beta);
    for (int tap = 0; tap < 4; ++tap) {
      const bool mirrored = base - 1 + tap < 0 || base - 1 + tap > s.polar.last();
      const int node = mirrored_node(base - 1 + tap, s.polar.last());
      // A direction beyond its pole is the opposite azimuth's.
      RayPoint turned = point;
      if (mirrored) turned.cosine_at = s.cosines.place(beta + kHalfTau - std::atan2(-u * oy, st - u * ox));
      float value;
      trace_rays(s.grid.modes, 1, 1, &s.slices[node * s.slice_floats()], (s.grid.thetas + 2) * s.grid.modes,
                 s.cosines.entries.data(), &turned, &value);
      sum += w[k] * aw[tap] * value;
    }
  }
  return sum;
}

}  // namespace nephele
