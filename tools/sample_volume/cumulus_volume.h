// A cumulus by formula, for tests and figures of the importer: turrets on a flat base, worn by noise. The same numbers
// on every machine with IEEE doubles, up to what its square root and floor round alike.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace nephele::sample {

inline std::uint32_t mixed_bits(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

// In [-1, 1], smooth, one lattice point a unit.
inline double value_noise(double x, double y, double z, std::uint32_t seed) {
  const std::array<double, 3> at{x, y, z};
  std::array<int, 3> cell{};
  std::array<double, 3> t{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double whole = std::floor(at[i]), f = at[i] - whole;
    cell[i] = static_cast<int>(whole);
    t[i] = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
  }
  double sum = 0.0;
  for (int k = 0; k < 8; ++k) {
    std::uint32_t hash = seed;
    double weight = 1.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const int upper = k >> i & 1;
      hash = mixed_bits(hash + static_cast<std::uint32_t>(cell[i] + upper));
      weight *= upper == 1 ? t[i] : 1.0 - t[i];
    }
    sum += weight * (hash / 2147483647.5 - 1.0);
  }
  return sum;
}

inline double fractal_noise(double x, double y, double z, double first_m, int octaves, std::uint32_t seed) {
  double sum = 0.0, gain = 0.5;
  for (int i = 0; i < octaves; ++i, gain *= 0.5, first_m *= 0.5)
    sum += gain * value_noise(x / first_m, y / first_m, z / first_m, seed + static_cast<std::uint32_t>(i));
  return sum;
}

inline constexpr double kCumulusSideM = 2048.0;  // of the cube that holds it, from the origin on
inline constexpr double kCumulusBaseM = 320.0;   // of its flat base

// Extinction (1/m) at a point. Depths through the cloud's middle are about 20.
inline double cumulus_per_m(double x_m, double y_m, double z_m) {
  struct Ball {
    double x, y, z, r;
  };
  constexpr Ball kBalls[] = {{1024, 1024, 480, 430},  {760, 900, 520, 330},  {1300, 1120, 560, 340},
                             {1060, 1300, 600, 330},  {980, 1010, 900, 330}, {1130, 880, 760, 300},
                             {1180, 1060, 1180, 260}, {820, 1120, 860, 230}};
  double inside_m = -1e9;
  for (const Ball& ball : kBalls) {
    const double dx = x_m - ball.x, dy = y_m - ball.y, dz = z_m - ball.z;
    inside_m = std::max(inside_m, ball.r - std::sqrt(dx * dx + dy * dy + dz * dz));
  }
  if (inside_m < -150.0) return 0.0;
  inside_m += 260.0 * fractal_noise(x_m, y_m, z_m, 320.0, 5, 17u) - 30.0;
  const double above_m = z_m - kCumulusBaseM;
  const double body = std::clamp(inside_m / 50.0, 0.0, 1.0) * std::clamp(above_m / 16.0, 0.0, 1.0);
  return body * 0.022 * (0.55 + 0.45 * std::clamp(above_m / 500.0, 0.0, 1.0));
}

// The cube on n^3 voxels, value(x, y, z) called for each at its place; the matter is moved by shift_m.
template <class Take>
void for_cumulus_voxels(std::size_t n, const std::array<double, 3>& shift_m, Take&& take) {
  const double voxel_m = kCumulusSideM / static_cast<double>(n);
  for (std::size_t x = 0; x < n; ++x)
    for (std::size_t y = 0; y < n; ++y)
      for (std::size_t z = 0; z < n; ++z)
        take(x, y, z,
             static_cast<float>(cumulus_per_m((static_cast<double>(x) + 0.5) * voxel_m - shift_m[0],
                                              (static_cast<double>(y) + 0.5) * voxel_m - shift_m[1],
                                              (static_cast<double>(z) + 0.5) * voxel_m - shift_m[2])));
}

}  // namespace nephele::sample
