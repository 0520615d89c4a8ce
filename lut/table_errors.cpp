#include "lut/table_errors.h"

#include <cmath>
#include <vector>

#include "lut/parallel.h"
#include "lut/quadrature.h"
#include "shared/hash.h"
#include "shared/reference_particle.h"
#include "shared/table_axes.h"

namespace nephele {

using shared::vec3;

namespace {

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

vec3 random_direction(std::uint32_t& state) {
  const float z = shared::uniform_float(state, -1, 1), phi = shared::uniform_float(state, -shared::kPi, shared::kPi);
  const float s = std::sqrt(std::max(0.0f, 1 - z * z));
  return {s * std::cos(phi), s * std::sin(phi), z};
}

}  // namespace

double transmittance_error(const FloatTexture& optical_depth, std::uint32_t particle_seed) {
  constexpr int kChords = 2048;
  constexpr float kPeakOpticalRadius = 8;
  std::vector<double> squares(kChords);
  parallel_for(kChords, [&](int i) {
    std::uint32_t state = shared::hash_uint(static_cast<std::uint32_t>(i));
    const vec3 along = random_direction(state), side = normalize(cross(along, random_direction(state)));
    const float impact = std::sqrt(shared::uniform_float(state, 0, 1)), half = std::sqrt(1 - impact * impact);
    const vec3 entry = impact * side - half * along, exit = impact * side + half * along;
    const int steps = 8 + static_cast<int>(2 * half * 100);
    double sum = 0;
    for (int k = 0; k < steps; ++k)
      sum += shared::reference_particle_density(
          entry + (exit - entry) * ((static_cast<float>(k) + 0.5f) / static_cast<float>(steps)), particle_seed);
    const double scale = -2.0 * half * kPeakOpticalRadius;
    const double error =
        std::exp(scale * fetch_optical_depth(optical_depth, entry, exit).x) - std::exp(scale * sum / steps);
    squares[i] = error * error;
  });
  return std::sqrt(mean_of(squares));
}

double energy_error(const FloatTexture& multiple_scattering, std::uint32_t phase_function, double g, double sigma) {
  // 2 times the integral of radiance dc h dh dphi over all exit rays.
  constexpr int kCosines = 24, kChords = 20, kAzimuths = 256;
  const QuadratureRule cosines = gauss_legendre(kCosines), chords = gauss_legendre(kChords);
  const float peak = static_cast<float>(g), density = static_cast<float>(sigma);
  std::vector<double> rows(2 * kCosines);
  parallel_for(2 * kCosines, [&](int i) {
    const double y = cosines.nodes[i % kCosines];  // c = -+ y^2: dense at the terminator
    const float c = static_cast<float>(i < kCosines ? -y * y : y * y);
    for (int j = 0; j < kChords; ++j) {
      const float h = static_cast<float>(chords.nodes[j]);
      double around = 0;
      for (int k = 0; k < kAzimuths; ++k) {
        const float x = std::cos(shared::kPi * (static_cast<float>(k) + 0.5f) / kAzimuths);
        const float mu = c * h + std::sqrt((1 - c * c) * (1 - h * h)) * x;
        around += shared::phase_per_sr(phase_function, mu, peak) * shared::single_scattering(c, h, mu, density) +
                  fetch_multiple(multiple_scattering, c, h, mu, density, peak);
      }
      rows[i] += cosines.weights[i % kCosines] * 2 * y * chords.weights[j] * h * around * 2 * shared::kPi / kAzimuths;
    }
  });
  const double scattered = 2 * mean_of(rows) * static_cast<double>(rows.size());
  const double direct = (1 - std::exp(-2 * sigma) * (1 + 2 * sigma)) / (2 * sigma * sigma);
  return direct + scattered - 1;
}

}  // namespace nephele
