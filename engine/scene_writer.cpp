#include "engine/scene_writer.h"

#include <charconv>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>
#include <variant>

#include "engine/accepted.h"
#include "engine/atomic_file.h"
#include "engine/check.h"
#include "engine/scene_document.h"

namespace nephele {
namespace {

using Json = nlohmann::ordered_json;

double as_written(double value) { return value; }
double as_written(float value) { return few_digits(value); }

template <glm::length_t N, class Real>
Json as_written(const glm::vec<N, Real>& value) {
  Json numbers = Json::array();
  for (glm::length_t i = 0; i < N; ++i) numbers.push_back(as_written(value[i]));
  return numbers;
}

// A key whose default is none is left out where there is no value.
template <class Value>
void write_optional(Json& json, const char* key, const std::optional<Value>& value) {
  if (value) json[key] = as_written(*value);
}

Json write_camera(const CameraState& camera) {
  return {{"position_m", as_written(camera.position_m)},
          {"yaw_deg", degrees_of(camera.yaw_rad)},
          {"pitch_deg", degrees_of(camera.pitch_rad)},
          {"roll_deg", degrees_of(camera.roll_rad)},
          {"vertical_fov_deg", degrees_of(camera.vertical_fov_rad)}};
}

Json write_clouds(const CloudSettings& clouds, const std::string& map_file) {
  Json json{{"seed", clouds.seed},
            {"coverage", as_written(clouds.coverage)},
            {"base_m", as_written(clouds.base_m)},
            {"thickness_m", as_written(clouds.thickness_m)},
            {"extinction_per_m", as_written(clouds.extinction_per_m)},
            {"growth_period_s", clouds.growth_period_s},
            {"wind_m_per_s", as_written(clouds.wind_m_per_s)},
            {"view_distance_m", as_written(clouds.view_distance_m)}};
  if (const auto& map = clouds.weather_map)
    json["weather_map"] = {
        {"file", map_file}, {"origin_m", as_written(map->origin_m)}, {"extent_m", as_written(map->extent_m)}};
  return json;
}

Json write_particles(const std::vector<ListedParticle>& particles) {
  Json list = Json::array();
  for (const ListedParticle& particle : particles) {
    Json json{{"center_m", as_written(particle.center_m)}};
    const glm::vec3 d = particle.ellipsoid.diagonal_m, o = particle.ellipsoid.off_diagonal_m;
    if (o == glm::vec3(0.0f))
      json["radius_m"] = as_written(d);
    else
      json["ellipsoid_m"] = {few_digits(d.x), few_digits(d.y), few_digits(d.z),
                             few_digits(o.x), few_digits(o.y), few_digits(o.z)};
    json["density"] = as_written(particle.density);
    json["extinction_per_m"] = as_written(particle.extinction_per_m);
    json["shape"] = particle_shape_name(particle.shape);
    write_optional(json, "radiance", particle.radiance);
    write_optional(json, "base_m", particle.base_m);
    write_optional(json, "top_m", particle.top_m);
    write_optional(json, "orientation", particle.orientation);
    list.push_back(std::move(json));
  }
  return list;
}

void write_placement(Json& json, const Placement& placement) {
  json["at_m"] = as_written(placement.at_m);
  json["heading_deg"] = degrees_of(placement.heading_rad);
  json["scale"] = placement.scale;
  json["drifts"] = placement.drifts;
  write_optional(json, "wind_m_per_s", placement.wind_m_per_s);
}

// A whole scene's document, whose file names are relative to a directory.
class DocumentWriter {
 public:
  explicit DocumentWriter(const std::string& directory) {
    if (directory.empty()) return;
    std::error_code failure;
    const std::filesystem::path whole = std::filesystem::absolute(directory, failure);
    directory_ = std::filesystem::weakly_canonical(whole, failure);
  }
  const std::optional<Error>& error() const { return error_; }

  Json write(const Scene& scene) {
    const bool mapped = scene.clouds && scene.clouds->weather_map;
    Json json = settings_document(scene, mapped ? map_file("clouds", *scene.clouds) : "");
    Json& views = json["views"] = Json::array();
    for (const SceneView& view : scene.views)
      views.push_back({{"name", view.name}, {"camera", write_camera(view.camera)}});
    if (const auto& terrain = scene.terrain)
      json["terrain"] = {{"file", file_name("terrain", "height map", terrain->file)},
                         {"origin_m", as_written(terrain->origin_m)},
                         {"extent_m", as_written(terrain->extent_m)},
                         {"lowest_m", as_written(terrain->lowest_m)},
                         {"highest_m", as_written(terrain->highest_m)}};
    json["particles"] = write_particles(scene.particles);
    Json& sources = json["sources"] = Json::array();
    for (const SceneSource& source : scene.sources) {
      const std::string key = concat("sources[", sources.size(), ']');
      sources.push_back(std::visit([&](const auto& kind) { return write_source(kind, key); }, source));
    }
    return json;
  }

