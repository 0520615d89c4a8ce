// The same atmosphere in double precision by brute force, sharing nothing with shaders/shared but its constants; and
// the product's tables filled on the CPU.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "shared/atmosphere_tables.h"

namespace nephele::test {

// The lasting tables for one ground albedo, computed once per program.
struct AtmosphereOnCpu {
  glm::vec3 ground_albedo;
  std::vector<glm::vec4> transmittance_texels, multi_scattering_texels, sky_irradiance_texels;
  shared::Table2D transmittance, multi_scattering, sky_irradiance;
};
const AtmosphereOnCpu& atmosphere_on_cpu();

// A texture of one black texel, to switch multiple scattering off.
shared::Table2D black_table();

namespace atmosphere_reference {

inline constexpr double kRadiusM = 6360000.0;
inline constexpr double kTopM = 100000.0;

struct Medium {
  glm::dvec3 rayleigh, aerosol, extinction;  // scattering, scattering, both absorptions included; 1/m
};
Medium medium(double altitude_m);

// Along a ray from altitude h with zenith cosine mu.
double altitude(double h, double mu, double t_m);
double distance_to_top(double h, double mu);     // from inside
double distance_to_ground(double h, double mu);  // negative when it misses
glm::dvec3 transmittance(double h, double mu, double length_m, int steps = 4000);

// Light scattered once into a ray of that length, the sun a point; azimuth between ray and sun.
glm::dvec3 single_scattering(double h, double mu, double azimuth_rad, double sun_mu, double length_m);

// Diffuse irradiance on the ground, all orders, by Monte Carlo in plane-parallel air: one channel.
double sky_irradiance_at_ground(int channel, double sun_mu, double ground_albedo, int photons);

}  // namespace atmosphere_reference
}  // namespace nephele::test
