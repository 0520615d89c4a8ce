// nephele import and export as a user runs them.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "engine/npy.h"
#include "engine/particle_set.h"
#include "tests/tool/program.h"
#include "tools/sample_volume/cumulus_volume.h"

using namespace nephele;
using namespace nephele::test;

namespace {

// The sample cumulus as an array, 2048 / n metres a voxel.
void write_cumulus(const std::string& path, std::size_t n) {
  NpyArray array{ElementType::float32, {n, n, n}, {}};
  sample::for_cumulus_voxels(n, {}, [&](std::size_t, std::size_t, std::size_t, float value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    array.data.insert(array.data.end(), bytes.begin(), bytes.end());
  });
  REQUIRE(write_npy(path, array));
}

nlohmann::json parsed(const std::string& text) {
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  REQUIRE_FALSE(json.is_discarded());
  return json;
}

void check_refused(const ProgramResult& result, const std::string& part) {
  CHECK(result.status == 2);
  CHECK(result.out.empty());
  CHECK_MESSAGE(result.err.find(part) != std::string::npos, result.err);
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
}

}  // namespace

TEST_CASE("import: a cumulus becomes a soft set with coarser levels, verified and counted") {
  const TempDirectory dir;
  write_cumulus(dir / "c.npy", 64);
  const ProgramResult run = run_program({"import", dir / "c.npy", "--voxel-m", "32", "--out", dir / "set.json",
                                         "--verify", "--stats", dir / "stats.json", "--detail", "0.3"});
  REQUIRE_MESSAGE(run.status == 0, run.err);
  const nlohmann::json verified = parsed(run.out), stats = parsed(read_file(dir / "stats.json"));
  CHECK(verified["rms_transmittance"].get<double>() < 0.03);
  CHECK(std::abs(verified["mass_ratio"].get<double>() - 1.0) < 1e-3);
  for (const nlohmann::json& level : verified["coarser"])
    CHECK(std::abs(level["mass_ratio"].get<double>() - 1.0) < 1e-3);
  const Result<ParticleSet> set = load_particle_set(dir / "set.json");
  if (!set) FAIL(set.error().message);
  CHECK(set->shape == ParticleShape::soft);
  CHECK(set->detail == 0.3f);
  CHECK(set->source == "import");
  CHECK(set->coarser.size() == verified["coarser"].size());
  CHECK(stats["particles"].get<std::size_t>() == set->particles.size());
  CHECK(stats["voxels"].get<std::size_t>() == 64u * 64u * 64u);
}

TEST_CASE("import: --count and --error choose a spacing") {
  const TempDirectory dir;
  write_cumulus(dir / "c.npy", 48);
  const auto particles = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"import", dir / "c.npy", "--voxel-m", "42.67", "--out", dir / "set.json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult run = run_program(arguments);
    REQUIRE_MESSAGE(run.status == 0, run.err);
    return load_particle_set(dir / "set.json")->particles.size();
  };
  const std::size_t counted = particles({"--count", "300"});
  CHECK(counted <= 300);
  CHECK(counted > 200);  // the closest: spacings a hundredth apart differ by a few in a hundred particles
  CHECK(particles({"--error", "0.02"}) > particles({"--error", "0.06"}));
  check_refused(
      run_program({"import", dir / "c.npy", "--voxel-m", "42.67", "--out", dir / "x.json", "--error", "0.0001"}),
      "--error is 0.0001; no spacing");
}

