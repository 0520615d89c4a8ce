// What a picture is of: camera, sun, atmosphere, ground, clouds. Plain structs in SI units and radians, and the
// reader of the JSON scene file (whose keys carry degrees). Knows nothing of how a scene is drawn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/phase_function.h"
#include "engine/result.h"
#include "shared/ellipsoid.h"

namespace nephele {

// World axes: x east, y north, z up; z is the altitude.
struct CameraState {
  glm::dvec3 position_m{0.0, 0.0, 1500.0};
  double yaw_rad = 0.0;                               // clockwise from north
  double pitch_rad = 5.0 * std::numbers::pi / 180.0;  // up
  double roll_rad = 0.0;                              // the right side goes down
  double vertical_fov_rad = 55.0 * std::numbers::pi / 180.0;

  bool operator==(const CameraState&) const = default;
};

struct SunSettings {
  double azimuth_rad = 220.0 * std::numbers::pi / 180.0;   // clockwise from north
  double elevation_rad = 35.0 * std::numbers::pi / 180.0;  // from the horizon
  glm::vec3 irradiance{1.0f};                              // top of the atmosphere; the unit of light

  bool operator==(const SunSettings&) const = default;
};

struct AtmosphereSettings {
  bool enabled = true;  // off: black sky, no haze

  bool operator==(const AtmosphereSettings&) const = default;
};

struct GroundSettings {
  bool enabled = true;  // off: the sky's colour below the horizon too
  glm::vec3 albedo{0.12f, 0.14f, 0.10f};

  bool operator==(const GroundSettings&) const = default;
};

// Coverage and type of the clouds over a part of the ground. It lies still in the world; clouds drift through it with
// the wind, and grow and vanish as they come into other weather. Values between the middles of texels are interpolated.
// Outside the map the settings' own coverage holds, and type 255, after a fade over 2 km.
struct WeatherMap {
  std::uint32_t width = 0, height = 0;  // texels, 1 .. kMaxWeatherMapSide
  // Rows from the north. x: coverage times 255; y: type, from 0 humilis (many, small, flat) to 255 as without a map.
  std::vector<glm::u8vec2> texels;
  glm::dvec2 origin_m{0.0};  // of the south-west corner, in the world
  glm::dvec2 extent_m{0.0};  // east and north from there
  // The image that it was read from, from the root of the file system; empty: no file made it. Says where to find the
  // map again and is never read by itself.
  std::string file;

  bool operator==(const WeatherMap&) const = default;
};
inline constexpr std::uint32_t kMaxWeatherMapSide = 4096;

// Heights of a part of the ground, from an image that lies in the world. They stand at the middles of texels and are
// bilinear between them. Beyond the map the outermost texels' heights go on and fade to 0 (terrain_grid.h says over
// what distance).
struct Terrain {
  std::uint32_t width = 0, height = 0;      // texels, 2 .. kMaxTerrainSide
  std::vector<std::uint16_t> texels;        // rows from the north; 0 is lowest_m, 65535 highest_m
  glm::dvec2 origin_m{0.0};                 // of the south-west corner, in the world
  glm::dvec2 extent_m{0.0};                 // east and north from there
  float lowest_m = 0.0f, highest_m = 0.0f;  // altitudes, 0 .. kMaxTerrainM
  std::string file;                         // that it was read from, as WeatherMap::file; empty: no file made it

  bool operator==(const Terrain&) const = default;
};
inline constexpr std::uint32_t kMaxTerrainSide = 2048;  // its arrays then fit the buffers that every device has
inline constexpr float kMaxTerrainM = 9000.0f;

struct CloudSettings {
  std::uint32_t seed = 1;
  float coverage = 0.45f;
  float base_m = 1200.0f;
  float thickness_m = 900.0f;
  float extinction_per_m = 0.05f;
  glm::dvec2 wind_m_per_s{6.0, 2.0};
  // Each cloud grows and shrinks once in this time, out of step with the others; 0: never.
  double growth_period_s = 0.0;
  float view_distance_m = 80000.0f;
  std::optional<WeatherMap> weather_map;

