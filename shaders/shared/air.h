// The clear atmosphere: what the air is made of, rays through it, and the axes of its tables.
// Based on: Hillaire, A Scalable and Production Ready Sky and Atmosphere Rendering Technique, 2020 (multiple
// scattering and per-frame tables); Bruneton, Precomputed Atmospheric Scattering: a New Implementation, 2017
// (transmittance axes, aerosol phase applied at look-up).
//
// Everything is written with the altitude h above the sphere instead of the radius R + h: in float the radius has
// half a metre of resolution, the altitude a fraction of a millimetre. Angles are cosines (mu = cosine of the zenith
// angle). The tables hold light per unit of the sun's irradiance at the top of the atmosphere, channel by channel.
#ifndef NEPHELE_SHARED_AIR_H
#define NEPHELE_SHARED_AIR_H

#include "phase.h"

NEPHELE_SHARED_BEGIN

NEPHELE_CONST(float, kAtmosphereTopM, 100000.0f);

// Molecules: molecular scattering and ozone absorption integrated over the solar spectrum and the CIE 1931 observer,
// taken to linear sRGB relative to unscattered sunlight (so the sun at the top of the atmosphere is white). In this
// thin limit both scattering and attenuation have the same three coefficients; they stay within 0.01 of the spectral
// transmittance up to 5 air masses and 0.03 up to 38 (atmosphere_test). The three wavelengths often used instead
// (680, 550, 440 nm) are the coordinates of no sRGB primary and make the zenith violet.
NEPHELE_FN vec3 rayleigh_scattering_per_m() { return vec3(7.18e-6f, 13.80e-6f, 32.30e-6f); }
NEPHELE_CONST(float, kRayleighHeightM, 8000.0f);

// 300 Dobson units in a tent of half-width 15 km around 25 km, absorption at its peak.
NEPHELE_FN vec3 ozone_absorption_per_m() { return vec3(2.49e-6f, 1.79e-6f, 0.0f); }
NEPHELE_CONST(float, kOzoneCenterM, 25000.0f);
NEPHELE_CONST(float, kOzoneHalfWidthM, 15000.0f);

// Aerosol of fair weather over land: optical depth 0.084 at 550 nm (sea-level visibility about 45 km), Angstrom
// exponent 0.8, single-scattering albedo 0.94, in a boundary layer of scale height 1.2 km.
NEPHELE_FN vec3 aerosol_extinction_per_m() { return vec3(6.2e-5f, 7.0e-5f, 8.3e-5f); }
NEPHELE_CONST(float, kAerosolAlbedo, 0.94f);
NEPHELE_CONST(float, kAerosolHeightM, 1200.0f);
NEPHELE_CONST(float, kAerosolG, 0.76f);

// The sun's disc as the tables see it: softens its setting behind the planet.
NEPHELE_CONST(float, kSunRadiusRad, 0.004653f);

NEPHELE_FN float rayleigh_phase(float mu) { return 3.0f / (16.0f * kPi) * (1.0f + mu * mu); }
NEPHELE_FN float aerosol_phase(float mu) { return phase_cornette_shanks(mu, kAerosolG); }

// Densities relative to the ground (ozone: to its peak).
struct AirDensity {
  float rayleigh;
  float aerosol;
};

NEPHELE_FN AirDensity air_density(float altitude_m) {
  AirDensity density;
  density.rayleigh = exp(-altitude_m / kRayleighHeightM);
  density.aerosol = exp(-altitude_m / kAerosolHeightM);
  return density;
}

NEPHELE_FN float ozone_density(float altitude_m) {
  return max(0.0f, 1.0f - abs(altitude_m - kOzoneCenterM) / kOzoneHalfWidthM);
}

// Means over a stretch of ray.
struct AirMedium {
  vec3 rayleigh_scattering_per_m;
  vec3 aerosol_scattering_per_m;
  vec3 extinction_per_m;
};

// Mean of exp(-h/H) between two altitudes of a ray that climbs evenly; exact, and the limit where they coincide.
NEPHELE_FN float mean_density(float d0, float d1, float rise_m, float height_m) {
  return abs(rise_m) < 0.02f * height_m ? 0.5f * (d0 + d1) : height_m * (d0 - d1) / rise_m;
}

