// nephele grow as a user runs it.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/particle_set.h"
#include "engine/result.h"
#include "tests/support/support.h"
#include "tests/tool/program.h"

using namespace nephele::test;

namespace {

// Nothing on stdout, one line on stderr that mentions all of these, status 2.
void expect_one_line(const std::vector<std::string>& arguments, const std::vector<std::string>& mentions) {
  const ProgramResult result = run_program(arguments);
  CAPTURE(arguments);
  CAPTURE(result.err);
  CHECK(result.status == 2);
  CHECK(result.out.empty());
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  for (const std::string& mention : mentions) CHECK_MESSAGE(result.err.find(mention) != std::string::npos, mention);
}

}  // namespace

TEST_CASE("grow: every generator writes a set that loads; one seed makes one file, another seed another") {
  const TempDirectory directory;
  write_file(directory / "box.obj",
             "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 4 3 2\nf 5 6 7 8\n"
             "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  for (const std::string generator : {"gaussian", "l_system", "metaballs", "mesh"}) {
    CAPTURE(generator);
    const auto grow = [&](const std::string& seed, const std::string& name) {
      std::vector<std::string> arguments{"grow", generator, "--seed", seed, "--out", directory / name};
      if (generator == "mesh") arguments.insert(arguments.end(), {"--mesh", directory / "box.obj"});
      const ProgramResult result = run_program(arguments);
      CAPTURE(result.err);
      CHECK(result.status == 0);
      CHECK(result.out.empty());
      CHECK(result.err.empty());
    };
    grow("3", "a.json");
    grow("3", "b.json");
    grow("4", "c.json");
    CHECK(read_file(directory / "a.npy") == read_file(directory / "b.npy"));
    const auto loaded = [&](const std::string& name) { return nephele::load_particle_set(directory / name); };
    REQUIRE((loaded("a.json") && loaded("b.json")));
    CHECK(*loaded("a.json") == *loaded("b.json"));  // the files name their own coarser levels
    CHECK(read_file(directory / "a.npy") != read_file(directory / "c.npy"));
    const nephele::Result<nephele::ParticleSet> set = nephele::load_particle_set(directory / "a.json");
    REQUIRE_MESSAGE(set, set.error().message);
    CHECK(set->source == "grow " + generator);
    CHECK(set->parameters.find("\"seed\":3") != std::string::npos);
  }
}

TEST_CASE("grow: the help says where the parameters are documented") {
  const ProgramResult result = run_program({"grow", "gaussian", "--help"});
  CHECK(result.status == 0);
  CHECK(result.out.find("docs/generators.md") != std::string::npos);
}

TEST_CASE("grow: what is wrong is one line, and no file is left") {
  const TempDirectory directory;
  const std::string out = directory / "x.json", parameters = directory / "p.json";
  write_file(parameters, "{\"towers\": -1}");
  write_file(directory / "l.json",
             "{\"axiom\": \"F\", \"generations\": 30, \"rules\": [{\"symbol\": \"F\", "
             "\"becomes\": \"FFFF\"}]}");
  write_file(directory / "bad.obj", "v 0 0\nf 1 2 9");
  const auto before = directory.entries();
  expect_one_line({"grow"}, {"generator"});
  expect_one_line({"grow", "fog", "--out", out}, {"generator", "fog", "gaussian"});
  expect_one_line({"grow", "gaussian"}, {"--out"});
  expect_one_line({"grow", "gaussian", "--out", directory / "x.npy"}, {"--out", ".json"});
  expect_one_line({"grow", "gaussian", "--out", directory / "none/x.json"}, {"none/x.json"});
  expect_one_line({"grow", "gaussian", "--seed", "-1", "--out", out}, {"--seed", "-1"});
  expect_one_line({"grow", "gaussian", "--parameters", directory / "none.json", "--out", out}, {"none.json"});
  expect_one_line({"grow", "gaussian", "--parameters", parameters, "--out", out}, {parameters, "towers is -1", "500"});
  expect_one_line({"grow", "gaussian", "--parameters", parameters, "--out", parameters}, {"--parameters", "--out"});
  expect_one_line({"grow", "l_system", "--parameters", directory / "l.json", "--out", out}, {"l.json", "generations"});
  expect_one_line({"grow", "gaussian", "--mesh", directory / "bad.obj", "--out", out}, {"--mesh", "gaussian"});
  expect_one_line({"grow", "mesh", "--out", out}, {"--mesh"});
  expect_one_line({"grow", "mesh", "--mesh", directory / "none.ply", "--out", out}, {"none.ply"});
  expect_one_line({"grow", "mesh", "--mesh", directory / "bad.obj", "--out", out}, {"bad.obj"});
  CHECK(directory.entries() == before);
}
