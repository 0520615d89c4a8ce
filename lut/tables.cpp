#include "lut/tables.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <system_error>

#include <nlohmann/json.hpp>

#include "engine/check.h"
#include "engine/json_reader.h"
#include "engine/phase_function.h"
#include "lut/bake.h"
#include "lut/near_beam.h"
#include "lut/oracles.h"
#include "lut/table_errors.h"
#include "lut/table_metadata.h"
#include "lut_hash.h"
#include "shared/near_beam_axes.h"
#include "shared/table_axes.h"

namespace nephele {

namespace {

using json = nlohmann::json;

constexpr int kFormatVersion = 2;
constexpr const char* kOpticalDepth = "optical_depth";
constexpr const char* kMultipleScattering = "multiple_scattering";
constexpr const char* kNearBeam = "near_beam";
constexpr std::uint32_t kNearBeamDepths = 128, kNearBeamAngles = 64;
constexpr int kErrorChords = 2048;  // for the error that every bake writes down

json optical_depth_parameters(const TableParameters& p) {
  return {{"size", p.optical_depth_size}, {"particle_seed", p.particle_seed}};
}

json multiple_scattering_parameters(const TableParameters& p) {
  return {{"phase_function", phase_function_name(PhaseFunction{p.phase_function})},
          {"g", p.g_multiple},
          {"size_cosine", p.scattering_cosines},
          {"size_chord", p.scattering_chords},
          {"size_density", p.scattering_densities},
          {"coarse_solver", p.coarse_solver},
          {"residual", p.residual}};
}

json near_beam_parameters(const TableParameters& p) {
  return {{"phase_function", phase_function_name(PhaseFunction{p.phase_function})}, {"g", p.g_multiple}};
}

std::string cache_stem(const char* name, const json& parameters) {
  const std::string key = json{{"version", kFormatVersion}, {"generator", kLutHash}, {"parameters", parameters}}.dump();
  return std::string(name) + "-" + hex64(fnv1a(std::as_bytes(std::span(key))));
}

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

void warn_on_stderr(const std::string& line) { std::fprintf(stderr, "nephele: %s\n", line.c_str()); }

// Fails when the metadata was tampered with.
std::optional<float> mean_fill_of(const Table& table) {
  const json metadata = json::parse(table.metadata, nullptr, false);
  if (!metadata.contains("mean_fill") || !metadata["mean_fill"].is_number()) return std::nullopt;
  return metadata["mean_fill"].get<float>();
}

// The cached table when it is there and is what `parameters` ask for.
Result<Table> load_cached(const std::filesystem::path& json_path, const char* name, const json& parameters,
                          const std::vector<std::size_t>& shape) {
  Result<Table> table = load_table(json_path);
  if (!table) return table;
  if (Result<void> checked = check_table(*table, name, parameters, ElementType::float16, shape); !checked)
    return checked.error();
  return table;
}

std::vector<std::size_t> optical_depth_shape(const TableParameters& p) {
  const std::size_t n = p.optical_depth_size;
  return {n * n, n, n, 2};
}

std::vector<std::size_t> multiple_scattering_shape(const TableParameters& p) {
  return {p.scattering_densities, p.scattering_chords, p.scattering_cosines, 4};
}

std::vector<std::size_t> near_beam_shape() { return {1, kNearBeamAngles, kNearBeamDepths, 1}; }

// Back from the first two tables' metadata; throws json::exception where a field is missing or of another type.
TableParameters stored_parameters(const json& optical_depth, const json& multiple_scattering) {
  TableParameters p;
  optical_depth.at("size").get_to(p.optical_depth_size);
  optical_depth.at("particle_seed").get_to(p.particle_seed);
  // An unknown name reads as hg: then these parameters are not the file's, which check_table finds.
  p.phase_function = static_cast<std::uint32_t>(
      phase_function_named(multiple_scattering.at("phase_function").get<std::string>()).value_or(PhaseFunction{}));
  multiple_scattering.at("g").get_to(p.g_multiple);
  p.g_single = p.g_multiple;
  multiple_scattering.at("size_cosine").get_to(p.scattering_cosines);
  multiple_scattering.at("size_chord").get_to(p.scattering_chords);
  multiple_scattering.at("size_density").get_to(p.scattering_densities);
  multiple_scattering.at("coarse_solver").get_to(p.coarse_solver);
  multiple_scattering.at("residual").get_to(p.residual);
  return p;
}

template <class Bake>
Table load_or_bake_one(const std::filesystem::path& dir, const char* name, const json& parameters,
                       const std::vector<std::size_t>& shape, const WarningCallback& warn, Bake&& bake) {
  const std::string stem = cache_stem(name, parameters);
  const std::filesystem::path json_path = dir / (stem + ".json");
  std::error_code ignored;
  if (std::filesystem::exists(json_path, ignored)) {
    Result<Table> cached = load_cached(json_path, name, parameters, shape);
    if (cached) return std::move(*cached);
    warn(cached.error().message + "; the table is baked again");
  }
  Table table = bake();
  table.json_path = json_path;
  if (Result<void> saved = save_table(dir, stem, table); !saved)
    warn(saved.error().message + "; the table is not cached");
  return table;
}

}  // namespace

json table_metadata(const char* name, const json& parameters, const NpyArray& array) {
  return {{"format", "nephele table"}, {"version", kFormatVersion},  {"table", name},
          {"generator", kLutHash},     {"parameters", parameters},   {"dtype", npy_descriptor(array.type)},
          {"shape", array.shape},      {"bytes", array.data.size()}, {"data_fnv1a", hex64(fnv1a(array.data))}};
}

Result<void> check_table(const Table& table, const char* name, const json& parameters, ElementType type,
                         const std::vector<std::size_t>& shape) {
  const json metadata = json::parse(table.metadata);
  const auto bad = [&](const std::string& what) { return Error{table.json_path.string() + ": " + what}; };
  if (metadata["table"] != name) return bad("table: " + metadata["table"].dump() + ", expected " + name);
  if (metadata["generator"] != kLutHash) return bad("generator: made by another version");
  if (metadata["parameters"] != parameters) return bad("parameters: not those asked for");
  if (table.array.type != type || table.array.shape != shape) return bad("shape: not what the parameters ask for");
  if (std::string_view(name) == kOpticalDepth && !mean_fill_of(table)) return bad("mean_fill: a number is expected");
  return {};
}

Result<TableParameters> TableParameters::preset(const std::string& name) {
  TableParameters parameters;
  if (name == "default") return parameters;
  if (name == "fast") {
    parameters.scattering_cosines = 24;
    parameters.scattering_chords = 12;
    parameters.coarse_solver = true;
    return parameters;
  }
  return Error{"preset: '" + name + "', accepted are default and fast"};
}

Result<void> TableParameters::validate() const {
  const auto outside = [](const char* field, auto value, auto low, auto high) {
    return Error{concat(field, ": ", value, ", accepted are ", low, " to ", high)};
  };
  if (phase_function > 1) return outside("phase_function", phase_function, 0, 1);
  if (!(std::abs(g_single) <= kMaxAsymmetry)) return outside("g_single", g_single, -kMaxAsymmetry, kMaxAsymmetry);
  if (!(std::abs(g_multiple) <= kMaxAsymmetry)) return outside("g_multiple", g_multiple, -kMaxAsymmetry, kMaxAsymmetry);
  if (optical_depth_size < 4 || optical_depth_size > 64)
    return outside("optical_depth_size", optical_depth_size, 4, 64);
  if (scattering_cosines < 4 || scattering_cosines > 128)
    return outside("scattering_cosines", scattering_cosines, 4, 128);
  if (scattering_chords < 3 || scattering_chords > 128) return outside("scattering_chords", scattering_chords, 3, 128);
  if (scattering_densities < 4 || scattering_densities > 64)
    return outside("scattering_densities", scattering_densities, 4, 64);
  if (!(residual >= kMinResidual && residual <= kMaxResidual))
    return outside("residual", residual, kMinResidual, kMaxResidual);
  return {};
}

std::filesystem::path default_cache_dir() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache && *cache) return std::filesystem::path(cache) / "nephele";
  const char* home = std::getenv("HOME");
  if (home && *home) return std::filesystem::path(home) / ".cache" / "nephele";
  std::error_code ignored;
  return std::filesystem::temp_directory_path(ignored) / "nephele";
}

