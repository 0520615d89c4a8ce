#include "lut/study/paper_tables.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>

#include "engine/check.h"
#include "engine/parallel.h"
#include "engine/phase_function.h"
#include "lut/bake.h"
#include "lut/oracles.h"
#include "lut/sphere_solver.h"
#include "lut/table_metadata.h"
#include "shared/paper_axes.h"

namespace nephele {

using json = nlohmann::json;
using shared::vec3;
using shared::vec4;

namespace {

constexpr const char* kOpticalDepth = "paper_optical_depth";
constexpr const char* kSingleScattering = "paper_single_scattering";
constexpr const char* kMultipleScattering = "paper_multiple_scattering";

float vertex(std::uint32_t index, std::uint32_t count) {
  return static_cast<float>(index) / static_cast<float>(count - 1);
}

std::vector<std::size_t> array_shape(const PaperSize& size, std::size_t channels) {
  return {std::size_t{size[3]} * size[2], size[1], size[0], channels};
}

NpyArray empty_array(ElementType type, const PaperSize& size, std::size_t channels) {
  NpyArray array;
  array.type = type;
  array.shape = array_shape(size, channels);
  array.data.resize(array.count() * element_bytes(type));
  return array;
}

NpyArray optical_depth_array(const PaperParameters& parameters, const std::function<void(double)>& progress) {
  const ReferenceParticle particle(parameters.particle_seed);
  const PaperSize& n = parameters.optical_depth_size;
  NpyArray array = empty_array(ElementType::uint8, n, 2);
  const auto byte = [](float x) { return static_cast<std::byte>(std::lround(255 * std::clamp(x, 0.0f, 1.0f))); };
  std::atomic<int> done{0};
  const int planes = static_cast<int>(n[3] * n[2]);
  parallel_for(planes, [&](int z) {
    std::byte* out = &array.data[std::size_t{2} * n[0] * n[1] * static_cast<std::size_t>(z)];
    const std::uint32_t w = static_cast<std::uint32_t>(z) / n[2], v = static_cast<std::uint32_t>(z) % n[2];
    for (std::uint32_t y = 0; y < n[1]; ++y) {
      for (std::uint32_t x = 0; x < n[0]; ++x, out += 2) {
        vec3 entry, exit;
        shared::paper_chord_from_axes(vec4(vertex(x, n[0]), vertex(y, n[1]), vertex(v, n[2]), vertex(w, n[3])), entry,
                                      exit);
        const ChordStatistics chord = particle.chord(entry, exit);
        out[0] = byte(chord.mean);
        out[1] = byte(chord.first);
      }
    }
    if (const int count = done.fetch_add(1) + 1; count % 16 == 0) progress(static_cast<double>(count) / planes);
  });
  return array;
}

struct Vertex {
  double c, h, x;  // x: cosine of the azimuth
};

// Fills one density's slice from a function of the vertex; the azimuth's halves mirror each other.
void fill_density(NpyArray& array, const PaperSize& n, std::uint32_t slice,
                  const std::function<double(const Vertex&)>& radiance) {
  parallel_for(static_cast<int>(n[2]), [&](int v) {
    const double h = std::cos(0.5 * std::acos(-1.0) * vertex(static_cast<std::uint32_t>(v), n[2]));
    for (std::uint32_t x = 0; x < n[0]; ++x) {
      const double c = std::cos(std::acos(-1.0) * vertex(x, n[0]));
      for (std::uint32_t y = 0; 2 * y <= n[1]; ++y) {
        const double value = radiance({c, std::max(0.0, h), std::cos(2 * std::acos(-1.0) * vertex(y, n[1]))});
        const auto half = static_cast<std::uint16_t>(glm::packHalf2x16({static_cast<float>(value), 0}) & 0xffffu);
        for (const std::uint32_t row : {y, n[1] - 1 - y}) {
          const std::size_t at = ((std::size_t{slice} * n[2] + static_cast<std::size_t>(v)) * n[1] + row) * n[0] + x;
          array.data[2 * at] = static_cast<std::byte>(half & 255);
          array.data[2 * at + 1] = static_cast<std::byte>(half >> 8);
        }
      }
    }
  });
}

NpyArray single_scattering_array(const PaperParameters& parameters, const std::function<void(double)>& progress) {
  const PaperSize& n = parameters.scattering_size;
  NpyArray array = empty_array(ElementType::float16, n, 1);
  for (std::uint32_t slice = 0; slice < n[3]; ++slice) {
    const double sigma = shared::paper_optical_radius_from_axis(vertex(slice, n[3]));
    fill_density(array, n, slice, [&](const Vertex& at) {
      const double mu = at.c * at.h + std::sqrt(std::max(0.0, (1 - at.c * at.c) * (1 - at.h * at.h))) * at.x;
      return at.h > 0 ? exact_single_scattering({at.c, at.h, mu}, sigma) : 0.0;
    });
    progress((slice + 1.0) / n[3]);
  }
  return array;
}

NpyArray multiple_scattering_array(const PaperParameters& parameters, const std::function<void(double)>& progress) {
  const PaperSize& n = parameters.scattering_size;
  NpyArray array = empty_array(ElementType::float16, n, 1);
  for (std::uint32_t slice = 0; slice < n[3]; ++slice) {
    const double sigma = shared::paper_optical_radius_from_axis(vertex(slice, n[3]));
    const SphereProblem problem{parameters.phase_function, double{shared::kPaperGLater}, sigma,
                                double{shared::kPaperGFirst}};
    const SphereSolution orders = sum_orders(problem, sphere_grid(sigma, false), shared::kPaperLastOrder);
    fill_density(array, n, slice, [&](const Vertex& at) {
      return std::max(0.0, orders.chord_source(at.c, at.h, at.x) * -std::expm1(-2 * sigma * at.h));
    });
    progress((slice + 1.0) / n[3]);
  }
  return array;
}

json optical_depth_parameters(const PaperParameters& p) {
  return {{"size", p.optical_depth_size}, {"particle_seed", p.particle_seed}};
}

json scattering_parameters(const PaperParameters& p) {
  return {{"size", p.scattering_size},
          {"phase_function", phase_function_name(PhaseFunction{p.phase_function})},
          {"g_first", 0.9},
          {"g_later", 0.7},
          {"last_order", shared::kPaperLastOrder}};
}

Table describe(const char* name, NpyArray array, const json& parameters, const json& axes) {
  Table table;
  table.name = name;
  json metadata = table_metadata(name, parameters, array);
  metadata["axes"] = axes;
  table.metadata = metadata.dump(2) + "\n";
  table.array = std::move(array);
  return table;
}

json axis(const char* name, const char* meaning) { return {{"name", name}, {"meaning", meaning}}; }

PaperSize read_size(const json& parameters) { return parameters.at("size").get<PaperSize>(); }

}  // namespace

Result<void> PaperParameters::validate() const {
  if (phase_function > 1) return Error{concat("phase_function: ", phase_function, ", accepted are 0 to 1")};
  for (const PaperSize& size : {optical_depth_size, scattering_size})
    for (const std::uint32_t count : size)
      if (count < 2 || count > 64) return Error{concat("size: ", count, ", accepted are 2 to 64 along each axis")};
  return {};
}

PaperTables bake_paper_tables(const PaperParameters& parameters, const ProgressCallback& progress) {
  std::mutex mutex;
  const auto show = [&](const char* stage) {
    return [&progress, &mutex, stage](double fraction) {
      const std::scoped_lock lock(mutex);
      if (progress) progress(stage, fraction);
    };
  };
  PaperTables tables{parameters, {}, {}, {}};
  tables.optical_depth = describe(
      kOpticalDepth, optical_depth_array(parameters, show(kOpticalDepth)), optical_depth_parameters(parameters),
      {axis("view", "view_zenith * size[2] + view_azimuth, row-major; zenith 0 .. pi/2, azimuth 0 .. 2 pi"),
       axis("entry_zenith", "0 .. pi"), axis("entry_azimuth", "0 .. 2 pi"),
       axis("channel", "mean extinction / peak; fraction of the chord before first matter")});
  const json axes{
      axis("density_view_zenith",
           "density * size[2] + view_zenith, row-major; optical radius 12.88 * 2^(-4 .. 3), zenith 0 .. pi/2"),
      axis("view_azimuth", "0 .. 2 pi"), axis("entry_zenith", "from the light's direction, 0 .. pi"),
      axis("channel", "radiance per unit irradiance; single scattering without its phase function")};
  tables.single_scattering = describe(kSingleScattering, single_scattering_array(parameters, show(kSingleScattering)),
                                      scattering_parameters(parameters), axes);
  tables.multiple_scattering =
      describe(kMultipleScattering, multiple_scattering_array(parameters, show(kMultipleScattering)),
               scattering_parameters(parameters), axes);
  return tables;
}

Result<void> save_paper_tables(const std::filesystem::path& dir, PaperTables& tables) {
  for (Table* table : {&tables.optical_depth, &tables.single_scattering, &tables.multiple_scattering}) {
    if (auto saved = save_table(dir, table->name, *table); !saved) return saved;
    table->json_path = dir / (table->name + ".json");
  }
  return {};
}

Result<PaperTables> load_paper_tables(const std::filesystem::path& dir) {
  PaperTables tables;
  for (const auto& [name, table] : {std::pair{kOpticalDepth, &tables.optical_depth},
                                    {kSingleScattering, &tables.single_scattering},
                                    {kMultipleScattering, &tables.multiple_scattering}}) {
    Result<Table> loaded = load_table(dir / (std::string(name) + ".json"));
    if (!loaded) return loaded.error();
    *table = std::move(*loaded);
  }
  PaperParameters& p = tables.parameters;
  const auto parameters_of = [](const Table& table) { return json::parse(table.metadata).at("parameters"); };
  try {
    p.optical_depth_size = read_size(parameters_of(tables.optical_depth));
    parameters_of(tables.optical_depth).at("particle_seed").get_to(p.particle_seed);
    p.scattering_size = read_size(parameters_of(tables.multiple_scattering));
    const std::string phase = parameters_of(tables.multiple_scattering).at("phase_function").get<std::string>();
    p.phase_function = static_cast<std::uint32_t>(phase_function_named(phase).value_or(PhaseFunction{}));
  } catch (const json::exception& failure) {
    return Error{dir.string() + ": parameters: " + failure.what()};
  }
  if (const auto valid = p.validate(); !valid) return Error{dir.string() + ": " + valid.error().message};
  const json wanted = scattering_parameters(p);
  const auto scattering = array_shape(p.scattering_size, 1);
  if (auto ok = check_table(tables.optical_depth, kOpticalDepth, optical_depth_parameters(p), ElementType::uint8,
                            array_shape(p.optical_depth_size, 2));
      !ok)
    return ok.error();
  if (auto ok = check_table(tables.single_scattering, kSingleScattering, wanted, ElementType::float16, scattering); !ok)
    return ok.error();
  if (auto ok = check_table(tables.multiple_scattering, kMultipleScattering, wanted, ElementType::float16, scattering);
      !ok)
    return ok.error();
  return tables;
}

shared::vec4 as_vector(const PaperSize& size) { return vec4(size[0], size[1], size[2], size[3]); }

shared::vec2 fetch_paper(const FloatTexture& table, const vec4& axes, const vec4& size) {
  const auto at = shared::paper_coordinates(axes, size);
  const vec4 a = table.sample(vec3(at.xy, at.z0)), b = table.sample(vec3(at.xy, at.z1));
  return shared::vec2(a.x + at.weight * (b.x - a.x), a.y + at.weight * (b.y - a.y));
}

}  // namespace nephele
