#include "tools/path_tracer/surroundings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/camera.h"
#include "engine/parallel.h"
#include "shared/atmosphere_tables.h"
#include "shared/ground.h"
#include "shared/world.h"

namespace nephele::truth {

using glm::vec2;
using glm::vec3;
using glm::vec4;
using shared::Table3D;

namespace {

constexpr int kSkyAltitudes = 6;  // from the ground to the top of the clouds, closest at the ground
constexpr float kNoGround = std::numeric_limits<float>::infinity();

// A table that owns its texels.
struct Table {
  std::vector<vec4> texels;
  Table3D view;

  template <class Texel>
  static Table filled(int width, int height, Texel&& texel) {
    Table table;
    table.texels.resize(static_cast<std::size_t>(width) * height);
    parallel_for(height, [&](int y) {
      for (int x = 0; x < width; ++x)
        table.texels[static_cast<std::size_t>(y) * width + x] = vec4(texel(glm::uvec2(x, y)), 1.0f);
    });
    table.view = {width, height, 1, table.texels.data()};
    return table;
  }
};

}  // namespace

// Light of whole rays from one altitude.
struct Surroundings::SkySlice {
  float altitude_m;
  Table smooth, aerosol, transmittance;

  SkySlice(float altitude, const Table3D& to_top, const Table3D& multi_scattering, float sun_cos_zenith)
      : altitude_m(altitude) {
    constexpr int kWidth = shared::kSkyViewWidth, kHeight = shared::kSkyViewHeight;
    std::vector<shared::ViewMarch> rays(std::size_t{kWidth} * kHeight);
    parallel_for(kHeight, [&](int y) {
      for (int x = 0; x < kWidth; ++x)
        rays[static_cast<std::size_t>(y) * kWidth + x] =
            shared::sky_view_texel(to_top, multi_scattering, glm::uvec2(x, y), altitude, sun_cos_zenith);
    });
    const auto ray = [&](glm::uvec2 at) { return rays[std::size_t{at.y} * kWidth + at.x]; };
    smooth = Table::filled(kWidth, kHeight, [&](glm::uvec2 at) { return ray(at).smooth_light; });
    aerosol = Table::filled(kWidth, kHeight, [&](glm::uvec2 at) { return ray(at).aerosol_light; });
    transmittance = Table::filled(1, kHeight, [&](glm::uvec2 at) { return ray(at).transmittance; });
  }

  Air ray(const vec3& direction, const vec3& sun_direction, bool below) const {
    const float horizon = shared::horizon_cosine(altitude_m);
    return {shared::sky_view_lookup(smooth.view, aerosol.view, direction, sun_direction, horizon, below),
            shared::view_transmittance_lookup(transmittance.view, direction.z, horizon, below)};
  }
};

struct Surroundings::AirTables {
  Table to_top, multi_scattering;
  std::vector<SkySlice> slices;  // by altitude
  std::vector<vec4> aerial_light, aerial_transmittance;
  Table3D aerial_light_view, aerial_transmittance_view;

  AirTables(const vec3& ground_albedo, float camera_altitude_m, float top_m, float sun_cos_zenith) {
    to_top = Table::filled(shared::kTransmittanceWidth, shared::kTransmittanceHeight, shared::transmittance_texel);
    multi_scattering = Table::filled(shared::kMultiScatteringWidth, shared::kMultiScatteringHeight, [&](glm::uvec2 at) {
      return shared::multi_scattering_texel(to_top.view, at, ground_albedo);
    });
    std::vector<float> altitudes{camera_altitude_m};
    for (int i = 0; i < kSkyAltitudes; ++i) {
      const float x = static_cast<float>(i) / (kSkyAltitudes - 1);
      altitudes.push_back(x * x * std::max(top_m, 1000.0f));
    }
    std::sort(altitudes.begin(), altitudes.end());
    for (const float altitude : altitudes)
      slices.emplace_back(altitude, to_top.view, multi_scattering.view, sun_cos_zenith);
    fill_aerial(camera_altitude_m, sun_cos_zenith);
  }