Table bake_optical_depth(const TableParameters& parameters, const ProgressCallback& progress) {
  const ReferenceParticle particle(parameters.particle_seed);
  Table table;
  table.name = kOpticalDepth;
  std::mutex mutex;
  table.array =
      bake_optical_depth_array(particle, static_cast<int>(parameters.optical_depth_size), [&](double fraction) {
        const std::scoped_lock lock(mutex);
        if (progress) progress(kOpticalDepth, fraction);
      });
  json metadata = table_metadata(kOpticalDepth, optical_depth_parameters(parameters), table.array);
  metadata["axes"] = {
      {{"name", "entry"}, {"meaning", "entry point on an octahedral map, row-major: v * N + u"}},
      {{"name", "exit_v"}, {"meaning", "exit point, octahedral v"}, {"range", {0, 1}}},
      {{"name", "exit_u"}, {"meaning", "exit point, octahedral u"}, {"range", {0, 1}}},
      {{"name", "channel"}, {"meaning", "root of mean extinction / peak; fraction of the chord before first matter"}}};
  metadata["mean_fill"] = particle.mean_fill();
  metadata["error"] = {
      {"transmittance_rms_at_peak_optical_radius_8",
       transmittance_error(FloatTexture(table), kErrorChords, [&](const shared::vec3& entry, const shared::vec3& exit) {
         return exact_mean_density(entry, exit, parameters.particle_seed);
       }).rms}};
  table.metadata = metadata.dump(2) + "\n";
  return table;
}

