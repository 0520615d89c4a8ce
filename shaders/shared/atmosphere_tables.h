// What each texel of the atmosphere's tables holds, and look-ups into them. Tables reach these functions as
// Table2D / Table3D: samplers (linear, clamped) in GLSL, arrays of texels in C++.
// Based on: Hillaire 2020 and Bruneton 2017, see air.h.
#ifndef NEPHELE_SHARED_ATMOSPHERE_TABLES_H
#define NEPHELE_SHARED_ATMOSPHERE_TABLES_H

#include "air.h"

#ifdef __cplusplus
#include <algorithm>
#endif

NEPHELE_SHARED_BEGIN

#ifdef __cplusplus
struct Table3D {
  int width = 0, height = 0, depth = 1;
  const vec4* texels = nullptr;  // x fastest
};
using Table2D = Table3D;

// Linear filtering, clamped to the edge, in unit coordinates as a sampler has them.
inline vec4 sample_table(const Table3D& table, vec3 uvw) {
  const vec3 p = uvw * vec3(table.width, table.height, table.depth) - 0.5f;
  const vec3 cell = floor(p);
  const vec3 f = p - cell;
  const auto at = [&](int dx, int dy, int dz) {
    const int x = std::clamp(int(cell.x) + dx, 0, table.width - 1);
    const int y = std::clamp(int(cell.y) + dy, 0, table.height - 1);
    const int z = std::clamp(int(cell.z) + dz, 0, table.depth - 1);
    return table.texels[(std::size_t(z) * table.height + y) * table.width + x];
  };
  const auto plane = [&](int dz) {
    return mix(mix(at(0, 0, dz), at(1, 0, dz), f.x), mix(at(0, 1, dz), at(1, 1, dz), f.x), f.y);
  };
  return table.depth == 1 ? plane(0) : mix(plane(0), plane(1), f.z);
}
inline vec4 sample_table(const Table3D& table, vec2 uv) { return sample_table(table, vec3(uv, 0.5f)); }
#else
#define Table2D sampler2D
#define Table3D sampler3D
vec4 sample_table(sampler2D table, vec2 uv) { return textureLod(table, uv, 0.0); }
vec4 sample_table(sampler3D table, vec3 uvw) { return textureLod(table, uvw, 0.0); }
#endif

NEPHELE_FN vec3 table_rgb(vec4 texel) { return vec3(texel.x, texel.y, texel.z); }

// --- Transmittance to the top of the atmosphere ---

NEPHELE_CONST(uint, kTransmittanceSteps, 64u);

NEPHELE_FN vec3 transmittance_texel(uvec2 texel) {
  float h;
  float mu;
  transmittance_from_unit(
      vec2(unit_from_index(texel.x, kTransmittanceWidth), unit_from_index(texel.y, kTransmittanceHeight)), h, mu);
  AirSegment segment = air_segment(h, mu, false);
  float t_low = -(kPlanetRadiusM + h) * mu;
  vec3 depth = vec3(0.0f);
  float t0 = segment.near_m;
  float h0 = h;
  AirDensity d0 = air_density(h0);
  for (uint i = 1u; i <= kTransmittanceSteps; ++i) {
    float t1 = march_distance(segment, t_low, float(i) / float(kTransmittanceSteps));
    float h1 = max(0.0f, ray_altitude(h, mu, t1));
    AirDensity d1 = air_density(h1);
    AirMedium medium = air_medium(h0, d0, h1, d1, ray_altitude(h, mu, 0.5f * (t0 + t1)));
    depth += medium.extinction_per_m * (t1 - t0);
    t0 = t1;
    h0 = h1;
    d0 = d1;
  }
  return exp(-depth);
}

// To the top along a ray that does not meet the ground; a ray that does is treated as if it grazed the ground.
NEPHELE_FN vec3 transmittance_to_top(Table2D transmittance, float h_m, float mu) {
  vec2 unit = transmittance_unit(h_m, mu);
  return table_rgb(sample_table(transmittance, vec2(texel_from_unit(unit.x, float(kTransmittanceWidth)),
                                                    texel_from_unit(unit.y, float(kTransmittanceHeight)))));
}

