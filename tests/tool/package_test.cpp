// Nephele as a host finds it: installed, found by CMake, linked, and drawing the picture that it draws here; or added
// to the host's own build, as the library alone.
#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>

#include "passes/nephele.h"
#include "tests/support/include_scan.h"
#include "tests/support/support.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::test;

namespace {

// Runs a command line, which must succeed; returns what it printed.
std::string run(const TempDirectory& directory, const std::string& command) {
  const std::string log = directory / "log";
  const int status = std::system((command + " >" + log + " 2>&1").c_str());
  const std::string output = read_file(log);
  REQUIRE_MESSAGE(status == 0, output);
  return output;
}

// In a sanitizer build the host's program tells leaks of Vulkan drivers from Nephele's, as the tests do.
#if defined(__SANITIZE_ADDRESS__)
constexpr const char* kHostFlags = " -DCMAKE_CXX_FLAGS='-include " NEPHELE_SOURCE_DIR "/engine/leak_check.h'";
#else
constexpr const char* kHostFlags = "";
#endif

}  // namespace

TEST_CASE("an installed package builds and runs in another project, with the public headers alone") {
  const TempDirectory directory;
  const std::string prefix = directory / "prefix", build = directory / "build";
  run(directory, "cmake --install " NEPHELE_BINARY_DIR " --prefix " + prefix);

  std::set<std::string> installed, reached;
  const std::filesystem::path include = std::filesystem::path(prefix) / "include/nephele";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(include))
    if (entry.is_regular_file()) installed.insert(std::filesystem::relative(entry.path(), include).string());
  // Everything that the public header needs is there, nothing else is, and nobody needs JSON or command lines for it.
  std::vector<std::string> waiting{"passes/nephele.h"};
  while (!waiting.empty()) {
    const std::string header = waiting.back();
    waiting.pop_back();
    if (!reached.insert(header).second) continue;
    REQUIRE_MESSAGE(installed.contains(header), header);
    const std::string text = read_file((include / header).string());
    CHECK_MESSAGE(text.find("nlohmann/") == std::string::npos, header);
    CHECK_MESSAGE(text.find("CLI/") == std::string::npos, header);
    for (const std::string& included : quoted_includes(text)) {
      const std::string beside = (std::filesystem::path(header).parent_path() / included).string();
      waiting.push_back(installed.contains(beside) ? beside : included);
    }
  }
  CHECK(installed == reached);

  run(directory, "cmake -S " NEPHELE_SOURCE_DIR "/tools/embed_example -B " + build +
                     " -G Ninja -DCMAKE_PREFIX_PATH=" + prefix + kHostFlags);
  run(directory, "cmake --build " + build);
  const double there = std::strtod(run(directory, build + "/embed_example").c_str(), nullptr);

  const Scene scene;
  const auto renderer = Renderer::create(test_sky(), scene, {.width = 64, .height = 36, .quality = Quality::low});
  REQUIRE(renderer);
  (*renderer)->render(scene.camera, 0.0);
  const std::vector<float> hdr = (*renderer)->read_hdr();
  double here = 0;
  for (std::size_t i = 1; i < hdr.size(); i += 4) here += hdr[i];
  CHECK(there == doctest::Approx(here / (64 * 36)).epsilon(1e-4));  // printed with six digits
}

TEST_CASE("a host that adds the sources to its build gets the library alone and needs no package of the rest") {
  const TempDirectory directory;
  const std::string build = directory / "build";
  run(directory, "cmake -S " NEPHELE_SOURCE_DIR "/tools/embed_example -B " + build +
                     " -G Ninja -DNEPHELE_SOURCE=" NEPHELE_SOURCE_DIR
                     " -DCMAKE_DISABLE_FIND_PACKAGE_CLI11=ON -DCMAKE_DISABLE_FIND_PACKAGE_doctest=ON");
  const std::string graph = read_file(build + "/build.ninja");
  CHECK(graph.find("nephele_renderer") != std::string::npos);
  for (const char* ours : {"nephele_program", "nephele_lut_study", "nephele_path_tracer", "test_cpu", "-Werror"})
    CHECK_MESSAGE(graph.find(ours) == std::string::npos, ours);
  // The host's own install step installs what the host says, not Nephele.
  run(directory, "cmake --install " + build + " --prefix " + (directory / "prefix"));
  CHECK_FALSE(std::filesystem::exists(directory / "prefix"));
}