Table bake_multiple_scattering(const TableParameters& parameters, const ProgressCallback& progress) {
  Table table;
  table.name = kMultipleScattering;
  const ScatteringBake bake{parameters.phase_function,
                            parameters.g_multiple,
                            static_cast<int>(parameters.scattering_cosines),
                            static_cast<int>(parameters.scattering_chords),
                            static_cast<int>(parameters.scattering_densities),
                            parameters.coarse_solver,
                            parameters.residual};
  table.array = bake_multiple_scattering_array(bake, [&](double fraction) {
    if (progress) progress(kMultipleScattering, fraction);
  });
  json metadata = table_metadata(kMultipleScattering, multiple_scattering_parameters(parameters), table.array);
  const double middle = shared::density_axis_middle(static_cast<float>(parameters.g_multiple));
  metadata["axes"] = {{{"name", "density"},
                       {"meaning", "sigma / (sigma + middle), sigma = optical radius"},
                       {"middle", middle},
                       {"range", {0, 1}}},
                      {{"name", "chord"}, {"meaning", "h = n.omega, half the chord"}, {"range", {0, 1}}},
                      {{"name", "cosine"}, {"meaning", "0.5 + 0.5 sign(c) |c|^0.7, c = n.s"}, {"range", {0, 1}}},
                      {{"name", "coefficient"}, {"meaning", "of the cubic in the azimuth's cosine, constant first"}}};
  const FloatTexture texture(table);
  for (const double sigma : {0.1, 1.0, 4.0, 16.0, 100.0})
    metadata["error"]["energy"].push_back(
        {{"optical_radius", sigma},
         {"relative", energy_error(texture, parameters.phase_function, parameters.g_multiple, sigma)}});
  table.metadata = metadata.dump(2) + "\n";
  return table;
}

Table bake_near_beam(const TableParameters& parameters) {
  Table table;
  table.name = kNearBeam;
  table.array =
      bake_near_beam_array(parameters.phase_function, parameters.g_multiple, kNearBeamDepths, kNearBeamAngles);
  json metadata = table_metadata(kNearBeam, near_beam_parameters(parameters), table.array);
  metadata["axes"] = {
      {{"name", "slice"}, {"meaning", "one"}},
      {{"name", "angle"}, {"meaning", "root of the sine of half the scattering angle"}, {"range", {0, 1}}},
      {{"name", "depth"},
       {"meaning", "log(1 + tau) / log(1 + deepest), tau = optical depth towards the sun"},
       {"deepest", shared::kNearBeamDeepest},
       {"range", {0, 1}}},
      {{"name", "channel"}, {"meaning", "K, per sr and unit irradiance"}}};
  metadata["error"] = {
      {"rms_over_rms", near_beam_error(FloatTexture(table), parameters.phase_function, parameters.g_multiple)}};
  table.metadata = metadata.dump(2) + "\n";
  return table;
}

Result<void> save_table(const std::filesystem::path& dir, const std::string& stem, const Table& table) {
  std::error_code failed;
  std::filesystem::create_directories(dir, failed);
  if (failed) return Error{dir.string() + ": cannot be created: " + failed.message()};
  if (Result<void> written = write_npy(dir / (stem + ".npy"), table.array); !written) return written;
  return write_file(dir / (stem + ".json"), bytes_of(table.metadata));
}

Result<void> save_metadata(const Table& table) { return write_file(table.json_path, bytes_of(table.metadata)); }

Result<Table> load_table(const std::filesystem::path& json_path) {
  Result<std::vector<std::byte>> text = read_file(json_path, std::size_t{1} << 20);
  if (!text) return text.error();
  Table table;
  table.metadata.assign(reinterpret_cast<const char*>(text->data()), text->size());
  const Result<json> parsed = parse_json(table.metadata, json_path.string());
  if (!parsed) return parsed.error();
  const json& metadata = *parsed;
  const auto bad = [&](const std::string& what) { return Error{json_path.string() + ": " + what}; };
  if (!metadata.is_object()) return bad("not a JSON object");
  for (const char* field : {"format", "table", "generator", "dtype", "data_fnv1a"})
    if (!metadata.contains(field) || !metadata[field].is_string())
      return bad(std::string(field) + ": a string is expected");
  for (const char* field : {"version", "bytes"})
    if (!metadata.contains(field) || !metadata[field].is_number_unsigned())
      return bad(std::string(field) + ": a number is expected");
  if (!metadata.contains("parameters") || !metadata["parameters"].is_object())
    return bad("parameters: an object is expected");
  if (metadata["format"] != "nephele table") return bad("format: 'nephele table' is expected");
  if (metadata["version"] != kFormatVersion) return bad(concat("version: ", kFormatVersion, " is expected"));

  Result<NpyArray> array = read_npy(std::filesystem::path(json_path).replace_extension(".npy"));
  if (!array) return array.error();
  if (metadata["dtype"] != npy_descriptor(array->type)) return bad("dtype: differs from the array's");
  if (!metadata.contains("shape") || metadata["shape"] != json(array->shape))
    return bad("shape: differs from the array's");
  if (array->shape.size() != 4) return bad("shape: four axes are expected");
  if (metadata["bytes"] != array->data.size()) return bad("bytes: differs from the array's");
  if (metadata["data_fnv1a"] != hex64(fnv1a(array->data))) return bad("data_fnv1a: the array's data is damaged");
  table.name = metadata["table"];
  table.json_path = json_path;
  table.array = std::move(*array);
  return table;
}

