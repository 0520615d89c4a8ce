#include "engine/particle_set.h"

#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "engine/check.h"
#include "engine/json_reader.h"
#include "engine/npy.h"

namespace nephele {
namespace {

constexpr const char* kFormat = "nephele particle set";
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kColumns = 10;
constexpr std::array<const char*, kColumns> kColumnNames = {"center_x", "center_y",  "center_z", "shape_xx",
                                                            "shape_yy", "shape_zz",  "shape_xy", "shape_xz",
                                                            "shape_yz", "extinction"};
constexpr std::array<const char*, kColumns> kUnits = {"m", "m", "m", "m", "m", "m", "m", "m", "m", "1/m"};
constexpr Range kHeightM{-1e6, 1e6};

static_assert(sizeof(SetParticle) == kColumns * sizeof(float));

std::filesystem::path array_path(const std::filesystem::path& json_path) {
  return std::filesystem::path(json_path).replace_extension(".npy");
}

Result<void> check_particle(const SetParticle& p) {
  std::array<float, kColumns> values;
  std::memcpy(values.data(), &p, sizeof p);
  for (std::size_t column = 0; column < kColumns; ++column)
    if (!std::isfinite(values[column])) return Error{concat(kColumnNames[column], " is ", values[column])};
  const glm::dvec3 d(p.diagonal_m), o(p.off_diagonal_m);
  const double minor = d.x * d.y - o.x * o.x;
  const double determinant = d.z * minor - o.z * (o.z * d.x - o.x * o.y) + o.y * (o.x * o.z - d.y * o.y);
  if (!(d.x > 0.0 && minor > 0.0 && determinant > 0.0)) return Error{"the shape is not positive definite"};
  if (p.extinction_per_m < 0.0f) return Error{concat("extinction is ", p.extinction_per_m, "; accepted: 0 or more")};
  return {};
}

// What the JSON file says about the array.
struct Description {
  std::uint32_t count = 0;
  std::vector<std::string> columns;
  std::string hash;
};

std::vector<std::string> texts(JsonReader& reader, JsonObject& json, const char* key) {
  std::vector<std::string> found;
  const nlohmann::json* value = json.value(key);
  if (!value) return found;
  if (value->is_array())
    for (const nlohmann::json& text : *value)
      if (text.is_string()) found.push_back(text.get<std::string>());
  if (!value->is_array() || found.size() != value->size()) reader.fail(json.path_of(key) + " is not an array of texts");
  return found;
}

Result<Description> read_description(const std::string& text, const std::string& file, ParticleSet& set) {
  const Result<nlohmann::json> document = parse_json(text, file);
  if (!document) return document.error();
  JsonReader reader(file);
  JsonObject json = reader.root(*document);
  for (const char* key : {"format", "version", "columns", "units", "count", "base_m", "top_m", "hash", "source"})
    json.require(key);
  Description description;
  std::string format;
  std::uint32_t version = kVersion;
  json.string("format", format);
  json.integer("version", version, kVersion, kVersion);
  description.columns = texts(reader, json, "columns");
  const std::vector<std::string> units = texts(reader, json, "units");
  json.integer("count", description.count, 1, static_cast<std::uint32_t>(kMaxSetParticles));
  json.number("base_m", set.base_m, kHeightM);
  json.number("top_m", set.top_m, kHeightM);
  json.string("hash", description.hash);
  json.object("source", [&](JsonObject& child) {
    child.require("name");
    child.string("name", set.source);
    const nlohmann::json* parameters = child.value("parameters");
    if (parameters && !parameters->is_object()) reader.fail("source.parameters is not an object");
    if (parameters) set.parameters = parameters->dump();
  });
  json.finish();
  if (reader.error()) return *reader.error();
  if (format != kFormat) reader.fail(concat("format is \"", format, "\"; accepted: \"", kFormat, "\""));
  if (description.columns.size() < kColumns || units.size() != description.columns.size())
    reader.fail(concat("columns: ", description.columns.size(), ", units: ", units.size(), "; accepted: ", kColumns,
                       " or more, as many of one as of the other"));
  for (std::size_t i = 0; i < kColumns && !reader.error(); ++i)
    if (description.columns[i] != kColumnNames[i] || units[i] != kUnits[i])
      reader.fail(concat("column ", i, " is \"", description.columns[i], "\" in ", units[i], "; accepted: \"",
                         kColumnNames[i], "\" in ", kUnits[i]));
  if (reader.error()) return *reader.error();
  return description;
}

}  // namespace

Result<void> check_particle_set(const ParticleSet& set) {
  if (set.particles.empty() || set.particles.size() > kMaxSetParticles)
    return Error{concat(set.particles.size(), " particles; accepted: 1 to ", kMaxSetParticles)};
  for (const auto& [name, value] : {std::pair("base_m", set.base_m), std::pair("top_m", set.top_m)})
    if (!(value >= static_cast<float>(kHeightM.minimum) && value <= static_cast<float>(kHeightM.maximum)))
      return Error{concat(name, " is ", value, "; accepted: ", kHeightM.minimum, " to ", kHeightM.maximum)};
  if (!(set.top_m >= set.base_m)) return Error{concat("top_m is ", set.top_m, ", below base_m, ", set.base_m)};
  for (std::size_t i = 0; i < set.particles.size(); ++i)
    if (auto ok = check_particle(set.particles[i]); !ok) return Error{concat("particle ", i, ": ", ok.error().message)};
  return {};
}

Result<void> save_particle_set(const std::filesystem::path& json_path, const ParticleSet& set) {
  const auto fault = [&](const std::string& what) { return Error{json_path.string() + ": " + what}; };
  if (json_path.extension() != ".json") return fault("a particle set's name ends in .json");
  if (auto ok = check_particle_set(set); !ok) return fault(ok.error().message);
  const nlohmann::ordered_json parameters = nlohmann::ordered_json::parse(set.parameters, nullptr, false);
  if (!parameters.is_object()) return fault("the source's parameters are not a JSON object");
  NpyArray array{ElementType::float32, {set.particles.size(), kColumns}, {}};
  const auto rows = std::as_bytes(std::span(set.particles));
  array.data.assign(rows.begin(), rows.end());
  if (auto ok = write_npy(array_path(json_path), array); !ok) return ok;
  const nlohmann::ordered_json description{{"format", kFormat},
                                           {"version", kVersion},
                                           {"columns", kColumnNames},
                                           {"units", kUnits},
                                           {"count", set.particles.size()},
                                           {"base_m", set.base_m},
                                           {"top_m", set.top_m},
                                           {"hash", hex64(fnv1a(array.data))},
                                           {"source", {{"name", set.source}, {"parameters", parameters}}}};
  const std::string text = description.dump(2) + '\n';
  return write_file(json_path, std::as_bytes(std::span(text)));
}

Result<ParticleSet> load_particle_set(const std::filesystem::path& json_path) {
  const std::string file = json_path.string();
  const Result<std::string> text = read_text_file(file);
  if (!text) return text.error();
  ParticleSet set;
  const Result<Description> description = read_description(*text, file, set);
  if (!description) return description.error();
  const Result<NpyArray> array = read_npy(array_path(json_path));
  if (!array) return array.error();
  const auto fault = [&](const std::string& what) { return Error{array_path(json_path).string() + ": " + what}; };
  if (array->type != ElementType::float32) return fault("float32 is accepted");
  const std::size_t columns = description->columns.size();
  if (array->shape != std::vector<std::size_t>{description->count, columns})
    return fault(concat("not the ", description->count, " rows of ", columns, " columns that ", file, " tells of"));
  if (hex64(fnv1a(array->data)) != description->hash) return fault("damaged: its hash is not the one in " + file);
  set.particles.resize(description->count);
  for (std::size_t i = 0; i < set.particles.size(); ++i)
    std::memcpy(&set.particles[i], &array->data[i * columns * sizeof(float)], sizeof(SetParticle));
  if (auto ok = check_particle_set(set); !ok) return Error{file + ": " + ok.error().message};
  return set;
}

Result<std::vector<ListedParticle>> listed_particles(const ParticleSet& set) {
  std::vector<ListedParticle> listed;
  listed.reserve(set.particles.size());
  for (std::size_t i = 0; i < set.particles.size(); ++i) {
    const SetParticle& p = set.particles[i];
    if (p.off_diagonal_m.y != 0.0f || p.off_diagonal_m.z != 0.0f)
      return Error{concat("particle ", i, " is tilted: shape_xz is ", p.off_diagonal_m.y, ", shape_yz is ",
                          p.off_diagonal_m.z, "; accepted: 0")};
    // The eigenvectors of the horizontal part: the longer radius lies at the angle `turn` from x towards y.
    const double xx = p.diagonal_m.x, yy = p.diagonal_m.y, xy = p.off_diagonal_m.x;
    const double mean = 0.5 * (xx + yy), spread = std::hypot(0.5 * (xx - yy), xy);
    const double turn = spread > 0.0 ? 0.5 * std::atan2(2.0 * xy, xx - yy) : 0.0;
    ListedParticle particle;
    particle.center_m = glm::dvec3(p.center_m);
    particle.radius_m = {static_cast<float>(mean + spread), static_cast<float>(mean - spread), p.diagonal_m.z};
    particle.yaw_rad = -turn;  // clockwise
    particle.density = 1.0f;
    particle.extinction_per_m = p.extinction_per_m;
    particle.base_m = set.base_m;
    particle.top_m = set.top_m;
    listed.push_back(particle);
  }
  return listed;
}

}  // namespace nephele