NEPHELE_FN AirMedium air_medium(float h0_m, AirDensity d0, float h1_m, AirDensity d1, float middle_m) {
  float rayleigh = mean_density(d0.rayleigh, d1.rayleigh, h1_m - h0_m, kRayleighHeightM);
  float aerosol = mean_density(d0.aerosol, d1.aerosol, h1_m - h0_m, kAerosolHeightM);
  AirMedium medium;
  medium.rayleigh_scattering_per_m = rayleigh_scattering_per_m() * rayleigh;
  medium.aerosol_scattering_per_m = aerosol_extinction_per_m() * (aerosol * kAerosolAlbedo);
  medium.extinction_per_m = medium.rayleigh_scattering_per_m + aerosol_extinction_per_m() * aerosol +
                            ozone_absorption_per_m() * ozone_density(middle_m);
  return medium;
}

// --- Rays. h is the altitude of the origin, mu the cosine of the zenith angle there, t the distance. ---

NEPHELE_FN float ray_altitude(float h_m, float mu, float t_m) {
  float r = kPlanetRadiusM + h_m;
  float growth = t_m * (2.0f * r * mu + t_m);  // r'^2 - r^2
  return h_m + growth / (r + sqrt(max(0.0f, r * r + growth)));
}

// Cosine of the angle between the local vertical at distance t and a direction whose cosine with the vertical at the
// origin is direction_mu and with the ray nu.
NEPHELE_FN float cosine_along_ray(float h_m, float mu, float t_m, float direction_mu, float nu) {
  float r = kPlanetRadiusM + h_m;
  float r_there = sqrt(max(1.0f, r * r + t_m * (2.0f * r * mu + t_m)));
  return clamp((r * direction_mu + t_m * nu) / r_there, -1.0f, 1.0f);
}

// Cosine of the zenith angle of the geometric horizon; h >= 0.
NEPHELE_FN float horizon_cosine(float h_m) {
  return -sqrt(h_m * (2.0f * kPlanetRadiusM + h_m)) / (kPlanetRadiusM + h_m);
}

// Distance to the ground for a ray at or below the horizon. Written so that it neither cancels nor divides by zero.
NEPHELE_FN float ground_distance(float h_m, float mu) {
  float r = kPlanetRadiusM + h_m;
  float power = h_m * (2.0f * kPlanetRadiusM + h_m);  // of the origin with respect to the sphere
  float discriminant = r * r * mu * mu - power;
  return power / max(1e-3f, -r * mu + sqrt(max(0.0f, discriminant)));
}

// The part of a ray inside the atmosphere and above the ground; far <= near where there is none.
struct AirSegment {
  float near_m;
  float far_m;
};

NEPHELE_FN AirSegment air_segment(float h_m, float mu, bool ends_at_ground) {
  float r = kPlanetRadiusM + h_m;
  float depth = (kAtmosphereTopM - h_m) * (2.0f * kPlanetRadiusM + h_m + kAtmosphereTopM);  // top^2 - r^2
  float discriminant = r * r * mu * mu + depth;
  AirSegment segment;
  segment.near_m = 0.0f;
  segment.far_m = 0.0f;
  if (discriminant <= 0.0f || (depth < 0.0f && mu >= 0.0f)) return segment;
  float root = sqrt(discriminant);
  segment.far_m = mu > 0.0f ? depth / (r * mu + root) : root - r * mu;
  if (depth < 0.0f) segment.near_m = -depth / (root - r * mu);
  if (ends_at_ground) segment.far_m = ground_distance(h_m, mu);
  return segment;
}

// A march of `steps` equal steps of x in [0, 1] is finest where the ray is lowest, at t_low: quadratic on both
// sides, with twice the share of steps on the near side, which hides what is behind it.
NEPHELE_FN float march_distance(AirSegment segment, float t_low_m, float x) {
  float low = clamp(t_low_m, segment.near_m, segment.far_m);
  float before = low - segment.near_m;
  float after = segment.far_m - low;
  float x_low = 2.0f * sqrt(before) / max(1e-3f, 2.0f * sqrt(before) + sqrt(after));
  if (x < x_low) {
    float y = (x_low - x) / x_low;
    return low - before * y * y;
  }
  float y = x_low < 1.0f ? (x - x_low) / (1.0f - x_low) : 0.0f;
  return low + after * y * y;
}

// (1 - exp(-x)) / x, the mean of exp over an optical depth x >= 0.
NEPHELE_FN float mean_attenuation(float x, float exp_minus_x) {
  return x < 1e-2f ? 1.0f - x * (0.5f - x * (1.0f / 6.0f)) : (1.0f - exp_minus_x) / x;
}