  void fill_aerial(float altitude_m, float sun_cos_zenith) {
    constexpr int kX = shared::kAerialAzimuths, kY = shared::kAerialElevations, kZ = shared::kAerialDistances;
    aerial_light.resize(std::size_t{kX} * kY * kZ);
    aerial_transmittance.resize(aerial_light.size());
    parallel_for(kY, [&](int y) {
      for (int x = 0; x < kX; ++x) {
        const shared::ViewRay ray = shared::aerial_ray(glm::uvec2(x, y), altitude_m, sun_cos_zenith);
        const float near_m = shared::aerial_near_m(altitude_m, ray.cos_zenith);
        const float phase = shared::aerosol_phase(ray.sun_cos_view);
        shared::ViewMarch march = shared::begin_march(ray, near_m);
        for (int z = 0; z < kZ; ++z) {
          if (z > 0)
            shared::march_to(
                to_top.view, multi_scattering.view, ray,
                shared::distance_from_unit(shared::unit_from_index(z, kZ), near_m, shared::aerial_reach_m(altitude_m)),
                march);
          const std::size_t at = (static_cast<std::size_t>(z) * kY + y) * kX + x;
          aerial_light[at] = vec4(march.smooth_light + march.aerosol_light * phase, 1.0f);
          aerial_transmittance[at] = vec4(march.transmittance, 1.0f);
        }
      }
    });
    aerial_light_view = {kX, kY, kZ, aerial_light.data()};
    aerial_transmittance_view = {kX, kY, kZ, aerial_transmittance.data()};
  }