// Share of the sun's irradiance that arrives at an altitude >= 0: through the air and past the planet.
NEPHELE_FN vec3 sun_transmittance(Table2D transmittance, float altitude_m, float sun_cos_zenith) {
  float h = max(0.0f, altitude_m);
  float mu = sun_cos_zenith;
  float visibility = sun_visibility(h, mu);
  if (h > kAtmosphereTopM) {  // from space: the air is entered on the way, if at all
    AirSegment segment = air_segment(h, mu, false);
    if (segment.far_m <= segment.near_m) return vec3(visibility);
    mu = cosine_along_ray(h, mu, segment.near_m, mu, 1.0f);
    h = kAtmosphereTopM;
  }
  return transmittance_to_top(transmittance, h, max(mu, horizon_cosine(h))) * visibility;
}

// --- The march along a view ray ---

struct ViewRay {
  float altitude_m;
  float cos_zenith;
  float sun_cos_zenith;  // at the origin
  float sun_cos_view;    // between the ray and the sun
};

// Light scattered towards the origin so far. The aerosol's single scattering is kept apart, its sharp phase function
// left to the look-up: the aureole then needs no resolution.
struct ViewMarch {
  float distance_m;
  float altitude_m;
  AirDensity density;
  vec3 transmittance;
  vec3 smooth_light;   // molecules' single scattering with its phase, and all multiple scattering
  vec3 aerosol_light;  // before aerosol_phase
};

NEPHELE_FN ViewMarch begin_march(ViewRay ray, float distance_m) {
  ViewMarch march;
  march.distance_m = distance_m;
  march.altitude_m = max(0.0f, ray_altitude(ray.altitude_m, ray.cos_zenith, distance_m));
  march.density = air_density(march.altitude_m);
  march.transmittance = vec3(1.0f);
  march.smooth_light = vec3(0.0f);
  march.aerosol_light = vec3(0.0f);
  return march;
}

NEPHELE_FN vec3 multi_scattering_at(Table2D multi_scattering, float h_m, float sun_mu) {
  float x = texel_from_unit(unit_from_sun_cosine(sun_mu), float(kMultiScatteringWidth));
  float y = texel_from_unit(unit_from_altitude(h_m, kAtmosphereTopM), float(kMultiScatteringHeight));
  return table_rgb(sample_table(multi_scattering, vec2(x, y)));
}

// One step to distance_m: extinction and source constant over it, the attenuation inside it integrated exactly.
NEPHELE_FN void march_to(Table2D transmittance, Table2D multi_scattering, ViewRay ray, float distance_m,
                         NEPHELE_INOUT(ViewMarch) march) {
  float length_m = distance_m - march.distance_m;
  float middle_m = march.distance_m + 0.5f * length_m;
  float h1 = max(0.0f, ray_altitude(ray.altitude_m, ray.cos_zenith, distance_m));
  float h_middle = clamp(ray_altitude(ray.altitude_m, ray.cos_zenith, middle_m), 0.0f, kAtmosphereTopM);
  AirDensity d1 = air_density(h1);
  AirMedium medium = air_medium(march.altitude_m, march.density, h1, d1, h_middle);
  float sun_mu = cosine_along_ray(ray.altitude_m, ray.cos_zenith, middle_m, ray.sun_cos_zenith, ray.sun_cos_view);
  vec3 sun = sun_transmittance(transmittance, h_middle, sun_mu);
  vec3 multiple = multi_scattering_at(multi_scattering, h_middle, sun_mu);
  vec3 depth = medium.extinction_per_m * length_m;
  vec3 step_transmittance = exp(-depth);
  vec3 weight = march.transmittance * mean_attenuation(depth, step_transmittance) * length_m;
  march.smooth_light += weight * (medium.rayleigh_scattering_per_m * sun * rayleigh_phase(ray.sun_cos_view) +
                                  (medium.rayleigh_scattering_per_m + medium.aerosol_scattering_per_m) * multiple);
  march.aerosol_light += weight * medium.aerosol_scattering_per_m * sun;
  march.transmittance = march.transmittance * step_transmittance;
  march.distance_m = distance_m;
  march.altitude_m = h1;
  march.density = d1;
}

NEPHELE_FN ViewMarch march_segment(Table2D transmittance, Table2D multi_scattering, ViewRay ray, AirSegment segment,
                                   uint steps) {
  ViewMarch march = begin_march(ray, segment.near_m);
  if (segment.far_m <= segment.near_m) return march;
  float t_low = -(kPlanetRadiusM + ray.altitude_m) * ray.cos_zenith;
  for (uint i = 1u; i <= steps; ++i)
    march_to(transmittance, multi_scattering, ray, march_distance(segment, t_low, float(i) / float(steps)), march);
  return march;
}

// --- Multiple scattering [Hillaire20 Eq. 5-10] ---

