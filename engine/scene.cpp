#include "engine/scene.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "engine/check.h"
#include "engine/image_io.h"
#include "engine/json_reader.h"
#include "engine/particle_set.h"
#include "engine/scene_document.h"

namespace nephele {
namespace {

constexpr Range kAngleDeg{-3600, 3600};
constexpr Range kHorizontalM{-1e9, 1e9};
constexpr Range kLight{0, 1e6};
constexpr Range kFraction{0, 1};
constexpr Range kAltitudeM{-1e6, 1e6};
constexpr Range kWind{-500, 500};
constexpr Range kScale{1e-3, 1e3};
constexpr Range kViewDistanceM{1, 500000};

// An angle that a number of degrees in a file gives, not more than a rounding from the one asked for.
double as_from_degrees(double angle_rad) { return degrees_of(angle_rad) * kRadiansPerDegree; }

// Straight ahead lies the place, as if the ground were flat.
void turn_towards(JsonObject& json, CameraState& camera, const glm::dvec3& place_m) {
  if (json.has("yaw_deg") || json.has("pitch_deg"))
    return json.fail("look_at_m", "stands beside yaw_deg or pitch_deg; accepted: one or the other");
  const glm::dvec3 to_place = place_m - camera.position_m;
  if (to_place == glm::dvec3(0.0)) return json.fail("look_at_m", "is the camera's own place");
  const double horizontal_m = std::hypot(to_place.x, to_place.y);
  if (horizontal_m > 0.0) camera.yaw_rad = as_from_degrees(std::atan2(to_place.x, to_place.y));
  camera.pitch_rad = as_from_degrees(std::atan2(to_place.z, horizontal_m));
}

void read_camera(JsonObject& json, CameraState& camera) {
  json.vector("position_m", camera.position_m, {kHorizontalM, kHorizontalM, Range{0, 1e6}});
  json.number("yaw_deg", camera.yaw_rad, kAngleDeg, kRadiansPerDegree);
  json.number("pitch_deg", camera.pitch_rad, {-90, 90}, kRadiansPerDegree);
  std::optional<glm::dvec3> look_at_m;
  json.vector("look_at_m", look_at_m, {kHorizontalM, kHorizontalM, Range{-1e6, 1e6}});
  if (look_at_m) turn_towards(json, camera, *look_at_m);
  json.number("roll_deg", camera.roll_rad, kAngleDeg, kRadiansPerDegree);
  json.number("vertical_fov_deg", camera.vertical_fov_rad, {0.1, 170}, kRadiansPerDegree);
}

void read_sun(JsonObject& json, SunSettings& sun) {
  json.number("azimuth_deg", sun.azimuth_rad, kAngleDeg, kRadiansPerDegree);
  json.number("elevation_deg", sun.elevation_rad, {-90, 90}, kRadiansPerDegree);
  json.vector("irradiance", sun.irradiance, {kLight});
}

constexpr Range kMapExtentM{1, 4e7};

Result<void> load_texels(WeatherMap& map, const std::string& path);

// found: finds the map once the scene has been read.
void read_weather_map(JsonObject& json, WeatherMap& map, SceneFiles& files, const std::function<WeatherMap&()>& found) {
  for (const char* key : {"file", "origin_m", "extent_m"}) json.require(key);
  std::string file;
  json.file("file", file);
  files.push_back(
      {json.path_of("file"), file, [found](const std::string& path) { return load_texels(found(), path); }});
  json.vector("origin_m", map.origin_m, {kHorizontalM});
  json.vector("extent_m", map.extent_m, {kMapExtentM});
}

// From the root of the file system, so that it is found from anywhere, with no link or ".." among its directories. The
// last name stays even if it is a link: a set's array lies beside it, not beside what it links to.
std::string from_root(const std::string& path) {
  std::error_code failure;
  const std::filesystem::path whole = std::filesystem::absolute(path, failure);
  const std::filesystem::path directory = std::filesystem::canonical(whole.parent_path(), failure);
  return failure ? whole.string() : (directory / whole.filename()).string();
}

Result<void> load_texels(WeatherMap& map, const std::string& path) {
  const Result<ImageBytes> image = read_png(path, kMaxWeatherMapSide);
  if (!image) return image.error();
  map.file = from_root(path);
  map.width = image->width;
  map.height = image->height;
  map.texels.resize(std::size_t{map.width} * map.height);
  for (std::size_t i = 0; i < map.texels.size(); ++i) {
    const std::uint8_t* pixel = &image->data[i * image->channels];
    map.texels[i] = image->channels == 1 ? glm::u8vec2(pixel[0], 255) : glm::u8vec2(pixel[0], pixel[1]);
  }
  return {};
}

void read_clouds(JsonObject& json, CloudSettings& clouds, SceneFiles& files,
                 const std::function<CloudSettings&()>& field) {
  json.integer("seed", clouds.seed);
  json.number("coverage", clouds.coverage, kFraction);
  json.number("base_m", clouds.base_m, {0, 20000});
  json.number("thickness_m", clouds.thickness_m, {1, 20000});
  json.number("extinction_per_m", clouds.extinction_per_m, {0, 1000});
  json.number("growth_period_s", clouds.growth_period_s, {0, 1e6});
  json.vector("wind_m_per_s", clouds.wind_m_per_s, {kWind});
  json.number("view_distance_m", clouds.view_distance_m, kViewDistanceM);
  json.object("weather_map", [&](JsonObject& child) {
    read_weather_map(child, clouds.weather_map.emplace(), files,
                     [field]() -> WeatherMap& { return *field().weather_map; });
  });
}

constexpr Range kTerrainM{0, kMaxTerrainM};

Result<void> load_heights(Terrain& terrain, const std::string& path) {
  Result<GreyImage> image = read_grey_png(path, kMaxTerrainSide);
  if (!image) return image.error();
  terrain.file = from_root(path);
  terrain.width = image->width;
  terrain.height = image->height;
  terrain.texels = std::move(image->data);
  if (auto ok = check_terrain(terrain); !ok) return Error{path + ": " + ok.error().message};
  return {};
}

void read_terrain(JsonObject& json, Scene& scene, SceneFiles& files) {
  Terrain& terrain = scene.terrain.emplace();
  for (const char* key : {"file", "origin_m", "extent_m", "lowest_m", "highest_m"}) json.require(key);
  std::string file;
  json.file("file", file);
  files.push_back(
      {json.path_of("file"), file, [&scene](const std::string& path) { return load_heights(*scene.terrain, path); }});
  json.vector("origin_m", terrain.origin_m, {kHorizontalM});
  json.vector("extent_m", terrain.extent_m, {kMapExtentM});
  json.number("lowest_m", terrain.lowest_m, kTerrainM);
  json.number("highest_m", terrain.highest_m, kTerrainM);
  if (terrain.highest_m < terrain.lowest_m) json.refuse("highest_m", "lowest_m or more");
}

void read_phase(JsonObject& json, PhaseSettings& phase) {
  json.choice("function", phase.function,
              {{phase_function_name(PhaseFunction::henyey_greenstein), PhaseFunction::henyey_greenstein},
               {phase_function_name(PhaseFunction::cornette_shanks), PhaseFunction::cornette_shanks}});
  json.number("g", phase.g, {-kMaxAsymmetry, kMaxAsymmetry});
}

constexpr Range kRadiusM{0.01, 1e5};

// shared::upright_shape in doubles.
shared::EllipsoidShape turned_upright(const glm::vec3& radius_m, double yaw_rad) {
  const double s = std::sin(yaw_rad), c = std::cos(yaw_rad);
  const glm::dvec3 r(radius_m);
  return {glm::vec3(glm::dvec3(r.x * c * c + r.y * s * s, r.x * s * s + r.y * c * c, r.z)),
          glm::vec3(static_cast<float>((r.y - r.x) * s * c), 0.0f, 0.0f)};
}

// Returns the yaw of what is inside.
double read_ellipsoid(JsonObject& json, shared::EllipsoidShape& ellipsoid) {
  glm::vec3 radius_m = ellipsoid.diagonal_m;
  double yaw_rad = 0.0;
  json.radii("radius_m", radius_m, kRadiusM);
  json.number("yaw_deg", yaw_rad, kAngleDeg, kRadiansPerDegree);
  std::optional<std::array<double, 6>> shape;
  json.numbers("ellipsoid_m", shape, {-kRadiusM.maximum, kRadiusM.maximum});
  if (!shape) {
    ellipsoid = turned_upright(radius_m, yaw_rad);
    return yaw_rad;
  }
  if (json.has("radius_m") || json.has("yaw_deg"))
    json.fail("ellipsoid_m", "stands beside radius_m or yaw_deg; accepted: one or the other");
  ellipsoid = {glm::vec3((*shape)[0], (*shape)[1], (*shape)[2]), glm::vec3((*shape)[3], (*shape)[4], (*shape)[5])};
  if (!is_positive_definite(ellipsoid))
    json.refuse("ellipsoid_m", "xx, yy, zz, xy, xz, yz of a positive definite matrix");
  return 0.0;
}

void read_particle(JsonObject& json, ListedParticle& particle) {
  json.vector("center_m", particle.center_m, {kHorizontalM, kHorizontalM, kAltitudeM});
  const double yaw_rad = read_ellipsoid(json, particle.ellipsoid);
  json.number("density", particle.density, {0, 1000});
  json.number("extinction_per_m", particle.extinction_per_m, {0, 1e6});
  read_particle_shape(json, particle.shape);
  json.vector("radiance", particle.radiance, {kLight});
  json.number("base_m", particle.base_m, kAltitudeM);
  json.number("top_m", particle.top_m, kAltitudeM);
  if (particle.base_m && particle.top_m && *particle.top_m < *particle.base_m) json.refuse("top_m", "base_m or more");
  json.vector("orientation", particle.orientation, {{-1, 1}});
  if (!particle.orientation) {
    if (yaw_rad != 0.0 && particle.shape == ParticleShape::reference)
      particle.orientation = shared::yaw_rotation(static_cast<float>(yaw_rad));
    return;
  }
  if (std::abs(glm::length(*particle.orientation) - 1.0f) > 1e-3f)
    json.refuse("orientation", "a unit quaternion x, y, z, w");
  // One that is a unit quaternion but for roundings stands as it is, so that what was normalised stays the same.
  const double squared = glm::dot(glm::dvec4(*particle.orientation), glm::dvec4(*particle.orientation));
  if (std::abs(squared - 1.0) > 1e-6) particle.orientation = glm::normalize(*particle.orientation);
  if (yaw_rad != 0.0)
    particle.orientation = glm::normalize(
        shared::quaternion_product(shared::yaw_rotation(static_cast<float>(yaw_rad)), *particle.orientation));
}

// What places a source; the keys of Placement.
void read_placement(JsonObject& json, Placement& placement) {
  json.vector("at_m", placement.at_m, {kHorizontalM, kHorizontalM, kAltitudeM});
  json.number("heading_deg", placement.heading_rad, kAngleDeg, kRadiansPerDegree);
  json.number("scale", placement.scale, kScale);
  json.boolean("drifts", placement.drifts);
  json.vector("wind_m_per_s", placement.wind_m_per_s, {kWind});
}

// found: finds the set's place in the scene once that has been read.
void read_set_file(JsonObject& json, SceneFiles& files, const std::function<SetFile&()>& found) {
  std::string file;
  json.require("file");
  json.file("file", file);
  files.push_back({json.path_of("file"), file, [found](const std::string& path) -> Result<void> {
                     Result<ParticleSet> set = load_particle_set(path);
                     if (!set) return set.error();
                     found() = {from_root(path), std::make_shared<const ParticleSet>(std::move(*set))};
                     return {};
                   }});
}

void read_set(JsonObject& json, std::vector<SceneSource>& sources, SceneFiles& files) {
  const std::size_t index = sources.size();
  PlacedSet& placed = std::get<PlacedSet>(sources.emplace_back(PlacedSet{}));
  read_set_file(json, files, [&sources, index]() -> SetFile& { return std::get<PlacedSet>(sources[index]).set; });
  read_placement(json, placed.placement);
  json.number("view_distance_m", placed.view_distance_m, kViewDistanceM);
  json.objects("instances", kMaxSetInstances, [&](JsonObject& child) {
    SetInstance& instance = placed.instances.emplace_back();
    child.vector("at_m", instance.at_m, {kHorizontalM, kHorizontalM, kAltitudeM});
    child.number("heading_deg", instance.heading_rad, kAngleDeg, kRadiansPerDegree);
    child.number("scale", instance.scale, kScale);
  });
}

void read_scatter(JsonObject& json, std::vector<SceneSource>& sources, SceneFiles& files) {
  const std::size_t index = sources.size();
  ScatteredSets& scattered = std::get<ScatteredSets>(sources.emplace_back(ScatteredSets{}));
  const auto found = [&sources, index]() -> ScatteredSets& { return std::get<ScatteredSets>(sources[index]); };
  json.require("sets");
  json.objects("sets", kMaxScatteredKinds, [&](JsonObject& child) {
    const std::size_t kind = scattered.kinds.size();
    scattered.kinds.emplace_back();
    read_set_file(child, files, [found, kind]() -> SetFile& { return found().kinds[kind].set; });
    child.number("share", scattered.kinds[kind].share, {0, 1000});
  });
  json.integer("seed", scattered.seed);
  json.number("clouds_per_km2", scattered.clouds_per_km2, {1e-4, 100});
  json.number("coverage", scattered.coverage, kFraction);
  json.number("altitude_m", scattered.altitude_m, {0, 20000});
  json.vector("scale", scattered.scale, {kScale});
  json.boolean("drifts", scattered.drifts);
  json.vector("wind_m_per_s", scattered.wind_m_per_s, {kWind});
  json.number("view_distance_m", scattered.view_distance_m, kViewDistanceM);
  json.object("weather_map", [&](JsonObject& child) {
    read_weather_map(child, scattered.weather_map.emplace(), files,
                     [found]() -> WeatherMap& { return *found().weather_map; });
  });
  const double across = 2e-3 * double{scattered.view_distance_m} * std::sqrt(double{scattered.clouds_per_km2});
  if (across * across > static_cast<double>(kMaxScatterPlaces))
    json.fail("clouds_per_km2", concat("makes ", static_cast<std::uint64_t>(across * across),
                                       " places within view_distance_m; accepted: at most ", kMaxScatterPlaces));
  float shares = 0.0f;
  for (const ScatteredSets::Kind& kind : scattered.kinds) shares += kind.share;
  if (json.has("sets") && !(shares > 0.0f))
    json.fail("sets", "has no set whose share is above 0; accepted: at least one");
  if (scattered.scale.y < scattered.scale.x) json.refuse("scale", "the least and then the greatest");
}

void read_group(JsonObject& json, std::vector<SceneSource>& sources) {
  ParticleGroup group;
  json.require("particles");
  json.objects("particles", kMaxListedParticles,
               [&](JsonObject& child) { read_particle(child, group.particles.emplace_back()); });
  read_placement(json, group.placement);
  sources.emplace_back(std::move(group));
}

void read_field(JsonObject& json, std::vector<SceneSource>& sources, SceneFiles& files) {
  const std::size_t index = sources.size();
  CloudSettings& field = std::get<CloudSettings>(sources.emplace_back(CloudSettings{}));
  read_clouds(json, field, files,
              [&sources, index]() -> CloudSettings& { return std::get<CloudSettings>(sources[index]); });
}

void read_source(JsonObject& json, std::vector<SceneSource>& sources, SceneFiles& files) {
  json.kind("kind", {{"set", [&](JsonObject& set) { read_set(set, sources, files); }},
                     {"scatter", [&](JsonObject& scatter) { read_scatter(scatter, sources, files); }},
                     {"field", [&](JsonObject& field) { read_field(field, sources, files); }},
                     {"particles", [&](JsonObject& group) { read_group(group, sources); }}});
}

void read_view(JsonObject& json, SceneView& view, const std::vector<SceneView>& earlier) {
  json.require("name");
  json.string("name", view.name);
  for (const SceneView& other : earlier)
    if (other.name == view.name && !view.name.empty()) json.refuse("name", "a name that no other view has");
  json.object("camera", [&](JsonObject& child) { read_camera(child, view.camera); });
}

}  // namespace

const char* particle_shape_name(ParticleShape shape) {
  switch (shape) {
    case ParticleShape::reference:
      return "reference";
    case ParticleShape::homogeneous:
      return "homogeneous";
    case ParticleShape::soft:
      return "soft";
  }
  return "";
}

void read_particle_shape(JsonObject& json, ParticleShape& shape) {
  json.choice("shape", shape,
              {{particle_shape_name(ParticleShape::reference), ParticleShape::reference},
               {particle_shape_name(ParticleShape::homogeneous), ParticleShape::homogeneous},
               {particle_shape_name(ParticleShape::soft), ParticleShape::soft}});
}

void read_scene(JsonObject& json, Scene& scene, SceneFiles& files) {
  json.vector("world_origin_m", scene.world_origin_m, {kHorizontalM});
  json.object("camera", [&](JsonObject& child) { read_camera(child, scene.camera); });
  json.object("sun", [&](JsonObject& child) { read_sun(child, scene.sun); });
  json.object("atmosphere", [&](JsonObject& child) { child.boolean("enabled", scene.atmosphere.enabled); });
  json.object("ground", [&](JsonObject& child) {
    child.boolean("enabled", scene.ground.enabled);
    child.vector("albedo", scene.ground.albedo, {kFraction});
  });
  json.object("terrain", [&](JsonObject& child) { read_terrain(child, scene, files); });
  json.number("exposure_ev", scene.exposure_ev, {-32, 32});
  json.objects("views", kMaxViews, [&](JsonObject& child) {
    SceneView view;
    read_view(child, view, scene.views);
    scene.views.push_back(std::move(view));
  });
  if ((json.has("particles") || json.has("sources")) && !json.has("clouds")) scene.clouds.reset();
  json.object("clouds", [&](JsonObject& child) {
    read_clouds(child, *scene.clouds, files, [&scene]() -> CloudSettings& { return *scene.clouds; });
  });
  json.object("phase", [&](JsonObject& child) { read_phase(child, scene.phase); });
  json.objects("particles", kMaxListedParticles,
               [&](JsonObject& child) { read_particle(child, scene.particles.emplace_back()); });
  json.objects("sources", kMaxSources, [&](JsonObject& child) { read_source(child, scene.sources, files); });
}

Result<Scene> parse_scene(std::string_view json_text, const std::string& name_for_errors,
                          const std::string& directory) {
  const Result<nlohmann::json> document = parse_json(json_text, name_for_errors);
  if (!document) return document.error();
  JsonReader reader(name_for_errors);
  JsonObject root = reader.root(*document);
  Scene scene;
  SceneFiles files;
  read_scene(root, scene, files);
  root.finish();
  if (reader.error()) return *reader.error();
  for (const SceneFile& file : files)
    if (auto ok = file.load((std::filesystem::path(directory) / file.name).string()); !ok)
      return Error{concat(name_for_errors, ": ", file.key, ": ", ok.error().message)};
  return scene;
}

std::vector<JsonKey> scene_keys() {
  return JsonReader::keys_of([](JsonObject& root) {
    Scene scene;
    SceneFiles files;
    read_scene(root, scene, files);
  });
}

Result<Scene> load_scene(const std::string& path) {
  const Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  return parse_scene(*text, path, std::filesystem::path(path).parent_path().string());
}

bool SetFile::operator==(const SetFile& other) const {
  if (file != other.file || !set != !other.set) return false;
  return set == other.set || *set == *other.set;
}

std::vector<const CloudSettings*> cloud_fields(const Scene& scene) {
  std::vector<const CloudSettings*> fields;
  if (scene.clouds) fields.push_back(&*scene.clouds);
  for (const SceneSource& source : scene.sources)
    if (const auto* field = std::get_if<CloudSettings>(&source)) fields.push_back(field);
  return fields;
}

namespace {

// Of a map that no file made; what: "weather map".
Result<void> check_map(const char* what, std::uint32_t width, std::uint32_t height, std::uint32_t least,
                       std::uint32_t most, std::size_t texels, const glm::dvec2& origin_m, const glm::dvec2& extent_m) {
  if (width < least || height < least || width > most || height > most)
    return Error{concat(what, " is ", width, " x ", height, " texels; accepted: ", least, " to ", most, " a side")};
  if (texels != std::size_t{width} * height)
    return Error{concat(what, " of ", width, " x ", height, " has ", texels, " texels")};
  for (glm::length_t i = 0; i < 2; ++i) {
    if (!(extent_m[i] >= kMapExtentM.minimum && extent_m[i] <= kMapExtentM.maximum))
      return Error{concat(what, "'s extent_m[", i, "] is ", extent_m[i], "; accepted: ", kMapExtentM.minimum, " to ",
                          kMapExtentM.maximum)};
    if (!(std::abs(origin_m[i]) <= kHorizontalM.maximum))
      return Error{concat(what, "'s origin_m[", i, "] is ", origin_m[i], "; accepted: ", kHorizontalM.minimum, " to ",
                          kHorizontalM.maximum)};
  }
  return {};
}

}  // namespace

Result<void> check_weather_map(const WeatherMap& map) {
  return check_map("weather map", map.width, map.height, 1, kMaxWeatherMapSide, map.texels.size(), map.origin_m,
                   map.extent_m);
}

Result<void> check_terrain(const Terrain& terrain) {
  if (auto ok = check_map("terrain", terrain.width, terrain.height, 2, kMaxTerrainSide, terrain.texels.size(),
                          terrain.origin_m, terrain.extent_m);
      !ok)
    return ok;
  for (const auto& [name, altitude_m] :
       {std::pair{"lowest_m", terrain.lowest_m}, std::pair{"highest_m", terrain.highest_m}})
    if (!(altitude_m >= 0.0f && altitude_m <= kMaxTerrainM))
      return Error{concat("terrain's ", name, " is ", altitude_m, "; accepted: 0 to ", kMaxTerrainM)};
  if (terrain.highest_m < terrain.lowest_m)
    return Error{concat("terrain's highest_m is ", terrain.highest_m, "; accepted: lowest_m or more")};
  return {};
}

}  // namespace nephele
