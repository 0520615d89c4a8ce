#include "engine/scene.h"

#include "engine/json_reader.h"

namespace nephele {
namespace {

constexpr Range kAngleDeg{-3600, 3600};
constexpr Range kHorizontalM{-1e9, 1e9};
constexpr Range kLight{0, 1e6};
constexpr Range kFraction{0, 1};

void read_camera(JsonObject& json, CameraState& camera) {
  json.vector("position_m", camera.position_m, {kHorizontalM, kHorizontalM, Range{0, 1e6}});
  json.number("yaw_deg", camera.yaw_rad, kAngleDeg, kRadiansPerDegree);
  json.number("pitch_deg", camera.pitch_rad, {-90, 90}, kRadiansPerDegree);
  json.number("roll_deg", camera.roll_rad, kAngleDeg, kRadiansPerDegree);
  json.number("vertical_fov_deg", camera.vertical_fov_rad, {0.1, 170}, kRadiansPerDegree);
}

void read_sun(JsonObject& json, SunSettings& sun) {
  json.number("azimuth_deg", sun.azimuth_rad, kAngleDeg, kRadiansPerDegree);
  json.number("elevation_deg", sun.elevation_rad, {-90, 90}, kRadiansPerDegree);
  json.vector("irradiance", sun.irradiance, {kLight});
}

void read_clouds(JsonObject& json, CloudSettings& clouds) {
  json.integer("seed", clouds.seed);
  json.number("coverage", clouds.coverage, kFraction);
  json.number("base_m", clouds.base_m, {0, 20000});
  json.number("thickness_m", clouds.thickness_m, {1, 20000});
  json.number("extinction_per_m", clouds.extinction_per_m, {0, 1000});
  json.number("growth_period_s", clouds.growth_period_s, {0, 1e6});
  json.vector("wind_m_per_s", clouds.wind_m_per_s, {{-500, 500}});
  json.number("view_distance_m", clouds.view_distance_m, {1, 500000});
}

void read_phase(JsonObject& json, PhaseSettings& phase) {
  json.choice("function", phase.function,
              {{"hg", PhaseFunction::henyey_greenstein}, {"cs", PhaseFunction::cornette_shanks}});
  json.number("g", phase.g, {-0.95, 0.95});  // what the tables can be baked for
}

void read_particle(JsonObject& json, ListedParticle& particle) {
  json.vector("center_m", particle.center_m, {kHorizontalM, kHorizontalM, Range{-1e6, 1e6}});
  json.vector("radius_m", particle.radius_m, {{0.01, 1e5}});
  json.number("yaw_deg", particle.yaw_rad, kAngleDeg, kRadiansPerDegree);
  json.number("density", particle.density, {0, 1000});
  json.number("extinction_per_m", particle.extinction_per_m, {0, 1e6});
  json.choice("shape", particle.shape,
              {{"reference", ParticleShape::reference}, {"homogeneous", ParticleShape::homogeneous}});
  glm::vec3 radiance{0.0f};
  json.vector("radiance", radiance, {kLight});
  if (json.has("radiance")) particle.radiance = radiance;
}

void read_scene(JsonObject& json, Scene& scene) {
  json.vector("world_origin_m", scene.world_origin_m, {kHorizontalM});
  json.object("camera", [&](JsonObject& child) { read_camera(child, scene.camera); });
  json.object("sun", [&](JsonObject& child) { read_sun(child, scene.sun); });
  json.object("atmosphere", [&](JsonObject& child) { child.boolean("enabled", scene.atmosphere.enabled); });
  json.object("ground", [&](JsonObject& child) {
    child.boolean("enabled", scene.ground.enabled);
    child.vector("albedo", scene.ground.albedo, {kFraction});
  });
  json.number("exposure_ev", scene.exposure_ev, {-32, 32});
  if (json.has("particles") && !json.has("clouds")) scene.clouds.reset();
  json.object("clouds", [&](JsonObject& child) { read_clouds(child, *scene.clouds); });
  json.object("phase", [&](JsonObject& child) { read_phase(child, scene.phase); });
  json.objects("particles", kMaxListedParticles,
               [&](JsonObject& child) { read_particle(child, scene.particles.emplace_back()); });
}

}  // namespace

Result<Scene> parse_scene(std::string_view json_text, const std::string& name_for_errors) {
  const Result<nlohmann::json> document = parse_json(json_text, name_for_errors);
  if (!document) return document.error();
  JsonReader reader(name_for_errors);
  JsonObject root = reader.root(*document);
  Scene scene;
  read_scene(root, scene);
  root.finish();
  if (reader.error()) return *reader.error();
  return scene;
}

Result<Scene> load_scene(const std::string& path) {
  const Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  return parse_scene(*text, path);
}

}  // namespace nephele
