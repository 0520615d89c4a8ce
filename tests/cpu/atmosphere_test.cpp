// The atmosphere's model, geometry and tables against closed forms and double-precision quadrature.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "tests/cpu/atmosphere_reference.h"

using namespace nephele::shared;
using nephele::test::atmosphere_on_cpu;
using nephele::test::AtmosphereOnCpu;
namespace ref = nephele::test::atmosphere_reference;

namespace {

// Gaussian with different slopes on both sides, the building block of the colour matching functions.
double lobe(double wavelength_nm, double peak_nm, double below, double above) {
  const double t = (wavelength_nm - peak_nm) * (wavelength_nm < peak_nm ? below : above);
  return std::exp(-0.5 * t * t);
}

// CIE 1931 observer (fit by Wyman, Sloan and Shirley 2013) in linear sRGB.
glm::dvec3 srgb_response(double nm) {
  const double x = 0.362 * lobe(nm, 442.0, 0.0624, 0.0374) + 1.056 * lobe(nm, 599.8, 0.0264, 0.0323) -
                   0.065 * lobe(nm, 501.1, 0.0490, 0.0382);
  const double y = 0.821 * lobe(nm, 568.8, 0.0213, 0.0247) + 0.286 * lobe(nm, 530.9, 0.0613, 0.0322);
  const double z = 1.217 * lobe(nm, 437.0, 0.0845, 0.0278) + 0.681 * lobe(nm, 459.0, 0.0385, 0.0725);
  return {3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z,
          0.0557 * x - 0.2040 * y + 1.0570 * z};
}

// Mean of a spectral quantity over sunlight (ASTM E490, W m^-2 nm^-1, every 20 nm from 400 nm) as the three channels
// see it.
glm::dvec3 seen_in_sunlight(const std::function<double(double)>& quantity) {
  constexpr std::array<double, 16> kSun = {1.72765, 1.6887, 1.91198, 2.02042, 1.93377, 1.91686, 1.8685, 1.85149,
                                           1.8341,  1.8147, 1.7533,  1.68194, 1.6048,  1.55622, 1.474,  1.41018};
  glm::dvec3 sum(0), white(0);
  for (std::size_t i = 0; i < kSun.size(); ++i) {
    const double nm = 400.0 + 20.0 * static_cast<double>(i);
    const glm::dvec3 weight = srgb_response(nm) * kSun[i];
    sum += weight * quantity(nm);
    white += weight;
  }
  return sum / white;
}

// Molecular scattering, 1/m at sea level (Bucholtz-like inverse fourth power).
double spectral_rayleigh(double nm) { return 1.24062e-6 * std::pow(nm * 1e-3, -4.0); }

double max_abs(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

}  // namespace

TEST_CASE("the three molecular coefficients stand for the whole solar spectrum") {
  const glm::dvec3 thin = seen_in_sunlight(spectral_rayleigh);
  const glm::dvec3 used = rayleigh_scattering_per_m();
  CHECK(max_abs(thin / used - 1.0) < 0.025);  // 20 nm sampling of sun and observer; 10 nm gives 0.005
  // Transmittance through m vertical air masses of molecules.
  for (const auto& [masses, tolerance] : {std::pair{1.0, 0.005}, {5.0, 0.01}, {38.0, 0.03}}) {
    const double depth_m = masses * double{kRayleighHeightM};
    const glm::dvec3 spectral = seen_in_sunlight([&](double nm) { return std::exp(-depth_m * spectral_rayleigh(nm)); });
    CAPTURE(masses);
    CHECK(max_abs(spectral - glm::exp(-depth_m * used)) < tolerance);
  }
}

TEST_CASE("the phase functions have unit power") {
  double rayleigh = 0, aerosol = 0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const float mu = static_cast<float>(-1.0 + (2.0 * i + 1.0) / kSteps);
    rayleigh += double{rayleigh_phase(mu)} * 4.0 * M_PI / kSteps;
    aerosol += double{aerosol_phase(mu)} * 4.0 * M_PI / kSteps;
  }
  CHECK(rayleigh == doctest::Approx(1.0).epsilon(1e-5));
  CHECK(aerosol == doctest::Approx(1.0).epsilon(1e-5));
}

