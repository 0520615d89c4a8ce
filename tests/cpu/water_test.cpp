// Water's surface sends on what Fresnel's law says, where the mirror of its waves stands.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "shared/water.h"

using namespace nephele::shared;

namespace {

dvec3 upward(double elevation_deg, double azimuth_rad) {
  const double e = elevation_deg * M_PI / 180;
  return {std::cos(e) * std::cos(azimuth_rad), std::cos(e) * std::sin(azimuth_rad), std::sin(e)};
}

float glint(const dvec3& view, const dvec3& sun) {
  return water_glint(float(view.z), float(sun.z), float(dot(view, sun)));
}

double fresnel(double cos_incidence) {  // of water, n = 1.33, unpolarised: not Schlick's form
  const double n = 1.33, t = std::sqrt(1 - (1 - cos_incidence * cos_incidence) / (n * n));
  const double s = (cos_incidence - n * t) / (cos_incidence + n * t);
  const double p = (t - n * cos_incidence) / (t + n * cos_incidence);
  return 0.5 * (s * s + p * p);
}

}  // namespace

TEST_CASE("the glint over all directions is what the facets reflect") {
  for (const double sun_deg : {90.0, 60.0, 30.0, 12.0}) {
    const dvec3 sun = upward(sun_deg, 0);
    double sum = 0;
    constexpr int kRows = 1500, kColumns = 1500;
    for (int i = 0; i < kRows; ++i) {
      const double z = (i + 0.5) / kRows;
      for (int j = 0; j < kColumns; ++j) {
        const double azimuth = 2 * M_PI * (j + 0.5) / kColumns, across = std::sqrt(1 - z * z);
        sum += glint({across * std::cos(azimuth), across * std::sin(azimuth), z}, sun) * z;
      }
    }
    const double reflected = sum * 2 * M_PI / (double(kRows) * kColumns);
    // Oracle: facets of Gaussian slopes, each as often as it faces the sun, reflect by Fresnel.
    double seen = 0, mirrored = 0;
    constexpr int kSlopes = 400;
    for (int i = 0; i < kSlopes; ++i)
      for (int j = 0; j < kSlopes; ++j) {
        const double x = 10 * ((i + 0.5) / kSlopes - 0.5) * kWaterSlope,
                     y = 10 * ((j + 0.5) / kSlopes - 0.5) * kWaterSlope;
        const double facing = (sun.z - x * sun.x - y * sun.y) / std::sqrt(1 + x * x + y * y);
        const double weight =
            std::exp(-(x * x + y * y) / kWaterSlopeVariance) * std::max(0.0, sun.z - x * sun.x - y * sun.y);
        seen += weight;
        mirrored += weight * (facing > 0 ? fresnel(facing) : 0);
      }
    CAPTURE(sun_deg);
    CAPTURE(reflected);
    CAPTURE(mirrored / seen);
    // Schlick's form errs by a tenth between 60 and 80 degrees; low suns lose what is sent down to other waves.
    CHECK(reflected < 1.12 * mirrored / seen);
    CHECK(reflected > (sun_deg < 20 ? 0.6 : 0.85) * mirrored / seen);
    CHECK(mean_water_fresnel(float(sun.z)) < 1.15 * mirrored / seen + 0.003);
    CHECK(mean_water_fresnel(float(sun.z)) > 0.75 * mirrored / seen);
  }
}

TEST_CASE("the glint stands in the mirror's direction and is the same both ways") {
  const dvec3 sun = upward(40, 0);
  const float mirror = glint(upward(40, M_PI), sun);
  CHECK(mirror > 50.0f * glint(upward(40, 0), sun));
  CHECK(mirror > 50.0f * glint(upward(40, M_PI / 2), sun));
  CHECK(mirror > 20.0f * glint(upward(89, 0), sun));
  for (const double deg : {5.0, 20.0, 70.0})
    CHECK(std::abs(glint(upward(deg, 2.9), sun) - glint(sun, upward(deg, 2.9))) < 1e-4f * mirror);
  CHECK(glint(upward(30, M_PI), upward(-1, 0)) == 0.0f);
  CHECK(std::isfinite(glint(upward(0.01, M_PI), upward(0.01, 0))));
}

TEST_CASE("the mirrored sky has the sky's irradiance") {
  double sum = 0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double up = (i + 0.5) / kSteps;
    sum += (1 - std::exp(-0.32 / up)) / 0.418 * 2 * up / kSteps;
  }
  CHECK(std::abs(sum - 1.0) < 0.002);  // 0.418 has three digits
  // From straight above: two hundredths of the sky at the zenith, and what comes from below the surface.
  const vec3 seen = water_reflection(1.0f, -0.1f, 0.0f, vec3(0.0f), vec3(1.0f));
  const double zenith = (1 - std::exp(-0.32)) / (0.418 * M_PI);
  CHECK(std::abs(seen.y - (0.02 * zenith + 0.98 * water_albedo().y / M_PI)) < 0.0005);
}