  Air ray(float altitude_m, const vec3& direction, const vec3& sun_direction, bool below) const {
    const auto upper = std::find_if(slices.begin(), slices.end() - 1,
                                    [&](const SkySlice& slice) { return slice.altitude_m >= altitude_m; });
    const Air high = upper->ray(direction, sun_direction, below);
    if (upper == slices.begin() || upper->altitude_m <= altitude_m) return high;
    const SkySlice& lower = *(upper - 1);
    const Air low = lower.ray(direction, sun_direction, below);
    const float x = (altitude_m - lower.altitude_m) / (upper->altitude_m - lower.altitude_m);
    return {glm::mix(low.light, high.light, x), glm::mix(low.transmittance, high.transmittance, x)};
  }
};

Surroundings::Surroundings(const Scene& scene, std::optional<vec3> uniform_sky, float top_m)
    : sun_direction_(direction_from_angles(scene.sun.azimuth_rad, scene.sun.elevation_rad)),
      sun_irradiance_(scene.sun.irradiance),
      sun_shines_(glm::any(glm::greaterThan(scene.sun.irradiance, vec3(0.0f)))),
      ground_enabled_(scene.ground.enabled),
      ground_albedo_(scene.ground.albedo),
      uniform_sky_(uniform_sky),
      camera_world_m_(scene.camera.position_m - glm::dvec3(scene.world_origin_m, 0.0)),
      camera_altitude_m_(static_cast<float>(scene.camera.position_m.z)) {
  if (scene.atmosphere.enabled && !uniform_sky)
    air_ = std::make_unique<AirTables>(ground_enabled_ ? ground_albedo_ : vec3(0.0f),
                                       std::max(0.0f, camera_altitude_m_), top_m, sun_direction_.z);
}

Surroundings::~Surroundings() = default;

float Surroundings::altitude_m(const vec3& p_m) const { return shared::altitude_m(p_m, camera_altitude_m_); }

vec3 Surroundings::ground_normal(const vec3& p_m) const {
  return vec3(glm::normalize(glm::dvec3(p_m) + glm::dvec3(0, 0, double{shared::kPlanetRadiusM} + camera_altitude_m_)));
}

float Surroundings::cos_zenith(const vec3& p_m, const vec3& direction) const {
  return p_m == vec3(0.0f) ? direction.z : glm::dot(ground_normal(p_m), direction);
}

// The direction as seen from under p's zenith; its azimuth hardly changes within the view distance.
vec3 Surroundings::local(const vec3& p_m, const vec3& direction) const {
  const float mu = std::clamp(cos_zenith(p_m, direction), -1.0f, 1.0f);
  const float across = direction.x * direction.x + direction.y * direction.y;
  const float scale = across > 1e-20f ? std::sqrt((1 - mu * mu) / across) : 0.0f;
  return {scale * direction.x, scale * direction.y, mu};
}

vec3 Surroundings::sun_irradiance(const vec3& p_m) const {
  if (uniform_sky_) return sun_irradiance_;
  const float altitude = std::max(0.0f, altitude_m(p_m)), mu = cos_zenith(p_m, sun_direction_);
  if (!air_) return sun_irradiance_ * shared::sun_visibility(altitude, mu);
  return sun_irradiance_ * shared::sun_transmittance(air_->to_top.view, altitude, mu);
}

float Surroundings::ground_m(const vec3& p_m, const vec3& direction) const {
  if (!ground_enabled_) return kNoGround;
  const float altitude = std::max(0.0f, altitude_m(p_m)), mu = cos_zenith(p_m, direction);
  return mu < shared::horizon_cosine(altitude) ? shared::ground_distance(altitude, mu) : kNoGround;
}

vec3 Surroundings::seen_ground_albedo(const vec3& direction, float distance_m, float pixel_rad) const {
  const float altitude = std::max(0.0f, camera_altitude_m_);
  const float nearer_m = shared::ground_distance(altitude, direction.z - 0.5f * pixel_rad);
  const float footprint_m = std::max(distance_m * pixel_rad, 2.0f * (distance_m - nearer_m));
  const shared::GridPlace place = shared::grid_place(camera_world_m_);
  const vec3 ground = shared::grid_from_render(direction * distance_m, vec3(place.grid_m.x, place.grid_m.y, altitude));
  const vec3 variation = shared::ground_variation(vec2(ground.x, ground.y), place.origin_index, footprint_m);
  return glm::clamp(ground_albedo_ * variation, 0.0f, 1.0f);
}

vec3 Surroundings::sky(const vec3& p_m, const vec3& direction) const {
  if (uniform_sky_) return *uniform_sky_;
  if (!air_) return vec3(0.0f);
  const float altitude = std::max(0.0f, altitude_m(p_m));
  vec3 seen = local(p_m, direction);
  const float horizon = shared::horizon_cosine(altitude);
  if (seen.z < horizon) {  // there is no ground: the horizon mirrors the sky, as composite.comp draws it
    const float mu = shared::elevation_from_unit(shared::unit_from_elevation(seen.z, horizon, true), horizon, false);
    const float across = std::sqrt((1 - mu * mu) / std::max(1e-12f, 1 - seen.z * seen.z));
    seen = vec3(seen.x * across, seen.y * across, mu);
  }
  return sun_irradiance_ * air_->ray(altitude, seen, sun_direction_, false).light;
}

Air Surroundings::air_to_ground(const vec3& p_m, const vec3& direction) const {
  if (!air_) return {};
  Air air = air_->ray(std::max(0.0f, altitude_m(p_m)), local(p_m, direction), sun_direction_, true);
  air.light *= sun_irradiance_;
  return air;
}

Air Surroundings::air_from_ground(const vec3& ground_m, const vec3& p_m, const vec3& direction) const {
  if (!air_) return {};
  const float altitude = std::max(0.0f, altitude_m(p_m));
  const vec3 whole =
      shared::transmittance_to_top(air_->to_top.view, 0.0f, std::max(0.0f, cos_zenith(ground_m, direction)));
  const vec3 rest = shared::transmittance_to_top(air_->to_top.view, altitude, cos_zenith(p_m, direction));
  Air air;
  air.transmittance = glm::min(whole / glm::max(rest, 1e-6f), 1.0f);
  air.light = glm::max(sky(ground_m, direction) - air.transmittance * sky(p_m, direction), 0.0f);
  return air;
}

Air Surroundings::air_from_camera(const vec3& direction, float distance_m) const {
  if (!air_) return {};
  const shared::AerialSample sample =
      shared::aerial_lookup(air_->aerial_light_view, air_->aerial_transmittance_view, direction, sun_direction_,
                            std::max(0.0f, camera_altitude_m_), distance_m);
  return {sun_irradiance_ * sample.light, sample.transmittance};
}

}  // namespace nephele::truth