  bool operator==(const CloudSettings&) const = default;
};

struct PhaseSettings {
  PhaseFunction function = PhaseFunction::henyey_greenstein;
  double g = 0.85;  // asymmetry; double, because it is part of the tables' key

  bool operator==(const PhaseSettings&) const = default;
};

enum class ParticleShape : std::uint8_t {
  reference,    // the inhomogeneous reference particle from the table
  homogeneous,  // constant extinction = density * extinction_per_m inside the ellipsoid
  soft,         // falls off as the mean profile of all others (light.h); detail thickens and thins it
};

struct ListedParticle {
  glm::dvec3 center_m{0.0};
  shared::EllipsoidShape ellipsoid{glm::vec3(100.0f), glm::vec3(0.0f)};
  float density = 1.0f;
  float extinction_per_m = 0.05f;
  ParticleShape shape = ParticleShape::reference;
  std::optional<glm::vec3> radiance;  // the source radiance itself, unlit
  std::optional<float> base_m;        // altitude of the cloud's flat base, which cuts the particle; none: no base
  std::optional<float> top_m;         // altitude of the cloud's top above it, for sky light; none: the particle's own
  // Of the reference particle in the ellipsoid's unit space: unit quaternion x, y, z, w; none: upright.
  std::optional<glm::vec4> orientation;

  bool operator==(const ListedParticle&) const = default;
};

inline constexpr std::size_t kMaxListedParticles = 262144;

// Where a group of particles stands: what lies at p in the group's own frame is found at
// at_m + R(heading) * scale * p in the world.
struct Placement {
  glm::dvec3 at_m{0.0};
  double heading_rad = 0.0;  // clockwise from north, seen from above; particles turn along
  double scale = 1.0;        // of places and sizes; extinction is divided by it, so that optical depths stay
  bool drifts = false;       // with the wind from time 0 on
  std::optional<glm::dvec2> wind_m_per_s;  // none: that of the scene's first cloud field, or calm

  bool operator==(const Placement&) const = default;
};

struct ParticleGroup {
  std::vector<ListedParticle> particles;
  Placement placement;

  bool operator==(const ParticleGroup&) const = default;
};

// A cloud as a particle set (engine/particle_set.h), which copies of a scene and all its instances share.
struct ParticleSet;
struct SetFile {
  std::string file;  // the .json that it was read from, as WeatherMap::file; empty: no file made it
  std::shared_ptr<const ParticleSet> set;

  bool operator==(const SetFile&) const;  // by what the sets hold
};

// Where a set stands once more, in the frame of its placement.
struct SetInstance {
  glm::dvec3 at_m{0.0};
  double heading_rad = 0.0;
  double scale = 1.0;

  bool operator==(const SetInstance&) const = default;
};
inline constexpr std::size_t kMaxSetInstances = 65536;

// A set in the scene, once or many times. Far ones are drawn by the set's coarser levels.
struct PlacedSet {
  SetFile set;
  Placement placement{.at_m = glm::dvec3(0.0), .drifts = true};
  std::vector<SetInstance> instances;  // none: one at the placement itself
  float view_distance_m = 80000.0f;    // beyond it instances are left out; over its last fifth they fade

  bool operator==(const PlacedSet&) const = default;
};

// Sets strewn over the ground without end: a lattice has one place for a cloud in every cell, and the weather says how
// many of them are taken. Clouds stand still in the air, which drifts through the weather map.
struct ScatteredSets {
  struct Kind {
    SetFile set;
    float share = 1.0f;  // of the clouds, by ratio to the others'

    bool operator==(const Kind&) const = default;
  };
  std::vector<Kind> kinds;  // 1 .. kMaxScatteredKinds
  std::uint32_t seed = 1;
  float clouds_per_km2 = 0.1f;  // where coverage is 1
  float coverage = 1.0f;        // share of the places that have a cloud; beyond the map, where there is one
  float altitude_m = 1000.0f;   // of height 0 of the sets
  glm::vec2 scale{0.8f, 1.2f};  // least and greatest
  bool drifts = true;
  std::optional<glm::dvec2> wind_m_per_s;
  float view_distance_m = 80000.0f;
  std::optional<WeatherMap> weather_map;  // its coverage; types are not read