 private:
  Json write_source(const CloudSettings& clouds, const std::string& key) {
    Json json{{"kind", "field"}};
    json.update(write_clouds(clouds, clouds.weather_map ? map_file(key, clouds) : ""));
    return json;
  }
  Json write_source(const ParticleGroup& group, const std::string& /*key*/) {
    Json json{{"kind", "particles"}, {"particles", write_particles(group.particles)}};
    write_placement(json, group.placement);
    return json;
  }
  Json write_source(const PlacedSet& placed, const std::string& key) {
    Json json{{"kind", "set"}, {"file", file_name(key, "set", placed.set.file)}};
    write_placement(json, placed.placement);
    json["view_distance_m"] = as_written(placed.view_distance_m);
    if (placed.instances.empty()) return json;
    Json& instances = json["instances"] = Json::array();
    for (const SetInstance& instance : placed.instances)
      instances.push_back({{"at_m", as_written(instance.at_m)},
                           {"heading_deg", degrees_of(instance.heading_rad)},
                           {"scale", instance.scale}});
    return json;
  }
  Json write_source(const ScatteredSets& scattered, const std::string& key) {
    Json sets = Json::array();
    for (const ScatteredSets::Kind& kind : scattered.kinds)
      sets.push_back({{"file", file_name(concat(key, ".sets[", sets.size(), ']'), "set", kind.set.file)},
                      {"share", as_written(kind.share)}});
    Json json{{"kind", "scatter"},
              {"sets", sets},
              {"seed", scattered.seed},
              {"clouds_per_km2", as_written(scattered.clouds_per_km2)},
              {"coverage", as_written(scattered.coverage)},
              {"altitude_m", as_written(scattered.altitude_m)},
              {"scale", as_written(scattered.scale)},
              {"drifts", scattered.drifts},
              {"view_distance_m", as_written(scattered.view_distance_m)}};
    write_optional(json, "wind_m_per_s", scattered.wind_m_per_s);
    if (const auto& map = scattered.weather_map)
      json["weather_map"] = {{"file", file_name(key + ".weather_map", "weather map", map->file)},
                             {"origin_m", as_written(map->origin_m)},
                             {"extent_m", as_written(map->extent_m)}};
    return json;
  }
  std::string map_file(const std::string& key, const CloudSettings& clouds) {
    return file_name(key + ".weather_map", "weather map", clouds.weather_map->file);
  }
  std::string file_name(const std::string& key, const std::string& what, const std::string& file) {
    if (file.empty()) fail(concat(key, " is a ", what, " that no file made; accepted: one that was read from a file"));
    if (directory_.empty()) return file;
    const std::string relative = std::filesystem::path(file).lexically_relative(directory_).string();
    return relative.empty() ? file : relative;
  }
  void fail(const std::string& message) {
    if (!error_) error_ = Error{message};
  }

  std::filesystem::path directory_;
  std::optional<Error> error_;
};

// Numbers by their fewest digits, and what fits on a line on one.
class Printer {
 public:
  std::string print(const Json& document) {
    print_lines(document, 0);
    return std::move(text_) + '\n';
  }

 private:
  static constexpr std::size_t kLineLength = 110;

