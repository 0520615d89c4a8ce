#include "tools/clouds/repeatable.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shared/hash.h"

namespace nephele::clouds {

std::uint32_t RandomSequence::bits() { return shared::hash_uvec2({count_++, stream_}, seed_); }

double RandomSequence::unit() { return static_cast<double>(bits()) * 0x1p-32; }

double RandomSequence::normal() {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += unit();
  return sum;
}

// The inverse of the distribution function of a density in proportion to size^-3 between the two.
double RandomSequence::size(double smallest, double largest) {
  const double ratio = smallest / largest;
  return smallest / std::sqrt(1.0 - unit() * (1.0 - ratio * ratio));
}

// Equal bands of a sphere's height have equal areas; the horizontal part is a point of a disc, put on its rim.
glm::dvec3 RandomSequence::direction(double lowest_up, double highest_up) {
  const double up = between(lowest_up, highest_up);
  glm::dvec2 flat(1.0, 0.0);
  for (int attempt = 0; attempt < 32; ++attempt) {
    const glm::dvec2 point(between(-1.0, 1.0), between(-1.0, 1.0));
    const double square = glm::dot(point, point);
    if (square > 1.0 || square < 1e-4) continue;
    flat = point / std::sqrt(square);
    break;
  }
  return {flat * std::sqrt(std::max(0.0, 1.0 - up * up)), up};
}

std::uint32_t RandomSequence::index(std::uint32_t count) {
  return static_cast<std::uint32_t>((static_cast<std::uint64_t>(bits()) * count) >> 32);
}

// (1 - x/n)^n with n = 8192, by squaring, is e^-x (1 - x^2 / 2n + ...).
double falling_exponential(double x) {
  if (x >= 100.0) return 0.0;
  double power = 1.0 - x / 8192.0;
  for (int i = 0; i < 13; ++i) power *= power;
  return power;
}

// Taylor's series of a 64th of the angle, then the angle doubled six times.
SineCosine sine_cosine(double angle_rad) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double x = (angle_rad - kTurn * std::floor(angle_rad / kTurn + 0.5)) / 64.0, square = x * x;
  SineCosine result{x * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0))),
                    1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0))};
  for (int i = 0; i < 6; ++i)
    result = {2.0 * result.sine * result.cosine, result.cosine * result.cosine - result.sine * result.sine};
  return result;
}

}  // namespace nephele::clouds