  bool operator==(const ScatteredSets&) const = default;
};
inline constexpr std::size_t kMaxScatteredKinds = 64;
inline constexpr std::size_t kMaxScatterPlaces = std::size_t{1} << 20;  // in the square about the view

// One of many sources of clouds.
using SceneSource = std::variant<CloudSettings, ParticleGroup, PlacedSet, ScatteredSets>;
inline constexpr std::size_t kMaxSources = 64;

// A place to look from, by a name that no other view of the scene has.
struct SceneView {
  std::string name;  // not empty
  CameraState camera;

  bool operator==(const SceneView&) const = default;
};
inline constexpr std::size_t kMaxViews = 64;

// Two scenes are equal if every value of theirs is.
struct Scene {
  // The patterns of clouds and ground are counted from here: shifted together with camera and particles, it leaves the
  // picture as it is.
  glm::dvec2 world_origin_m{0.0};
  CameraState camera;
  SunSettings sun;
  AtmosphereSettings atmosphere;
  GroundSettings ground;
  std::optional<Terrain> terrain;                         // none: a plain at altitude 0
  float exposure_ev = 0.0f;                               // stops; radiance is scaled by 2^exposure_ev
  std::vector<SceneView> views;                           // beside `camera`, in the file's order
  std::optional<CloudSettings> clouds = CloudSettings{};  // none: only the listed particles
  PhaseSettings phase;
  std::vector<ListedParticle> particles;
  std::vector<SceneSource> sources;  // further ones, after `particles` and `clouds`

  bool operator==(const Scene&) const = default;
};

// All cloud fields in the order of their particles: `clouds`, then those among `sources`.
std::vector<const CloudSettings*> cloud_fields(const Scene& scene);

// Every key is optional and defaults to the value above. A file without "clouds" has the default clouds, unless it
// lists "particles" or "sources" (even none of them): then it has no others. Unknown or repeated keys, wrong types and
// values out of range are errors naming the file, the key's path, the value and what is accepted.
//
// "clouds"."weather_map" is {"file": PNG, "origin_m": [x, y], "extent_m": [x, y]}, all three required, the file's path
// relative to the scene file's directory. Red is coverage, green type, each as value / 255 with no colour management;
// a grey image is coverage alone, with type 255.
//
// "terrain" is {"file": PNG, "origin_m": [x, y], "extent_m": [x, y], "lowest_m", "highest_m"}, all five required; the
// file is grey, of 8 or 16 bits.
//
// A member of "sources" has a "kind": "field" with the keys of "clouds"; "particles" with its own list of "particles";
// "set" with the "file" of a particle set (engine/particle_set.h), its path relative as above, and perhaps its
// "instances". The latter two also have the keys of Placement: "at_m", "heading_deg", "scale", "drifts" (default true
// for a set, false for particles) and "wind_m_per_s". "scatter" has the keys of ScatteredSets.
//
// A particle's ellipsoid is "radius_m" (three semi-axes, or one for a sphere) turned by "yaw_deg", and what is inside
// it turns along; or "ellipsoid_m", the six numbers xx, yy, zz, xy, xz, yz of its shape.
//
// A member of "views" is {"name": TEXT, "camera": {...}}: the name is required, the camera has the keys and defaults of
// "camera" itself.
Result<Scene> load_scene(const std::string& path);
Result<Scene> parse_scene(std::string_view json_text, const std::string& name_for_errors,
                          const std::string& directory = ".");

// Every key of a scene file, in the reader's order, with what it accepts in words and as values; struct JsonKey stands
// in engine/json_reader.h.
struct JsonKey;
std::vector<JsonKey> scene_keys();

// One line if the map's texels are not width * height, or a side or its extent is out of range: for maps that no file
// made.
Result<void> check_weather_map(const WeatherMap& map);

// The same for terrain; its altitudes too.
Result<void> check_terrain(const Terrain& terrain);

}  // namespace nephele
