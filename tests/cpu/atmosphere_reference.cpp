#include "tests/cpu/atmosphere_reference.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace nephele::test {

using namespace shared;

const AtmosphereOnCpu& atmosphere_on_cpu() {
  static const AtmosphereOnCpu air = [] {
    AtmosphereOnCpu a;
    a.ground_albedo = {0.12f, 0.14f, 0.10f};
    const auto fill = [](std::vector<vec4>& texels, std::uint32_t width, std::uint32_t height, auto&& texel) {
      texels.reserve(std::size_t{width} * height);
      for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) texels.emplace_back(texel(uvec2(x, y)), 1.0f);
      return Table2D{int(width), int(height), 1, texels.data()};
    };
    a.transmittance = fill(a.transmittance_texels, kTransmittanceWidth, kTransmittanceHeight, transmittance_texel);
    a.multi_scattering = fill(a.multi_scattering_texels, kMultiScatteringWidth, kMultiScatteringHeight,
                              [&](uvec2 at) { return multi_scattering_texel(a.transmittance, at, a.ground_albedo); });
    a.sky_irradiance =
        fill(a.sky_irradiance_texels, kSkyIrradianceWidth, kSkyIrradianceBlocks * kSkyIrradianceHeight,
             [&](uvec2 at) { return sky_irradiance_texel(a.transmittance, a.multi_scattering, at, a.ground_albedo); });
    return a;
  }();
  return air;
}

Table2D black_table() {
  static const vec4 black(0.0f);
  return {1, 1, 1, &black};
}