NEPHELE_CONST(uint, kMultiScatteringPolar, 8u);
NEPHELE_CONST(uint, kMultiScatteringAzimuths, 8u);
NEPHELE_CONST(uint, kMultiScatteringSteps, 20u);

// Mean over the sphere of the radiance scattered twice or more, as if all scattering but the first and last were
// isotropic and every place saw the same light: second order divided by one minus the share that scatters again.
NEPHELE_FN vec3 multi_scattering_texel(Table2D transmittance, uvec2 texel, vec3 ground_albedo) {
  float sun_mu = sun_cosine_from_unit(unit_from_index(texel.x, kMultiScatteringWidth));
  float h = altitude_from_unit(unit_from_index(texel.y, kMultiScatteringHeight), kAtmosphereTopM);
  float sun_sine = sqrt(max(0.0f, 1.0f - sun_mu * sun_mu));
  float horizon_mu = horizon_cosine(h);
  vec3 second = vec3(0.0f);
  vec3 again = vec3(0.0f);
  for (uint i = 0u; i < kMultiScatteringPolar; ++i) {
    float mu = 1.0f - (2.0f * float(i) + 1.0f) / float(kMultiScatteringPolar);
    float sine = sqrt(1.0f - mu * mu);
    bool ground = mu < horizon_mu;
    AirSegment segment = air_segment(h, mu, ground);
    float t_low = -(kPlanetRadiusM + h) * mu;
    for (uint j = 0u; j < kMultiScatteringAzimuths; ++j) {
      float nu = mu * sun_mu + sine * sun_sine * cos(kPi * (float(j) + 0.5f) / float(kMultiScatteringAzimuths));
      vec3 through = vec3(1.0f);
      float t0 = segment.near_m;
      float h0 = h;
      AirDensity d0 = air_density(h0);
      for (uint k = 1u; k <= kMultiScatteringSteps; ++k) {
        float t1 = march_distance(segment, t_low, float(k) / float(kMultiScatteringSteps));
        float middle = 0.5f * (t0 + t1);
        float h1 = max(0.0f, ray_altitude(h, mu, t1));
        float h_middle = clamp(ray_altitude(h, mu, middle), 0.0f, kAtmosphereTopM);
        AirDensity d1 = air_density(h1);
        AirMedium medium = air_medium(h0, d0, h1, d1, h_middle);
        vec3 depth = medium.extinction_per_m * (t1 - t0);
        vec3 step_transmittance = exp(-depth);
        vec3 scattered = through * mean_attenuation(depth, step_transmittance) * (t1 - t0) *
                         (medium.rayleigh_scattering_per_m + medium.aerosol_scattering_per_m);
        again += scattered;
        second += scattered * sun_transmittance(transmittance, h_middle, cosine_along_ray(h, mu, middle, sun_mu, nu)) *
                  (0.25f / kPi);
        through = through * step_transmittance;
        t0 = t1;
        h0 = h1;
        d0 = d1;
      }
      if (ground) {
        float ground_mu = cosine_along_ray(h, mu, segment.far_m, sun_mu, nu);
        second +=
            through * sun_transmittance(transmittance, 0.0f, ground_mu) * ground_albedo * (max(0.0f, ground_mu) / kPi);
      }
    }
  }
  float directions = float(kMultiScatteringPolar * kMultiScatteringAzimuths);
  return second / directions / (1.0f - again / directions);
}

// --- Sky irradiance: what a horizontal surface receives from the air and the ground, without the sun itself; and the
// mean radiance of the same half of the directions, which counts the bright, pale horizon in full ---

NEPHELE_CONST(uint, kIrradiancePolar, 8u);
NEPHELE_CONST(uint, kIrradianceAzimuths, 8u);
NEPHELE_CONST(uint, kIrradianceSteps, 12u);

