#include "engine/particle_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "engine/check.h"
#include "engine/json_reader.h"
#include "engine/npy.h"
#include "engine/scene_document.h"
#include "shared/hash.h"

namespace nephele {
namespace {

constexpr const char* kFormat = "nephele particle set";
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kColumns = 10;
constexpr std::array<const char*, kColumns> kColumnNames = {"center_x", "center_y",  "center_z", "shape_xx",
                                                            "shape_yy", "shape_zz",  "shape_xy", "shape_xz",
                                                            "shape_yz", "extinction"};
constexpr std::array<const char*, kColumns> kUnits = {"m", "m", "m", "m", "m", "m", "m", "m", "m", "1/m"};
constexpr std::size_t kOwnColumns = 13;  // with those that a set may have
constexpr std::array<const char*, kOwnColumns - kColumns> kFurtherNames = {"base", "top", "seed"};
constexpr std::array<const char*, kOwnColumns - kColumns> kFurtherUnits = {"m", "m", "1"};
constexpr Range kHeightM{-1e6, 1e6};

static_assert(sizeof(SetParticle) == kOwnColumns * sizeof(float));

bool is_height(float value) {
  return value >= static_cast<float>(kHeightM.minimum) && value <= static_cast<float>(kHeightM.maximum);
}

std::filesystem::path array_path(const std::filesystem::path& json_path) {
  return std::filesystem::path(json_path).replace_extension(".npy");
}

Result<void> check_particle(const ParticleSet& set, const SetParticle& p) {
  std::array<float, kColumns> values;
  std::memcpy(values.data(), &p, sizeof values);
  for (std::size_t column = 0; column < kColumns; ++column)
    if (!std::isfinite(values[column])) return Error{concat(kColumnNames[column], " is ", values[column])};
  if (!is_positive_definite(p.ellipsoid())) return Error{"the shape is not positive definite"};
  if (p.extinction_per_m < 0.0f) return Error{concat("extinction is ", p.extinction_per_m, "; accepted: 0 or more")};
  if (!(p.base_m >= set.base_m && p.top_m <= set.top_m && p.top_m >= p.base_m))
    return Error{concat("base is ", p.base_m, " and top ", p.top_m, "; accepted: base_m to top_m of the set, ",
                        set.base_m, " to ", set.top_m)};
  if (!(p.seed >= 0.0f && p.seed <= kMaxParticleSeed && p.seed == std::floor(p.seed)))
    return Error{concat("seed is ", p.seed, "; accepted: a whole number from 0 to ", kMaxParticleSeed)};
  return {};
}

// What the JSON file says about the array.
struct Description {
  std::uint32_t count = 0;
  std::vector<std::string> columns;
  std::vector<std::string> coarser;  // names of files
  std::string hash;