Result<Tables> load_or_bake(const TableParameters& parameters, const std::filesystem::path& cache_dir,
                            const ProgressCallback& progress, const WarningCallback& warn) {
  if (Result<void> valid = parameters.validate(); !valid) return valid.error();
  const WarningCallback say = warn ? warn : warn_on_stderr;
  Tables tables;
  tables.parameters = parameters;
  tables.optical_depth =
      load_or_bake_one(cache_dir, kOpticalDepth, optical_depth_parameters(parameters), optical_depth_shape(parameters),
                       say, [&] { return bake_optical_depth(parameters, progress); });
  tables.multiple_scattering = load_or_bake_one(
      cache_dir, kMultipleScattering, multiple_scattering_parameters(parameters), multiple_scattering_shape(parameters),
      say, [&] { return bake_multiple_scattering(parameters, progress); });
  tables.near_beam = load_or_bake_one(cache_dir, kNearBeam, near_beam_parameters(parameters), near_beam_shape(), say,
                                      [&] { return bake_near_beam(parameters); });
  tables.mean_fill = *mean_fill_of(tables.optical_depth);
  return tables;
}

Result<Tables> load_tables(const std::filesystem::path& dir) {
  const auto path = [&](const char* name) { return dir / (std::string(name) + ".json"); };
  Result<Table> optical_depth = load_table(path(kOpticalDepth));
  if (!optical_depth) return optical_depth.error();
  Result<Table> multiple_scattering = load_table(path(kMultipleScattering));
  if (!multiple_scattering) return multiple_scattering.error();
  Result<Table> near_beam = load_table(path(kNearBeam));
  if (!near_beam) return near_beam.error();

  Tables tables;
  try {
    tables.parameters = stored_parameters(json::parse(optical_depth->metadata).at("parameters"),
                                          json::parse(multiple_scattering->metadata).at("parameters"));
  } catch (const json::exception& failure) {
    return Error{dir.string() + ": parameters: " + failure.what()};
  }
  const TableParameters& p = tables.parameters;
  if (Result<void> valid = p.validate(); !valid) return Error{dir.string() + ": parameters: " + valid.error().message};
  if (auto ok = check_table(*optical_depth, kOpticalDepth, optical_depth_parameters(p), ElementType::float16,
                            optical_depth_shape(p));
      !ok)
    return ok.error();
  if (auto ok = check_table(*multiple_scattering, kMultipleScattering, multiple_scattering_parameters(p),
                            ElementType::float16, multiple_scattering_shape(p));
      !ok)
    return ok.error();
  if (auto ok = check_table(*near_beam, kNearBeam, near_beam_parameters(p), ElementType::float16, near_beam_shape());
      !ok)
    return ok.error();
  tables.optical_depth = std::move(*optical_depth);
  tables.multiple_scattering = std::move(*multiple_scattering);
  tables.near_beam = std::move(*near_beam);
  tables.mean_fill = *mean_fill_of(tables.optical_depth);
  return tables;
}

Result<Tables> bake_to(const std::filesystem::path& dir, const TableParameters& parameters,
                       const ProgressCallback& progress) {
  if (Result<void> valid = parameters.validate(); !valid) return valid.error();
  Tables tables;
  tables.parameters = parameters;
  tables.optical_depth = bake_optical_depth(parameters, progress);
  tables.multiple_scattering = bake_multiple_scattering(parameters, progress);
  tables.near_beam = bake_near_beam(parameters);
  tables.mean_fill = *mean_fill_of(tables.optical_depth);
  for (Table* table : {&tables.optical_depth, &tables.multiple_scattering, &tables.near_beam}) {
    table->json_path = dir / (table->name + ".json");
    if (Result<void> saved = save_table(dir, table->name, *table); !saved) return saved.error();
  }
  return tables;
}

}  // namespace nephele
