// nephele grow: clouds from generators, as particle sets.
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/atomic_file.h"
#include "engine/json_reader.h"
#include "engine/particle_set.h"
#include "tools/checked_options.h"
#include "tools/clouds/coarser_levels.h"
#include "tools/clouds/grow_gaussian.h"
#include "tools/clouds/grow_l_system.h"
#include "tools/clouds/grow_mesh.h"
#include "tools/clouds/grow_metaballs.h"
#include "tools/command.h"
#include "tools/options.h"

namespace nephele::tools {
namespace {

using namespace nephele::clouds;

struct GrowOptions {
  std::string generator, parameters, mesh, out;
  std::optional<std::uint32_t> seed;
};

// The generator's parameters: its defaults, changed by the file and then by --seed.
template <class Parameters, class Read>
Result<Parameters> read_parameters(const GrowOptions& options, Read read) {
  Parameters parameters;
  if (!options.parameters.empty()) {
    const Result<std::string> text = read_text_file(options.parameters);
    if (!text) return text.error();
    const Result<nlohmann::json> document = parse_json(*text, options.parameters);
    if (!document) return document.error();
    JsonReader reader(options.parameters);
    JsonObject root = reader.root(*document);
    read(root, parameters);
    root.finish();
    if (reader.error()) return *reader.error();
  }
  if (options.seed) parameters.seed = *options.seed;
  return parameters;
}

template <class Parameters, class Read, class Grow>
Result<ParticleSet> grow_with(const GrowOptions& options, Read read, Grow grow) {
  const Result<Parameters> parameters = read_parameters<Parameters>(options, read);
  if (!parameters) return parameters.error();
  Result<ParticleSet> set = grow(*parameters);
  if (!set && !options.parameters.empty()) return Error{options.parameters + ": " + set.error().message};
  return set;
}

Result<ParticleSet> grow(const GrowOptions& options) {
  if (options.generator == "l_system") return grow_with<LSystemParameters>(options, read_l_system, grow_l_system);
  if (options.generator == "metaballs") return grow_with<MetaballParameters>(options, read_metaballs, grow_metaballs);
  if (options.generator == "mesh") {
    if (options.mesh.empty()) return Error{"--mesh is missing; it names the mesh to fill, .obj or .ply"};
    const Result<MeshParameters> parameters = read_parameters<MeshParameters>(options, read_mesh_parameters);
    if (!parameters) return parameters.error();
    const Result<std::vector<Triangle>> triangles = read_mesh(options.mesh);
    if (!triangles) return triangles.error();
    Result<ParticleSet> set = grow_mesh(*parameters, *triangles);
    if (!set) return Error{options.mesh + ": " + set.error().message};
    return set;
  }
  return grow_with<GaussianParameters>(options, read_gaussian, grow_gaussian);
}

Result<void> run_grow(const GrowOptions& options) {
  if (options.out.empty()) return Error{"--out is missing; it names the particle set, NAME.json"};
  if (!has_extension(options.out, ".json"))
    return Error{"--out is " + options.out + "; accepted: a name that ends in .json"};
  if (auto ok =
          check_different({{"--parameters", options.parameters}, {"--mesh", options.mesh}, {"--out", options.out}}, 1);
      !ok)
    return ok;
  if (!options.mesh.empty() && options.generator != "mesh")
    return Error{"--mesh: accepted with the generator mesh, not with " + options.generator};
  if (auto writable = check_writable(options.out); !writable) return writable;
  Result<ParticleSet> set = grow(options);
  if (!set) return set.error();
  if (auto ok = add_coarser_levels(*set); !ok) return ok;
  return save_particle_set(options.out, *set);
}

}  // namespace

Command add_grow_command(CLI::App& program) {
  CLI::App* app = program.add_subcommand("grow", "Make a cloud with a generator and write it as a particle set");
  const auto options = std::make_shared<GrowOptions>();
  app->footer("Every parameter of every generator, with unit, range and default: docs/generators.md");
  add_checked_option(*app, "generator", options->generator, "What makes the cloud",
                     OneOfNames{"gaussian", "l_system", "metaballs", "mesh"})
      ->required();
  app->add_option("--parameters", options->parameters, "The generator's parameters: .json; without it, the defaults")
      ->type_name("FILE");
  app->add_option("--mesh", options->mesh, "The mesh to fill: .obj or .ply")->type_name("FILE");
  add_checked_option(*app, "--seed", options->seed, "Another number, another cloud; wins over the file's",
                     WholeNumber{0, 4294967295});
  app->add_option("--out", options->out, "The particle set: NAME.json, with its array NAME.npy beside it")
      ->type_name("FILE");
  return {app, [options] { return run_grow(*options); }};
}

}  // namespace nephele::tools
