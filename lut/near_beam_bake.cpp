#include "lut/near_beam.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "shared/near_beam_axes.h"
#include "shared/phase.h"

namespace nephele {
namespace {

constexpr double kLeastTerm = 1e-10;
constexpr int kMostMoments = 4000;

double henyey_greenstein_times_mu(int l, double g) {
  return ((l + 1) * std::pow(g, l + 1) + (l > 0 ? l * std::pow(g, l - 1) : 0.0)) / (2 * l + 1);
}

// As phase_moment (shared/phase.h), in double precision.
double moment(std::uint32_t phase_function, int l, double g) {
  const double own = std::pow(g, l);
  if (phase_function != shared::kPhaseCornetteShanks) return own;
  const double below = l > 0 ? l * henyey_greenstein_times_mu(l - 1, g) : 0.0;
  const double squared = ((l + 1) * henyey_greenstein_times_mu(l + 1, g) + below) / (2 * l + 1);
  return 1.5 * (own + squared) / (2.0 + g * g);
}

std::vector<double> moments_of(std::uint32_t phase_function, double g) {
  std::vector<double> moments;
  for (int l = 0; l < kMostMoments; ++l) {
    moments.push_back(moment(phase_function, l, g));
    if (l > 2 && std::abs((2 * l + 1) * moments.back()) < kLeastTerm) break;
  }
  return moments;
}

double near_beam(const std::vector<double>& moments, double tau, double mu) {
  const double beam = std::exp(-tau);
  double sum = (std::exp(-(1.0 - moments[2]) * tau) - beam) * (1.0 + 3.0 * moments[1] * mu);
  double before = 1.0, here = mu;
  for (int l = 2; l < static_cast<int>(moments.size()); ++l) {
    const double legendre = ((2 * l - 1) * mu * here - (l - 1) * before) / l;
    const double chi = moments[static_cast<std::size_t>(l)];
    sum += (2 * l + 1) * chi * (std::exp(-(1.0 - chi) * tau) - beam) * legendre;
    before = here;
    here = legendre;
  }
  return sum / (4.0 * std::numbers::pi);
}

}  // namespace

double near_beam_per_sr(std::uint32_t phase_function, double g, double tau, double mu) {
  return near_beam(moments_of(phase_function, g), tau, mu);
}

NpyArray bake_near_beam_array(std::uint32_t phase_function, double g, std::uint32_t depths, std::uint32_t angles) {
  const std::vector<double> moments = moments_of(phase_function, g);
  NpyArray array;
  array.type = ElementType::float16;
  array.shape = {1, angles, depths, 1};
  array.data.resize(array.count() * 2);
  std::byte* out = array.data.data();
  for (std::uint32_t j = 0; j < angles; ++j)
    for (std::uint32_t i = 0; i < depths; ++i, out += 2) {
      const float tau = shared::near_beam_depth(static_cast<float>(i) / static_cast<float>(depths - 1));
      const float mu = shared::near_beam_cosine(static_cast<float>(j) / static_cast<float>(angles - 1));
      const auto value = static_cast<float>(near_beam(moments, static_cast<double>(tau), static_cast<double>(mu)));
      const std::uint32_t half = glm::packHalf2x16(glm::vec2(value, 0.0f));
      out[0] = static_cast<std::byte>(half & 255u);
      out[1] = static_cast<std::byte>(half >> 8u & 255u);
    }
  return array;
}

}  // namespace nephele