// mean: the mean radiance, else the irradiance.
NEPHELE_FN vec3 hemisphere_light(Table2D transmittance, Table2D multi_scattering, float h, float sun_mu, bool below,
                                 bool mean, vec3 ground_albedo, vec3 ground_sky_irradiance) {
  float sun_sine = sqrt(max(0.0f, 1.0f - sun_mu * sun_mu));
  float horizon_mu = horizon_cosine(h);
  vec3 sum = vec3(0.0f);
  for (uint i = 0u; i < kIrradiancePolar; ++i) {
    float x = (float(i) + 0.5f) / float(kIrradiancePolar);
    float mu = mean ? x * x : sqrt(x);  // densest at the horizon; equal shares of cosine-weighted solid angle
    float weight = mean ? 2.0f * x : kPi;
    float sine = sqrt(1.0f - mu * mu);
    mu = below ? -mu : mu;
    bool ground = mu < horizon_mu;
    AirSegment segment = air_segment(h, mu, ground);
    for (uint j = 0u; j < kIrradianceAzimuths; ++j) {
      ViewRay ray;
      ray.altitude_m = h;
      ray.cos_zenith = mu;
      ray.sun_cos_zenith = sun_mu;
      ray.sun_cos_view = mu * sun_mu + sine * sun_sine * cos(kPi * (float(j) + 0.5f) / float(kIrradianceAzimuths));
      ViewMarch march = march_segment(transmittance, multi_scattering, ray, segment, kIrradianceSteps);
      sum += weight * (march.smooth_light + march.aerosol_light * aerosol_phase(ray.sun_cos_view));
      if (ground) {
        float ground_mu = cosine_along_ray(h, mu, segment.far_m, sun_mu, ray.sun_cos_view);
        vec3 irradiance =
            sun_transmittance(transmittance, 0.0f, ground_mu) * max(0.0f, ground_mu) + ground_sky_irradiance;
        sum += weight * march.transmittance * irradiance * ground_albedo * (1.0f / kPi);
      }
    }
  }
  return sum / float(kIrradiancePolar * kIrradianceAzimuths);
}

// Blocks of rows: irradiance from above, from below, mean radiance above, below.
NEPHELE_FN vec3 sky_irradiance_texel(Table2D transmittance, Table2D multi_scattering, uvec2 texel, vec3 ground_albedo) {
  uint block = texel.y / kSkyIrradianceHeight;
  bool below = (block & 1u) != 0u;
  uint row = texel.y - block * kSkyIrradianceHeight;
  float sun_mu = sun_cosine_from_unit(unit_from_index(texel.x, kSkyIrradianceWidth));
  float h = altitude_from_unit(unit_from_index(row, kSkyIrradianceHeight), kSkyIrradianceTopM);
  vec3 on_ground = vec3(0.0f);
  if (below)
    on_ground = hemisphere_light(transmittance, multi_scattering, 0.0f, sun_mu, false, false, ground_albedo, on_ground);
  return hemisphere_light(transmittance, multi_scattering, h, sun_mu, below, block >= 2u, ground_albedo, on_ground);
}

NEPHELE_FN vec3 sky_irradiance_lookup(Table2D sky_irradiance, float altitude_m, float sun_cos_zenith, uint block) {
  float rows = float(kSkyIrradianceHeight);
  float row = unit_from_altitude(altitude_m, kSkyIrradianceTopM) * (rows - 1.0f) + float(block) * rows;
  float x = texel_from_unit(unit_from_sun_cosine(sun_cos_zenith), float(kSkyIrradianceWidth));
  return table_rgb(sample_table(sky_irradiance, vec2(x, (row + 0.5f) / (float(kSkyIrradianceBlocks) * rows))));
}

// Irradiance of a horizontal surface facing up / facing down at an altitude, per unit of the sun's.
NEPHELE_FN vec3 sky_irradiance_from_above(Table2D sky_irradiance, float altitude_m, float sun_cos_zenith) {
  return sky_irradiance_lookup(sky_irradiance, altitude_m, sun_cos_zenith, 0u);
}
NEPHELE_FN vec3 sky_irradiance_from_below(Table2D sky_irradiance, float altitude_m, float sun_cos_zenith) {
  return sky_irradiance_lookup(sky_irradiance, altitude_m, sun_cos_zenith, 1u);
}

// Mean radiance of all directions above / below the horizontal, per unit of the sun's irradiance.
NEPHELE_FN vec3 mean_radiance_above(Table2D sky_irradiance, float altitude_m, float sun_cos_zenith) {
  return sky_irradiance_lookup(sky_irradiance, altitude_m, sun_cos_zenith, 2u);
}
NEPHELE_FN vec3 mean_radiance_below(Table2D sky_irradiance, float altitude_m, float sun_cos_zenith) {
  return sky_irradiance_lookup(sky_irradiance, altitude_m, sun_cos_zenith, 3u);
}

// --- Sky view: the whole ray, to space or to the ground, from the camera's altitude ---

NEPHELE_CONST(uint, kSkyViewSteps, 40u);