namespace atmosphere_reference {

Medium medium(double altitude_m) {
  const double h = std::max(0.0, altitude_m);
  const double molecules = std::exp(-h / double{kRayleighHeightM}), aerosol = std::exp(-h / double{kAerosolHeightM});
  const double ozone = std::max(0.0, 1.0 - std::abs(h - double{kOzoneCenterM}) / double{kOzoneHalfWidthM});
  Medium m;
  m.rayleigh = glm::dvec3(rayleigh_scattering_per_m()) * molecules;
  m.aerosol = glm::dvec3(aerosol_extinction_per_m()) * aerosol * double{kAerosolAlbedo};
  m.extinction =
      m.rayleigh + glm::dvec3(aerosol_extinction_per_m()) * aerosol + glm::dvec3(ozone_absorption_per_m()) * ozone;
  return m;
}

double altitude(double h, double mu, double t_m) {
  const double r = kRadiusM + h;
  return std::sqrt(r * r + 2 * r * mu * t_m + t_m * t_m) - kRadiusM;
}

double distance_to_top(double h, double mu) {
  const double r = kRadiusM + h, top = kRadiusM + kTopM;
  return -r * mu + std::sqrt(std::max(0.0, r * r * (mu * mu - 1) + top * top));
}

double distance_to_ground(double h, double mu) {
  const double r = kRadiusM + h, d = r * r * (mu * mu - 1) + kRadiusM * kRadiusM;
  return mu >= 0 || d < 0 ? -1.0 : -r * mu - std::sqrt(d);
}

glm::dvec3 transmittance(double h, double mu, double length_m, int steps) {
  glm::dvec3 depth(0);
  for (int i = 0; i <= steps; ++i)  // Simpson
    depth += medium(altitude(h, mu, length_m * i / steps)).extinction * (i == 0 || i == steps ? 1.0
                                                                         : i % 2              ? 4.0
                                                                                              : 2.0);
  return glm::exp(-depth * (length_m / steps / 3.0));
}

glm::dvec3 single_scattering(double h, double mu, double azimuth_rad, double sun_mu, double length_m) {
  const double nu = mu * sun_mu + std::sqrt((1 - mu * mu) * (1 - sun_mu * sun_mu)) * std::cos(azimuth_rad);
  const double rayleigh = 3.0 / (16.0 * M_PI) * (1 + nu * nu);
  const double g = double{kAerosolG};
  const double aerosol =
      3.0 / (8.0 * M_PI) * (1 - g * g) * (1 + nu * nu) / ((2 + g * g) * std::pow(1 + g * g - 2 * g * nu, 1.5));
  constexpr int kSteps = 1500;
  const double dt = length_m / kSteps, r = kRadiusM + h;
  glm::dvec3 light(0), depth(0);
  for (int i = 0; i < kSteps; ++i) {
    const double t = (i + 0.5) * dt, at = altitude(h, mu, t);
    const Medium m = medium(at);
    depth += 0.5 * dt * m.extinction;
    const double sun_there = (r * sun_mu + t * nu) / (kRadiusM + at);
    if (distance_to_ground(at, sun_there) < 0) {
      const glm::dvec3 sun = transmittance(at, sun_there, distance_to_top(at, sun_there), 300);
      light += dt * glm::exp(-depth) * sun * (m.rayleigh * rayleigh + m.aerosol * aerosol);
    }
    depth += 0.5 * dt * m.extinction;
  }
  return light;
}

double sky_irradiance_at_ground(int channel, double sun_mu, double ground_albedo, int photons) {
  // Optical depth above each of a fine ladder of altitudes, to walk in optical depth.
  constexpr int kLevels = 20000;
  const double dh = kTopM / kLevels;
  std::vector<double> above(kLevels + 1, 0.0);
  for (int i = kLevels - 1; i >= 0; --i) above[i] = above[i + 1] + dh * medium((i + 0.5) * dh).extinction[channel];
  const auto altitude_at = [&](double depth) {  // above[] falls with the altitude
    const auto at = std::lower_bound(above.begin(), above.end(), depth, std::greater<>());
    return dh * static_cast<double>(at - above.begin());
  };
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto turned = [&](const glm::dvec3& d, double cosine) {
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine)), phi = 2 * M_PI * uniform(random);
    const glm::dvec3 a = std::abs(d.z) < 0.9 ? glm::normalize(glm::cross(d, glm::dvec3(0, 0, 1)))
                                             : glm::normalize(glm::cross(d, glm::dvec3(1, 0, 0)));
    return glm::normalize(d * cosine + sine * (std::cos(phi) * a + std::sin(phi) * glm::cross(d, a)));
  };
  const auto sampled_cosine = [&](auto&& phase, double peak) {  // by rejection
    for (;;) {
      const double cosine = 2 * uniform(random) - 1;
      if (uniform(random) * peak < phase(cosine)) return cosine;
    }
  };
  const double g = double{kAerosolG};
  const auto rayleigh = [](double c) { return 1 + c * c; };
  const auto aerosol = [g](double c) { return (1 + c * c) / std::pow(1 + g * g - 2 * g * c, 1.5); };

  double arrived = 0;
  for (int photon = 0; photon < photons; ++photon) {
    glm::dvec3 direction(std::sqrt(1 - sun_mu * sun_mu), 0, -sun_mu);
    double depth = 0, weight = 1;  // depth below the top
    bool scattered = false;
    while (weight > 1e-3) {
      depth += std::log(1 - uniform(random)) * direction.z;  // downwards is negative z
      if (depth < 0) break;
      if (depth > above[0]) {
        if (scattered) arrived += weight;
        weight *= ground_albedo;
        const double up = std::sqrt(uniform(random)), phi = 2 * M_PI * uniform(random), across = std::sqrt(1 - up * up);
        direction = {across * std::cos(phi), across * std::sin(phi), up};
        depth = above[0];
        scattered = true;
        continue;
      }
      const Medium m = medium(altitude_at(depth));
      const double of_molecules = m.rayleigh[channel], of_aerosol = m.aerosol[channel];
      weight *= (of_molecules + of_aerosol) / m.extinction[channel];
      const bool molecule = uniform(random) * (of_molecules + of_aerosol) < of_molecules;
      direction = turned(
          direction, molecule ? sampled_cosine(rayleigh, 2.0) : sampled_cosine(aerosol, 2.0 / std::pow(1 - g, 3.0)));
      scattered = true;
    }
  }
  return arrived / photons * sun_mu;
}

}  // namespace atmosphere_reference
}  // namespace nephele::test