TEST_CASE("export: what import made goes through every format and comes back") {
  const TempDirectory dir;
  write_cumulus(dir / "c.npy", 48);
  const ProgramResult first = run_program(
      {"import", dir / "c.npy", "--voxel-m", "42.67", "--out", dir / "set.json", "--stats", dir / "stats.json"});
  REQUIRE_MESSAGE(first.status == 0, first.err);
  const double mass = parsed(read_file(dir / "stats.json"))["mass_m2"];
  for (const std::string name : {"v.vdb", "v.nc", "v.npy", "slices"}) {
    const ProgramResult out =
        run_program({"export", "--set", dir / "set.json", "--voxel-m", "30", "--out", dir / name});
    REQUIRE_MESSAGE(out.status == 0, out.err);
    std::vector<std::string> arguments{"import",           dir / name, "--out",
                                       dir / "again.json", "--stats",  dir / "again_stats.json"};
    if (name == "v.npy") arguments.insert(arguments.end(), {"--voxel-m", "30"});
    const ProgramResult back = run_program(arguments);
    REQUIRE_MESSAGE(back.status == 0, back.err);
    // Half a per cent is promised, and the base cuts some.
    const double again = parsed(read_file(dir / "again_stats.json"))["mass_m2"];
    CHECK_MESSAGE(std::abs(again / mass - 1.0) < 0.01, name);
  }
  const ProgramResult points = run_program({"export", "--set", dir / "set.json", "--out", dir / "v.ply"});
  REQUIRE_MESSAGE(points.status == 0, points.err);
  CHECK(read_file(dir / "v.ply").starts_with("ply\nformat binary_little_endian 1.0\n"));
}

TEST_CASE("import and export: bad input is one line, status 2, and nothing is written") {
  const TempDirectory dir;
  write_cumulus(dir / "c.npy", 16);
  const auto before = dir.entries();
  const std::string c = dir / "c.npy", out = dir / "o.json";
  check_refused(run_program({"import", dir / "absent.vdb", "--out", out}), "absent.vdb: there is no such file");
  check_refused(run_program({"import", c, "--out", out}), "--voxel-m is missing");
  check_refused(run_program({"import", c, "--voxel-m", "0", "--out", out}), "--voxel-m is 0; accepted: a number from");
  check_refused(run_program({"import", c, "--voxel-m", "10,20", "--out", out}), "--voxel-m is");
  check_refused(run_program({"import", c, "--voxel-m", "10"}), "give --out");
  check_refused(run_program({"import", c, "--voxel-m", "10", "--out", dir / "o.npy"}), "a name ending in .json");
  check_refused(run_program({"import", c, "--voxel-m", "10", "--out", dir / "c.json"}), "are both");
  check_refused(run_program({"import", c, "--voxel-m", "10", "--out", out, "--time", "all"}), "no steps of time");
  check_refused(run_program({"import", c, "--voxel-m", "10", "--out", out, "--time", "soon"}), "--time is \"soon\"");
  check_refused(run_program({"import", c, "--voxel-m", "10", "--out", out, "--spacing", "2", "--count", "9"}),
                "one at a time");
  check_refused(run_program({"import", c, "--voxel-m", "10", "--out", out, "--grid", "a"}),
                "--grid is accepted for .vdb");
  check_refused(run_program({"export", "--set", dir / "absent.json", "--voxel-m", "10", "--out", dir / "v.vdb"}),
                "absent.json");
  check_refused(run_program({"export", "--voxel-m", "10", "--out", dir / "v.vdb"}), "--scene FILE or from --set");
  check_refused(run_program({"export", "--scene", NEPHELE_SOURCE_DIR "/tools/scenes/fair_weather.json", "--voxel-m",
                             "10", "--out", dir / "v.vdb"}),
                "it has a field of clouds");
  CHECK(dir.entries() == before);
}

TEST_CASE("export: a scene's listed particles") {
  const TempDirectory dir;
  write_file(dir / "s.json", R"({"particles": [{"center_m": [100, 0, 1000], "radius_m": [50, 40, 30], "yaw_deg": 30,
    "density": 0.5, "extinction_per_m": 0.04, "shape": "homogeneous"}]})");
  const ProgramResult out =
      run_program({"export", "--scene", dir / "s.json", "--voxel-m", "10", "--out", dir / "v.npy"});
  REQUIRE_MESSAGE(out.status == 0, out.err);
  const Result<NpyArray> array = read_npy(dir / "v.npy");
  REQUIRE(array);
  double sum = 0.0;
  for (std::size_t i = 0; i < array->count(); ++i) {
    float value = 0.0f;
    std::memcpy(&value, &array->data[4 * i], sizeof value);
    sum += 1000.0 * static_cast<double>(value);
  }
  const double mass = 0.02 * 4.0 / 3.0 * 3.141592653589793 * 50.0 * 40.0 * 30.0;
  CHECK(std::abs(sum / mass - 1.0) < 0.005);
}

