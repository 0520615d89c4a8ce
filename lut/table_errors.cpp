#include "lut/table_errors.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/parallel.h"
#include "lut/near_beam.h"
#include "lut/oracles.h"
#include "shared/hash.h"
#include "shared/near_beam_axes.h"
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

TransmittanceError transmittance_error(const FloatTexture& optical_depth, int chords, const MeanDensity& truth) {
  return transmittance_error(
      [&](const vec3& entry, const vec3& exit) { return double{fetch_optical_depth(optical_depth, entry, exit).x}; },
      chords, truth);
}

TransmittanceError transmittance_error(const MeanDensity& fetched_of, int chords, const MeanDensity& truth_of) {
  constexpr float kPeakOpticalRadius = 8;
  std::vector<double> errors(chords), magnitudes(chords), squares(chords), density_squares(chords);
  parallel_for(chords, [&](int i) {
    std::uint32_t state = shared::hash_uint(static_cast<std::uint32_t>(i));
    const vec3 along = random_direction(state), side = normalize(cross(along, random_direction(state)));
    const float impact = std::sqrt(shared::uniform_float(state, 0, 1)), half = std::sqrt(1 - impact * impact);
    const vec3 entry = impact * side - half * along, exit = impact * side + half * along;
    const double scale = -2.0 * half * kPeakOpticalRadius;
    const double fetched = fetched_of(entry, exit);
    const double truth = truth_of(entry, exit);
    errors[i] = std::exp(scale * fetched) - std::exp(scale * truth);
    magnitudes[i] = std::abs(errors[i]);
    squares[i] = errors[i] * errors[i];
    density_squares[i] = (fetched - truth) * (fetched - truth);
  });
  std::nth_element(magnitudes.begin(), magnitudes.begin() + chords * 99 / 100, magnitudes.end());
  return {std::sqrt(mean_of(squares)), mean_of(errors), magnitudes[chords * 99 / 100],
          std::sqrt(mean_of(density_squares))};
}

double energy_error(const FloatTexture& multiple_scattering, std::uint32_t phase_function, double g, double sigma) {
  const float peak = static_cast<float>(g), density = static_cast<float>(sigma);
  const double scattered = exit_power(256, [&](const SphereRay& ray) {
    const float c = static_cast<float>(ray.c), h = static_cast<float>(ray.h), mu = static_cast<float>(ray.mu);
    return double{shared::phase_per_sr(phase_function, mu, peak) * shared::single_scattering(c, h, mu, density) +
                  fetch_multiple(multiple_scattering, c, h, mu, density, peak)};
  });
  return direct_power(sigma) + scattered - 1;
}

double near_beam_error(const FloatTexture& near_beam, std::uint32_t phase_function, double g) {
  constexpr int kPlaces = 61;  // along each axis; no divisor of the table's steps
  double errors = 0, squares = 0;
  for (int j = 0; j < kPlaces; ++j)
    for (int i = 0; i < kPlaces; ++i) {
      const float tau = shared::near_beam_depth((static_cast<float>(i) + 0.5f) / kPlaces);
      const float mu = shared::near_beam_cosine((static_cast<float>(j) + 0.5f) / kPlaces);
      const double exact = near_beam_per_sr(phase_function, g, static_cast<double>(tau), static_cast<double>(mu));
      const double error = static_cast<double>(fetch_near_beam(near_beam, tau, mu)) - exact;
      errors += error * error;
      squares += exact * exact;
    }
  return std::sqrt(errors / squares);
}

}  // namespace nephele