  void print_scalar(const Json& value) {
    if (!value.is_number_float()) {
      text_ += value.dump();
      return;
    }
    const auto number = value.get<double>();
    // "-0" would be read as a whole number, which has no sign.
    text_ += number == 0.0 && std::signbit(number) ? "-0.0" : number_text(number);
  }
  // Leaves the text as it is where the value would reach beyond `end`.
  bool print_line(const Json& value, std::size_t end) {
    const std::size_t start = text_.size();
    if (!value.is_structured()) {
      print_scalar(value);
    } else {
      text_ += value.is_object() ? '{' : '[';
      bool first = true;
      for (const auto& [key, member] : value.items()) {
        if (!first) text_ += ", ";
        if (value.is_object()) text_ += Json(key).dump() + ": ";
        first = false;
        if (!print_line(member, end)) return text_.resize(start), false;
      }
      text_ += value.is_object() ? '}' : ']';
    }
    if (text_.size() <= end) return true;
    text_.resize(start);
    return false;
  }
  void print_lines(const Json& value, std::size_t indent) {
    if (!value.is_structured()) return print_scalar(value);
    const bool root = indent == 0;
    const std::size_t line_start = text_.rfind('\n') + 1;  // npos + 1: 0
    if (!root && print_line(value, line_start + kLineLength)) return;
    text_ += value.is_object() ? '{' : '[';
    bool first = true;
    for (const auto& [key, member] : value.items()) {
      text_ += first ? "\n" : ",\n";
      text_.append(indent + 2, ' ');
      if (value.is_object()) text_ += Json(key).dump() + ": ";
      first = false;
      print_lines(member, indent + 2);
    }
    text_ += '\n';
    text_.append(indent, ' ');
    text_ += value.is_object() ? '}' : ']';
  }

  std::string text_;
};

// The reader's own complaint about the text, its files aside.
Result<void> check_text(const std::string& text, const std::string& name) {
  const Result<nlohmann::json> document = parse_json(text, name);
  if (!document) return document.error();
  JsonReader reader(name);
  JsonObject root = reader.root(*document);
  Scene scene;
  SceneFiles files;
  read_scene(root, scene, files);
  root.finish();
  return reader.error() ? Result<void>(*reader.error()) : Result<void>();
}

}  // namespace

double few_digits(float value) {
  char text[64];
  const auto [end, failure] = std::to_chars(std::begin(text), std::end(text), value, std::chars_format::scientific);
  double number = value;
  if (failure == std::errc()) std::from_chars(text, end, number);
  // By way of a double the digits could round to the float beside it.
  return static_cast<float>(number) == value ? number : double{value};
}

double degrees_of(double angle_rad) {
  const double nearest = angle_rad / kRadiansPerDegree;
  double below = nearest, above = nearest, best = nearest;
  const auto gives_angle = [angle_rad](double degrees) { return degrees * kRadiansPerDegree == angle_rad; };
  // Quotient and product are rounded once each, and two neighbours may give one product: two to each side are enough.
  for (int step = 0; step < 2; ++step) {
    below = std::nextafter(below, -INFINITY);
    above = std::nextafter(above, INFINITY);
    for (const double other : {below, above}) {
      if (!gives_angle(other)) continue;
      if (!gives_angle(best) || number_text(other).size() < number_text(best).size()) best = other;
    }
  }
  return best;
}

nlohmann::ordered_json settings_document(const Scene& scene, const std::string& map_file) {
  Json json{{"world_origin_m", as_written(scene.world_origin_m)},
            {"camera", write_camera(scene.camera)},
            {"sun",
             {{"azimuth_deg", degrees_of(scene.sun.azimuth_rad)},
              {"elevation_deg", degrees_of(scene.sun.elevation_rad)},
              {"irradiance", as_written(scene.sun.irradiance)}}},
            {"atmosphere", {{"enabled", scene.atmosphere.enabled}}},
            {"ground", {{"enabled", scene.ground.enabled}, {"albedo", as_written(scene.ground.albedo)}}},
            {"exposure_ev", as_written(scene.exposure_ev)}};
  if (scene.clouds) json["clouds"] = write_clouds(*scene.clouds, map_file);
  json["phase"] = {{"function", phase_function_name(scene.phase.function)}, {"g", scene.phase.g}};
  return json;
}

Result<std::string> scene_text(const Scene& scene, const std::string& directory, const std::string& name) {
  DocumentWriter writer(directory);
  std::string text;
  try {
    const Json document = writer.write(scene);
    if (writer.error()) return Error{concat(name, ": ", writer.error()->message)};
    text = Printer().print(document);
  } catch (const nlohmann::json::type_error&) {
    return Error{name + ": a name of a view or of a file is not UTF-8, as JSON is"};
  }
  if (auto ok = check_text(text, name); !ok) return ok.error();
  return text;
}

Result<void> save_scene(const Scene& scene, const std::string& path) {
  const std::filesystem::path parent = std::filesystem::path(path).parent_path();
  const Result<std::string> text = scene_text(scene, parent.empty() ? "." : parent.string(), path);
  return text ? write_file_atomically(path, *text) : text.error();
}

}  // namespace nephele