TEST_CASE("reference --volume: the voxels themselves, where the scene's set stands, are what the set is like") {
  const TempDirectory dir;
  write_cumulus(dir / "c.npy", 48);
  const ProgramResult made = run_program({"import", dir / "c.npy", "--voxel-m", "42.6666667", "--spacing", "2",
                                          "--detail", "0", "--out", dir / "set.json"});
  REQUIRE_MESSAGE(made.status == 0, made.err);
  write_file(dir / "s.json", R"({"camera": {"position_m": [-1200, -1200, 1600], "look_at_m": [1024, 1024, 1700],
    "vertical_fov_deg": 30}, "sources": [{"kind": "set", "file": "set.json", "at_m": [0, 0, 800], "drifts": false}]})");
  const ProgramResult voxels =
      run_program({"reference", "--scene", dir / "s.json", "--volume", dir / "c.npy", "--voxel-m", "42.6666667",
                   "--size", "48x27", "--spp", "64", "--out", dir / "v.exr", "--layers", dir / "vl.exr"});
  REQUIRE_MESSAGE(voxels.status == 0, voxels.err);
  const ProgramResult set = run_program({"reference", "--scene", dir / "s.json", "--tables", small_tables(), "--size",
                                         "48x27", "--spp", "64", "--out", dir / "p.exr", "--layers", dir / "pl.exr"});
  REQUIRE_MESSAGE(set.status == 0, set.err);
  const ProgramResult compared = run_program({"compare", dir / "pl.exr", dir / "vl.exr", "--channels", "T"});
  // Noise of 64 samples is .06 where half is covered, on an outline of a tenth of the picture; a set that stood
  // elsewhere or was turned would differ by tenths.
  CHECK(parsed(compared.out)["rmse"].get<double>() < 0.06);
  CHECK(std::abs(parsed(compared.out)["bias"].get<double>()) < 0.01);

  check_refused(run_program({"reference", "--scene", NEPHELE_SOURCE_DIR "/tools/scenes/fair_weather.json", "--volume",
                             dir / "c.npy", "--voxel-m", "40", "--out", dir / "x.exr"}),
                "--volume takes the place of the scene's set");
  check_refused(
      run_program({"reference", "--scene", dir / "s.json", "--volume", dir / "c.npy", "--out", dir / "x.exr"}),
      "--voxel-m is missing");
}

TEST_CASE("import --device: the same set from a device, and what does not go together is one line") {
  const TempDirectory dir;
  write_cumulus(dir / "c.npy", 32);
  const std::vector<std::string> import = {"import", dir / "c.npy", "--voxel-m", "64", "--spacing", "3"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), import.begin(), import.end());
    return run_program(more);
  };
  REQUIRE(with({"--out", dir / "cpu.json"}).status == 0);
  const ProgramResult device = with({"--out", dir / "device.json", "--device", "0"});
  REQUIRE_MESSAGE(device.status == 0, device.err);
  const Result<ParticleSet> a = load_particle_set(dir / "cpu.json"), b = load_particle_set(dir / "device.json");
  REQUIRE((a && b));
  CHECK(a->particles.size() == b->particles.size());
  CHECK(a->base_m == b->base_m);
  CHECK(a->coarser.size() == b->coarser.size());
  check_refused(with({"--out", dir / "x.json", "--device", "Voodoo"}), "Voodoo");
  check_refused(run_program({"import", dir / "c.npy", "--voxel-m", "64", "--count", "90", "--device", "0", "--out",
                             dir / "x.json"}),
                "--device stands beside");
}