TEST_CASE("rays keep millimetres of altitude near the ground and metres afar") {
  for (const double h : {0.0, 2.0, 1500.0, 11000.0, 40000.0, 400000.0}) {
    for (const double mu : {-1.0, -0.3, -0.01, 0.0, 1e-4, 0.2, 1.0}) {
      for (const double t : {1.0, 100.0, 5000.0, 200000.0}) {
        const double r = ref::kRadiusM + h;
        const double exact = std::sqrt(r * r + 2 * r * mu * t + t * t) - ref::kRadiusM;
        if (exact < 0) continue;
        const float got = ray_altitude(float(h), float(mu), float(t));
        CAPTURE(h);
        CAPTURE(mu);
        CAPTURE(t);
        // Rounding of mu, of the sum and of the root, all relative to the ray's rise and fall.
        CHECK(std::abs(got - exact) < 2e-7 * (h + t) + 1e-6);
      }
    }
  }
}

TEST_CASE("rays meet the ground where they should, down to the grazing one") {
  for (const double h : {0.5, 2.0, 300.0, 11000.0, 40000.0}) {
    const double r = ref::kRadiusM + h;
    const double horizon = -std::sqrt(1.0 - (ref::kRadiusM / r) * (ref::kRadiusM / r));
    CHECK(double{horizon_cosine(float(h))} == doctest::Approx(horizon).epsilon(1e-5));
    const double tangent_m = std::sqrt(r * r - ref::kRadiusM * ref::kRadiusM);
    CHECK(double{ground_distance(float(h), horizon_cosine(float(h)))} == doctest::Approx(tangent_m).epsilon(1e-3));
    for (const double below : {1e-3, 0.1, 0.5}) {
      const float mu = static_cast<float>(horizon - below);
      const double m = mu;
      const double exact = -r * m - std::sqrt(r * r * m * m - h * (2 * ref::kRadiusM + h));
      CHECK(double{ground_distance(float(h), mu)} == doctest::Approx(exact).epsilon(1e-4));
    }
  }
  CHECK(ground_distance(0.0f, 0.0f) == 0.0f);
  CHECK(ground_distance(0.0f, -1.0f) == 0.0f);
}

TEST_CASE("the march covers its segment in order, finest at the lowest point") {
  for (const float h : {0.0f, 2.0f, 11000.0f, 40000.0f, 99999.0f, 300000.0f}) {
    for (const float mu : {-1.0f, -0.2f, horizon_cosine(h), 0.0f, 0.01f, 1.0f}) {
      const bool ground = mu < horizon_cosine(h);
      const AirSegment segment = air_segment(h, mu, ground);
      const float t_low = -(kPlanetRadiusM + h) * mu;
      CAPTURE(h);
      CAPTURE(mu);
      CHECK(segment.near_m >= 0.0f);
      float previous = segment.near_m;
      CHECK(march_distance(segment, t_low, 0.0f) == doctest::Approx(segment.near_m));
      for (int i = 1; i <= 32; ++i) {
        const float t = march_distance(segment, t_low, float(i) / 32.0f);
        CHECK(t >= previous);
        previous = t;
      }
      CHECK(previous == doctest::Approx(segment.far_m));
    }
  }
}