NEPHELE_FN vec3 mean_attenuation(vec3 x, vec3 exp_minus_x) {
  return vec3(mean_attenuation(x.x, exp_minus_x.x), mean_attenuation(x.y, exp_minus_x.y),
              mean_attenuation(x.z, exp_minus_x.z));
}

// --- Table axes: each map stands beside its inverse. A unit coordinate covers a row of n texels from the first
// centre to the last, so that the ends are stored exactly and filtering stays inside the row. ---

NEPHELE_FN float texel_from_unit(float x, float n) { return (0.5f + clamp(x, 0.0f, 1.0f) * (n - 1.0f)) / n; }
NEPHELE_FN float unit_from_index(uint i, uint n) { return float(i) / float(n - 1u); }

// Transmittance to the top [Bruneton17]: x = how far the way to the top lies between its extremes, y = sqrt-like in
// altitude.
NEPHELE_CONST(uint, kTransmittanceWidth, 256u);
NEPHELE_CONST(uint, kTransmittanceHeight, 64u);

NEPHELE_FN vec2 transmittance_unit(float h_m, float mu) {
  float r = kPlanetRadiusM + h_m;
  float horizon_at_top = sqrt(kAtmosphereTopM * (2.0f * kPlanetRadiusM + kAtmosphereTopM));
  float rho = sqrt(h_m * (2.0f * kPlanetRadiusM + h_m));
  float depth = (kAtmosphereTopM - h_m) * (2.0f * kPlanetRadiusM + h_m + kAtmosphereTopM);
  float root = sqrt(max(0.0f, r * r * mu * mu + depth));
  float d = mu > 0.0f ? depth / (r * mu + root) : root - r * mu;
  float d_min = kAtmosphereTopM - h_m;
  float d_max = rho + horizon_at_top;
  return vec2((d - d_min) / max(1.0f, d_max - d_min), rho / horizon_at_top);
}

NEPHELE_FN void transmittance_from_unit(vec2 unit, NEPHELE_OUT(float) h_m, NEPHELE_OUT(float) mu) {
  float horizon_at_top = sqrt(kAtmosphereTopM * (2.0f * kPlanetRadiusM + kAtmosphereTopM));
  float rho = unit.y * horizon_at_top;
  h_m = min(kAtmosphereTopM, rho * rho / (kPlanetRadiusM + sqrt(kPlanetRadiusM * kPlanetRadiusM + rho * rho)));
  float d_min = kAtmosphereTopM - h_m;
  float d_max = rho + horizon_at_top;
  float d = d_min + unit.x * (d_max - d_min);
  float depth = d_min * (2.0f * kPlanetRadiusM + h_m + kAtmosphereTopM);
  mu = d < 1.0f ? 1.0f : clamp((depth - d * d) / (2.0f * (kPlanetRadiusM + h_m) * d), -1.0f, 1.0f);
}

// Multiple scattering and sky irradiance: cosine of the sun's zenith angle, finest about the horizon, by altitude,
// finest at the ground.
NEPHELE_CONST(uint, kMultiScatteringWidth, 65u);  // odd: one column is the horizon itself
NEPHELE_CONST(uint, kMultiScatteringHeight, 32u);
NEPHELE_CONST(uint, kSkyIrradianceWidth, 65u);
NEPHELE_CONST(uint, kSkyIrradianceHeight, 24u);  // rows of one block
NEPHELE_CONST(uint, kSkyIrradianceBlocks, 4u);   // irradiance from above, from below; mean radiance above, below
NEPHELE_CONST(float, kSkyIrradianceTopM, 40000.0f);

NEPHELE_FN float unit_from_sun_cosine(float mu) { return 0.5f + (mu < 0.0f ? -0.5f : 0.5f) * sqrt(min(1.0f, abs(mu))); }
NEPHELE_FN float sun_cosine_from_unit(float x) {
  float y = 2.0f * x - 1.0f;
  return y * abs(y);
}
NEPHELE_FN float unit_from_altitude(float h_m, float top_m) { return sqrt(clamp(h_m / top_m, 0.0f, 1.0f)); }
NEPHELE_FN float altitude_from_unit(float x, float top_m) { return x * x * top_m; }

