#include "tools/path_tracer/surroundings.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/camera.h"
#include "engine/parallel.h"
#include "shared/atmosphere_tables.h"
#include "shared/ground.h"
#include "shared/heightfield.h"
#include "shared/water.h"
#include "shared/world.h"
#include "tools/path_tracer/directions.h"
#include "tools/path_tracer/terrain_surface.h"

namespace nephele::truth {

using glm::vec2;
using glm::vec3;
using glm::vec4;
using shared::Table3D;

namespace {

constexpr int kSkyAltitudes = 6;          // from the ground to the top of the clouds, closest at the ground
constexpr float kOffGroundM = 0.05f;      // floats keep a centimetre in 100 km
constexpr float kFarFootprintM = 300.0f;  // of land that is seen by other land
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
  if (scene.terrain) terrain_ = std::make_unique<TerrainSurface>(*scene.terrain, scene.camera.position_m);
  if (scene.atmosphere.enabled && !uniform_sky)
    air_ = std::make_unique<AirTables>(ground_enabled_ ? ground_albedo_ : vec3(0.0f),
                                       std::max(0.0f, camera_altitude_m_), top_m, sun_direction_.z);
}

Surroundings::~Surroundings() = default;

float Surroundings::altitude_m(const vec3& p_m) const { return shared::altitude_m(p_m, camera_altitude_m_); }

vec3 Surroundings::vertical(const vec3& p_m) const {
  return vec3(glm::normalize(glm::dvec3(p_m) + glm::dvec3(0, 0, double{shared::kPlanetRadiusM} + camera_altitude_m_)));
}

bool Surroundings::on_terrain(const vec3& p_m) const { return terrain_ && terrain_->covers(p_m); }

vec3 Surroundings::ground_normal(const vec3& p_m) const {
  return on_terrain(p_m) ? vec3(terrain_->land(p_m).normal) : vertical(p_m);
}

vec3 Surroundings::off_ground(const vec3& p_m) const {
  return has_terrain() ? p_m + kOffGroundM * ground_normal(p_m) : p_m;
}

bool Surroundings::sun_in_sight(const vec3& p_m, const vec2& across) const {
  if (!terrain_) return true;
  const vec3 aside = about(sun_direction_, across.x * shared::kSunRadiusRad, across.y * shared::kSunRadiusRad, 1.0f);
  return std::isinf(terrain_->hit_m(p_m, glm::normalize(glm::dvec3(aside))));
}

vec3 Surroundings::land_albedo(const vec3& p_m, float footprint_m) const {
  const TerrainSurface::Land land = terrain_->land(p_m);
  const shared::GridPlace place = shared::grid_place(camera_world_m_);
  const vec2 ground_m = vec2(glm::dvec2(place.grid_m) + land.from_camera_m);
  const shared::GroundCover cover =
      shared::ground_cover(ground_m, place.origin_index, vec2(1.0f, 0.0f), footprint_m, footprint_m);
  const auto altitude = static_cast<float>(std::max(land.altitude_m, 0.0)), slope = static_cast<float>(land.slope);
  const vec3 dry = shared::terrain_albedo(glm::clamp(ground_albedo_ * cover.albedo_factor, 0.0f, 1.0f), altitude, slope,
                                          shared::relief_noise(ground_m, place.origin_index, footprint_m));
  return glm::mix(dry, shared::water_albedo(), cover.water * shared::terrain_water_share(altitude, slope * slope));
}

vec3 Surroundings::ground_albedo(const vec3& p_m) const {
  return on_terrain(p_m) ? land_albedo(p_m, kFarFootprintM) : ground_albedo_;
}

float Surroundings::cos_zenith(const vec3& p_m, const vec3& direction) const {
  return p_m == vec3(0.0f) ? direction.z : glm::dot(vertical(p_m), direction);
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
  const auto terrain_m = static_cast<float>(terrain_ ? terrain_->hit_m(p_m, glm::normalize(glm::dvec3(direction)))
                                                     : std::numeric_limits<double>::infinity());
  if (!ground_enabled_) return terrain_m;
  const float altitude = std::max(0.0f, altitude_m(p_m)), mu = cos_zenith(p_m, direction);
  return std::min(terrain_m, mu < shared::horizon_cosine(altitude) ? shared::ground_distance(altitude, mu) : kNoGround);
}

// Water is a Lambert surface here, as dark as what comes back from below its surface: it mirrors neither sky nor sun,
// which composite.comp has it do.
vec3 Surroundings::seen_ground_albedo(const vec3& direction, float distance_m, float pixel_rad) const {
  if (const vec3 p_m = direction * distance_m; on_terrain(p_m)) {
    const float facing = std::max(0.02f, -glm::dot(ground_normal(p_m), direction));
    return land_albedo(p_m, distance_m * pixel_rad / facing);
  }
  const float altitude = std::max(0.0f, camera_altitude_m_);
  const float short_m = distance_m * pixel_rad;
  const float step_m = 2.0f * (distance_m - shared::ground_distance(altitude, direction.z - 0.5f * pixel_rad));
  const shared::GridPlace place = shared::grid_place(camera_world_m_);
  const vec3 ground = shared::grid_from_render(direction * distance_m, vec3(place.grid_m.x, place.grid_m.y, altitude));
  const vec2 along = glm::normalize(vec2(direction) + vec2(1e-7f, 0.0f));
  const shared::GroundCover cover =
      shared::ground_cover(vec2(ground), place.origin_index, along, std::hypot(short_m, step_m), short_m);
  return glm::clamp(glm::mix(ground_albedo_ * cover.albedo_factor, shared::water_albedo(), cover.water), 0.0f, 1.0f);
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

Air Surroundings::whole_ray(const vec3& p_m, const vec3& direction) const {
  const float altitude = std::max(0.0f, altitude_m(p_m));
  const vec3 seen = local(p_m, direction);
  Air air = air_->ray(altitude, seen, sun_direction_, seen.z < shared::horizon_cosine(altitude));
  air.light *= sun_irradiance_;
  return air;
}

vec3 Surroundings::transmittance_between(const vec3& low_m, const vec3& high_m, const vec3& up) const {
  const vec3 whole = shared::transmittance_to_top(air_->to_top.view, std::max(0.0f, altitude_m(low_m)),
                                                  std::max(0.0f, cos_zenith(low_m, up)));
  const vec3 rest = shared::transmittance_to_top(air_->to_top.view, std::max(0.0f, altitude_m(high_m)),
                                                 std::max(0.0f, cos_zenith(high_m, up)));
  return glm::min(whole / glm::max(rest, 1e-6f), 1.0f);
}

Air Surroundings::air_to_ground(const vec3& p_m, const vec3& direction, float distance_m) const {
  if (!air_) return {};
  const vec3 end_m = p_m + distance_m * direction;
  if (!on_terrain(end_m)) return whole_ray(p_m, direction);
  if (p_m == vec3(0.0f)) return air_from_camera(direction, distance_m);
  const bool rises = cos_zenith(p_m, direction) > 0.0f;
  Air air;
  air.transmittance =
      rises ? transmittance_between(p_m, end_m, direction) : transmittance_between(end_m, p_m, -direction);
  const Air whole = whole_ray(p_m, direction);
  air.light = whole.light * (1.0f - air.transmittance) / glm::max(1.0f - whole.transmittance, 1e-3f);
  return air;
}

Air Surroundings::air_from_ground(const vec3& ground_m, const vec3& p_m, const vec3& direction) const {
  if (!air_) return {};
  const float altitude = std::max(0.0f, altitude_m(p_m));
  const float ground_altitude = on_terrain(ground_m) ? std::max(0.0f, altitude_m(ground_m)) : 0.0f;
  const vec3 whole =
      shared::transmittance_to_top(air_->to_top.view, ground_altitude, std::max(0.0f, cos_zenith(ground_m, direction)));
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