TEST_CASE("every table axis and its inverse make a round trip") {
  for (std::uint32_t y = 0; y < kTransmittanceHeight; ++y) {
    for (std::uint32_t x = 0; x < kTransmittanceWidth; ++x) {
      const vec2 unit(unit_from_index(x, kTransmittanceWidth), unit_from_index(y, kTransmittanceHeight));
      float h, mu;
      transmittance_from_unit(unit, h, mu);
      const vec2 back = transmittance_unit(h, mu);
      if (y + 1 < kTransmittanceHeight && y > 0)  // at the top the way is anything; at the ground, see below
        REQUIRE(std::abs(back.x - unit.x) < 2e-3f);
      REQUIRE(std::abs(back.y - unit.y) < 1e-4f);
    }
  }
  for (int i = 0; i <= 100; ++i) {
    const float x = static_cast<float>(i) / 100.0f;
    CHECK(unit_from_sun_cosine(sun_cosine_from_unit(x)) == doctest::Approx(x).epsilon(1e-5));
    CHECK(unit_from_altitude(altitude_from_unit(x, 4e4f), 4e4f) == doctest::Approx(x).epsilon(1e-5));
    CHECK(unit_from_azimuth_cosine(azimuth_cosine_from_unit(x)) == doctest::Approx(x).epsilon(1e-3));
    CHECK(unit_from_distance(distance_from_unit(x, 10.0f, 3e5f), 10.0f, 3e5f) == doctest::Approx(x).epsilon(1e-3));
    for (const float h : {0.0f, 2.0f, 1500.0f, 40000.0f, 1e6f}) {
      const float horizon = horizon_cosine(h);
      for (const bool below : {false, true})
        CHECK(std::abs(unit_from_elevation(elevation_from_unit(x, horizon, below), horizon, below) - x) < 2e-3f);
      CHECK(std::abs(aerial_unit_from_elevation(aerial_elevation_from_unit(x, horizon), horizon) - x) < 2e-3f);
    }
  }
}

TEST_CASE("transmittance to the top against quadrature") {
  const AtmosphereOnCpu& air = atmosphere_on_cpu();
  double worst = 0;
  for (const double h : {0.0, 2.0, 500.0, 1500.0, 6000.0, 20000.0, 40000.0, 80000.0}) {
    const double horizon = double{horizon_cosine(float(h))};
    for (const double above : {0.0, 1e-4, 1e-3, 0.005, 0.02, 0.1, 0.3, 0.7, 1.0}) {
      const double mu = horizon + above * (1.0 - horizon);
      const glm::dvec3 exact = ref::transmittance(h, mu, ref::distance_to_top(h, mu));
      const glm::dvec3 got = transmittance_to_top(air.transmittance, float(h), float(mu));
      worst = std::max(worst, max_abs(got - exact));
      CAPTURE(h);
      CAPTURE(mu);
      CHECK(max_abs(got - exact) < 0.006);  // linear filtering of 256 x 64 texels
    }
  }
  MESSAGE("largest error of the transmittance table " << worst);
}

TEST_CASE("sunlight grows with its height and with altitude, and the planet hides it") {
  const AtmosphereOnCpu& air = atmosphere_on_cpu();
  for (float h : {0.0f, 2.0f, 1500.0f, 11000.0f, 40000.0f, 99000.0f, 200000.0f}) {
    vec3 previous(0.0f);
    for (float mu = -1.0f; mu <= 1.0f; mu += 1.0f / 256.0f) {
      const vec3 t = sun_transmittance(air.transmittance, h, mu);
      for (int c = 0; c < 3; ++c) {
        REQUIRE(t[c] >= previous[c] - 1e-4f);
        REQUIRE(t[c] <= 1.0f);
      }
      if (mu < horizon_cosine(h) - 0.01f) REQUIRE(t == vec3(0.0f));
      previous = t;
    }
  }
  CHECK(sun_transmittance(air.transmittance, 200000.0f, 0.5f) == vec3(1.0f));
  const vec3 low = sun_transmittance(air.transmittance, 0.0f, 0.05f);
  CHECK(low.x > 2.0f * low.y * 0.7f);  // a low sun is red
  CHECK(low.y > 2.0f * low.z);
}

TEST_CASE("the sun's disc keeps its power and fades over the horizon") {
  double sum = 0;
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    const double x = (i + 0.5) / kSteps;
    sum += double{limb_darkening(float(x)).y} * 2.0 * x / kSteps;
  }
  CHECK(sum == doctest::Approx(1.0).epsilon(1e-3));
  CHECK(sun_visibility(0.0f, 0.0f) == doctest::Approx(0.5));
  CHECK(sun_visibility(0.0f, 0.005f) == 1.0f);
  CHECK(sun_visibility(0.0f, -0.005f) == 0.0f);
}