// x = unit azimuth, y = unit elevation, both as the axes define them.
NEPHELE_FN ViewRay view_ray_from_unit(float azimuth_unit, float mu, float h, float sun_mu) {
  ViewRay ray;
  ray.altitude_m = h;
  ray.cos_zenith = mu;
  ray.sun_cos_zenith = sun_mu;
  ray.sun_cos_view = mu * sun_mu + sqrt(max(0.0f, 1.0f - mu * mu)) * sqrt(max(0.0f, 1.0f - sun_mu * sun_mu)) *
                                       azimuth_cosine_from_unit(azimuth_unit);
  return ray;
}

NEPHELE_FN ViewMarch sky_view_texel(Table2D transmittance, Table2D multi_scattering, uvec2 texel, float h,
                                    float sun_mu) {
  bool below = texel.y >= kSkyViewRowsAbove;
  float unit = below ? unit_from_index(texel.y - kSkyViewRowsAbove, kSkyViewRowsBelow)
                     : unit_from_index(texel.y, kSkyViewRowsAbove);
  float mu = elevation_from_unit(unit, horizon_cosine(h), below);
  ViewRay ray = view_ray_from_unit(unit_from_index(texel.x, kSkyViewWidth), mu, h, sun_mu);
  return march_segment(transmittance, multi_scattering, ray, air_segment(h, mu, below), kSkyViewSteps);
}

// Cosine of the azimuth between a direction and the sun; any value where one of them is vertical (the sky has no
// azimuth there).
NEPHELE_FN float azimuth_cosine(vec3 direction, vec3 sun_direction) {
  float across = direction.x * sun_direction.x + direction.y * sun_direction.y;
  float lengths = (direction.x * direction.x + direction.y * direction.y) *
                  (sun_direction.x * sun_direction.x + sun_direction.y * sun_direction.y);
  return lengths > 1e-20f ? clamp(across / sqrt(lengths), -1.0f, 1.0f) : 1.0f;
}

// Light scattered into a whole ray, without sun and ground themselves. `below`: the ray ends at the ground.
NEPHELE_FN vec3 sky_view_lookup(Table2D sky_smooth, Table2D sky_aerosol, vec3 direction, vec3 sun_direction,
                                float horizon_mu, bool below) {
  float x = texel_from_unit(unit_from_azimuth_cosine(azimuth_cosine(direction, sun_direction)), float(kSkyViewWidth));
  vec2 uv = vec2(x, sky_view_row(unit_from_elevation(direction.z, horizon_mu, below), below));
  return table_rgb(sample_table(sky_smooth, uv)) +
         table_rgb(sample_table(sky_aerosol, uv)) * aerosol_phase(dot(direction, sun_direction));
}

// Transmittance of the whole ray (a table of one column).
NEPHELE_FN vec3 view_transmittance_lookup(Table2D view_transmittance, float mu, float horizon_mu, bool below) {
  return table_rgb(
      sample_table(view_transmittance, vec2(0.5f, sky_view_row(unit_from_elevation(mu, horizon_mu, below), below))));
}

// --- Aerial perspective: the air between the camera and a distance ---

struct AerialSample {
  vec3 light;
  vec3 transmittance;
};

NEPHELE_FN ViewRay aerial_ray(uvec2 texel, float h, float sun_mu) {
  float mu = aerial_elevation_from_unit(unit_from_index(texel.y, kAerialElevations), horizon_cosine(h));
  return view_ray_from_unit(unit_from_index(texel.x, kAerialAzimuths), mu, h, sun_mu);
}

NEPHELE_FN float aerial_near_m(float h_m, float mu) {
  return h_m > kAtmosphereTopM ? air_segment(h_m, mu, false).near_m : 0.0f;
}

NEPHELE_FN AerialSample aerial_lookup(Table3D aerial_light, Table3D aerial_transmittance, vec3 direction,
                                      vec3 sun_direction, float h_m, float distance_m) {
  float horizon_mu = horizon_cosine(h_m);
  vec3 uvw =
      vec3(texel_from_unit(unit_from_azimuth_cosine(azimuth_cosine(direction, sun_direction)), float(kAerialAzimuths)),
           texel_from_unit(aerial_unit_from_elevation(direction.z, horizon_mu), float(kAerialElevations)),
           texel_from_unit(unit_from_distance(distance_m, aerial_near_m(h_m, direction.z), aerial_reach_m(h_m)),
                           float(kAerialDistances)));
  AerialSample result;
  result.light = table_rgb(sample_table(aerial_light, uvw));
  result.transmittance = table_rgb(sample_table(aerial_transmittance, uvw));
  return result;
}

NEPHELE_SHARED_END

#endif