  // Where the column stands in a row.
  std::optional<std::size_t> column(std::string_view name) const {
    const auto found = std::find(columns.begin(), columns.end(), name);
    if (found == columns.end()) return std::nullopt;
    return static_cast<std::size_t>(found - columns.begin());
  }
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
  read_particle_shape(json, set.shape);
  json.number("detail", set.detail, {0, 1});
  if (json.has("coarser")) description.coarser = texts(reader, json, "coarser");
  if (description.coarser.size() > kMaxCoarserLevels)
    reader.fail(concat("coarser names ", description.coarser.size(), " levels; accepted: at most ", kMaxCoarserLevels));
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

// Whole numbers below 2^24, alike on every machine.
float seed_of(std::size_t index) {
  return static_cast<float>(shared::hash_uint(static_cast<std::uint32_t>(index)) >> 8);
}

std::filesystem::path coarser_path(const std::filesystem::path& json_path, std::size_t level) {
  return json_path.parent_path() / (json_path.stem().string() + '_' + std::to_string(level + 1) + ".json");
}

}  // namespace

bool is_positive_definite(const shared::EllipsoidShape& shape) {
  const glm::dvec3 d(shape.diagonal_m), o(shape.off_diagonal_m);
  const double minor = d.x * d.y - o.x * o.x;
  const double determinant = d.z * minor - o.z * (o.z * d.x - o.x * o.y) + o.y * (o.x * o.z - d.y * o.y);
  return d.x > 0.0 && minor > 0.0 && determinant > 0.0;
}

void give_particles_base_and_top(ParticleSet& set) {
  for (std::size_t i = 0; i < set.particles.size(); ++i) {
    set.particles[i].base_m = set.base_m;
    set.particles[i].top_m = set.top_m;
    set.particles[i].seed = seed_of(i);
  }
}

Result<void> check_particle_set(const ParticleSet& set) {
  if (set.particles.empty() || set.particles.size() > kMaxSetParticles)
    return Error{concat(set.particles.size(), " particles; accepted: 1 to ", kMaxSetParticles)};
  for (const auto& [name, value] : {std::pair("base_m", set.base_m), std::pair("top_m", set.top_m)})
    if (!is_height(value))
      return Error{concat(name, " is ", value, "; accepted: ", kHeightM.minimum, " to ", kHeightM.maximum)};
  if (!(set.top_m >= set.base_m)) return Error{concat("top_m is ", set.top_m, ", below base_m, ", set.base_m)};
  if (!(set.detail >= 0.0f && set.detail <= 1.0f)) return Error{concat("detail is ", set.detail, "; accepted: 0 to 1")};
  if (set.coarser.size() > kMaxCoarserLevels)
    return Error{concat(set.coarser.size(), " coarser levels; accepted: at most ", kMaxCoarserLevels)};
  for (std::size_t i = 0; i < set.coarser.size(); ++i) {
    if (!set.coarser[i].coarser.empty()) return Error{concat("coarser level ", i + 1, " has coarser levels itself")};
    if (auto ok = check_particle_set(set.coarser[i]); !ok)
      return Error{concat("coarser level ", i + 1, ": ", ok.error().message)};
  }
  for (std::size_t i = 0; i < set.particles.size(); ++i)
    if (auto ok = check_particle(set, set.particles[i]); !ok)
      return Error{concat("particle ", i, ": ", ok.error().message)};
  return {};
}

Result<void> save_particle_set(const std::filesystem::path& json_path, const ParticleSet& set) {
  const auto fault = [&](const std::string& what) { return Error{json_path.string() + ": " + what}; };
  if (json_path.extension() != ".json") return fault("a particle set's name ends in .json");
  if (auto ok = check_particle_set(set); !ok) return fault(ok.error().message);
  const nlohmann::ordered_json parameters = nlohmann::ordered_json::parse(set.parameters, nullptr, false);
  if (!parameters.is_object()) return fault("the source's parameters are not a JSON object");
  nlohmann::ordered_json coarser = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < set.coarser.size(); ++i) {
    const std::filesystem::path level = coarser_path(json_path, i);
    if (auto ok = save_particle_set(level, set.coarser[i]); !ok) return ok;
    coarser.push_back(level.filename().string());
  }
  NpyArray array{ElementType::float32, {set.particles.size(), kOwnColumns}, {}};
  const auto rows = std::as_bytes(std::span(set.particles));
  array.data.assign(rows.begin(), rows.end());
  if (auto ok = write_npy(array_path(json_path), array); !ok) return ok;
  std::vector<std::string> columns(kColumnNames.begin(), kColumnNames.end()), units(kUnits.begin(), kUnits.end());
  columns.insert(columns.end(), kFurtherNames.begin(), kFurtherNames.end());
  units.insert(units.end(), kFurtherUnits.begin(), kFurtherUnits.end());
  nlohmann::ordered_json description{{"format", kFormat},
                                     {"version", kVersion},
                                     {"columns", columns},
                                     {"units", units},
                                     {"count", set.particles.size()},
                                     {"base_m", set.base_m},
                                     {"top_m", set.top_m},
                                     {"shape", particle_shape_name(set.shape)},
                                     {"detail", set.detail},
                                     {"hash", hex64(fnv1a(array.data))},
                                     {"source", {{"name", set.source}, {"parameters", parameters}}}};
  if (!coarser.empty()) description["coarser"] = coarser;
  const std::string text = description.dump(2) + '\n';
  return write_file(json_path, std::as_bytes(std::span(text)));
}

// depth: 0, or 1 for a coarser level of another set.
static Result<ParticleSet> load_level(const std::filesystem::path& json_path, int depth) {
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
  give_particles_base_and_top(set);
  const std::array further = {&SetParticle::base_m, &SetParticle::top_m, &SetParticle::seed};
  for (std::size_t i = 0; i < set.particles.size(); ++i) {
    const std::byte* row = &array->data[i * columns * sizeof(float)];
    std::memcpy(static_cast<void*>(&set.particles[i]), row, kColumns * sizeof(float));
    for (std::size_t k = 0; k < further.size(); ++k)
      if (const std::optional<std::size_t> column = description->column(kFurtherNames[k]))
        std::memcpy(&(set.particles[i].*further[k]), row + *column * sizeof(float), sizeof(float));
  }
  for (const std::string& name : description->coarser) {
    if (depth > 0) return Error{file + ": coarser: it is a coarser level itself; accepted: none"};
    Result<ParticleSet> level = load_level(json_path.parent_path() / name, depth + 1);
    if (!level) return Error{concat(file, ": coarser: ", level.error().message)};
    set.coarser.push_back(std::move(*level));
  }
  if (auto ok = check_particle_set(set); !ok) return Error{file + ": " + ok.error().message};
  return set;
}

Result<ParticleSet> load_particle_set(const std::filesystem::path& json_path) { return load_level(json_path, 0); }

}  // namespace nephele