// Sky view: azimuth from the sun (the sky is its mirror image) by elevation, finest at the horizon. Rows below the
// horizon end at the ground and rows above in space: two blocks, never filtered across, so the horizon is sharp.
NEPHELE_CONST(uint, kSkyViewWidth, 48u);
NEPHELE_CONST(uint, kSkyViewRowsAbove, 96u);
NEPHELE_CONST(uint, kSkyViewRowsBelow, 64u);
NEPHELE_CONST(uint, kSkyViewHeight, 160u);

// sin(azimuth / 2) from the cosine of the azimuth: even about both ends, as the sky is, and free of acos.
NEPHELE_FN float unit_from_azimuth_cosine(float c) { return sqrt(clamp(0.5f - 0.5f * c, 0.0f, 1.0f)); }
NEPHELE_FN float azimuth_cosine_from_unit(float x) { return 1.0f - 2.0f * x * x; }

// 0 at the horizon, 1 at the zenith (above) or the nadir (below).
NEPHELE_FN float unit_from_elevation(float mu, float horizon_mu, bool below) {
  float x = below ? (horizon_mu - mu) / (1.0f + horizon_mu) : (mu - horizon_mu) / (1.0f - horizon_mu);
  return sqrt(clamp(x, 0.0f, 1.0f));
}
NEPHELE_FN float elevation_from_unit(float x, float horizon_mu, bool below) {
  return horizon_mu + x * x * (below ? -1.0f - horizon_mu : 1.0f - horizon_mu);
}

NEPHELE_FN float sky_view_row(float unit_elevation, bool below) {
  float above = float(kSkyViewRowsAbove);
  float x = clamp(unit_elevation, 0.0f, 1.0f);
  float row = below ? above + x * (float(kSkyViewRowsBelow) - 1.0f) : x * (above - 1.0f);
  return (row + 0.5f) / float(kSkyViewHeight);
}

// Aerial perspective: the same azimuth, elevation through the horizon in one block (its rays pass through the ground,
// where the air of altitude 0 continues, so that filtering near the horizon never meets a shortened ray), and distance.
NEPHELE_CONST(uint, kAerialAzimuths, 33u);
NEPHELE_CONST(uint, kAerialElevations, 65u);  // odd: the middle row is the horizon itself
NEPHELE_CONST(uint, kAerialDistances, 48u);

NEPHELE_FN float aerial_unit_from_elevation(float mu, float horizon_mu) {
  bool below = mu < horizon_mu;
  return 0.5f + (below ? -0.5f : 0.5f) * unit_from_elevation(mu, horizon_mu, below);
}
NEPHELE_FN float aerial_elevation_from_unit(float x, float horizon_mu) {
  float y = 2.0f * x - 1.0f;
  return elevation_from_unit(abs(y), horizon_mu, y < 0.0f);
}

// The farthest slice: at least 256 km, and past the horizon from any altitude.
NEPHELE_FN float aerial_reach_m(float h_m) { return max(256000.0f, 1.25f * sqrt(h_m * (2.0f * kPlanetRadiusM + h_m))); }
NEPHELE_FN float unit_from_distance(float t_m, float near_m, float reach_m) {
  return sqrt(clamp((t_m - near_m) / reach_m, 0.0f, 1.0f));
}
NEPHELE_FN float distance_from_unit(float x, float near_m, float reach_m) { return near_m + x * x * reach_m; }

// --- The sun's disc ---

// Share of the sun's disc above the horizon; softened over its diameter.
NEPHELE_FN float sun_visibility(float h_m, float sun_mu) {
  float horizon_mu = horizon_cosine(h_m);
  float edge = kSunRadiusRad * sqrt(max(0.0f, 1.0f - horizon_mu * horizon_mu));
  return smoothstep(-edge, edge, sun_mu - horizon_mu);
}

// Radiance of the disc relative to its mean, at the distance x = sin(angle from its centre) / sin(radius) < 1.
// Limb darkening I = mu^alpha (Hestroffer and Magnan 1998), alpha interpolated to the channels; mean 2 / (2 + alpha).
NEPHELE_FN vec3 limb_darkening(float x) {
  float mu = sqrt(max(0.0f, 1.0f - x * x));
  vec3 alpha = vec3(0.42f, 0.50f, 0.65f);
  return pow(vec3(mu), alpha) * (1.0f + 0.5f * alpha);
}

NEPHELE_SHARED_END

#endif
