// Nephele as a host finds it: installed, found by CMake, linked, and drawing the picture that it draws here.
#include <doctest/doctest.h>

#include <cstdlib>

#include "passes/nephele.h"
#include "tests/support/support.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using namespace nephele::test;

TEST_CASE("an installed package builds and runs in another project") {
  const TempDirectory directory;
  const std::string prefix = directory / "prefix", build = directory / "build", log = directory / "log";
  const auto run = [&](const std::string& command) {
    const int status = std::system((command + " >" + log + " 2>&1").c_str());
    REQUIRE_MESSAGE(status == 0, read_file(log));
  };
  run("cmake --install " NEPHELE_BINARY_DIR " --prefix " + prefix);
  run("cmake -S " NEPHELE_SOURCE_DIR "/tools/embed_example -B " + build + " -G Ninja -DCMAKE_PREFIX_PATH=" + prefix);
  run("cmake --build " + build);
  run(build + "/consumer");
  const double there = std::strtod(read_file(log).c_str(), nullptr);

  const Scene scene;
  const auto renderer = Renderer::create(test_sky(), scene, {.width = 64, .height = 36, .quality = Quality::low});
  REQUIRE(renderer);
  (*renderer)->render(scene.camera, 0.0);
  const std::vector<float> hdr = (*renderer)->read_hdr();
  double here = 0;
  for (std::size_t i = 1; i < hdr.size(); i += 4) here += hdr[i];
  CHECK(there == doctest::Approx(here / (64 * 36)).epsilon(1e-4));  // printed with six digits
}
