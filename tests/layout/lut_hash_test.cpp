// The hash that tells tables of one bake from tables of another: it follows what the bake's sources include.
#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/support/support.h"

using namespace nephele::test;

namespace {

// A project in small: a bake, a header with its source file beside, a header below that, and a file that no bake sees.
class SmallProject {
 public:
  SmallProject() {
    std::filesystem::create_directories(directory_.path() / "a folder/lut");
    write("lut/small_bake.cpp", "#include \"lut/helper.h\"\nint bake() { return helper(); }\n");
    write("lut/helper.h", "int helper();\n");
    write("lut/helper.cpp", "#include \"lut/deep.h\"\nint helper() { return kDeep; }\n");
    write("lut/deep.h", "constexpr int kDeep = 1;\n");
    write("lut/other.h", "constexpr int kOther = 1;\n");
  }
  void write(const std::string& name, const std::string& text) const { write_file(root() + "/" + name, text); }

  // The generated header, made by the build's own script.
  std::string header() const {
    const std::string out = directory_ / "lut_hash.h", log = directory_ / "log";
    const std::string command = "cmake -DCOMPILER=" NEPHELE_CXX_COMPILER " -DFLAGS=-std=c++20 '-DINCLUDES=" + root() +
                                "' '-DSOURCE_DIR=" + root() + "' '-DBINARY_DIR=" + root() +
                                "/build' '-DROOTS=" + root() + "/lut/small_bake.cpp' -DHEADER=" + out +
                                " -P " NEPHELE_SOURCE_DIR "/tools/cmake/NepheleLutHash.cmake >" + log + " 2>&1";
    REQUIRE_MESSAGE(std::system(command.c_str()) == 0, read_file(log));
    return read_file(out);
  }

 private:
  std::string root() const { return directory_ / "a folder"; }
  TempDirectory directory_;
};

}  // namespace

TEST_CASE("the tables' hash changes with a file that a bake includes, and with no other") {
  const SmallProject project, elsewhere;
  const std::string header = project.header();
  CHECK(header.find("kLutHash = \"") != std::string::npos);
  for (const char* name : {"lut/small_bake.cpp", "lut/helper.h", "lut/helper.cpp", "lut/deep.h"})
    CHECK_MESSAGE(header.find(std::string("//   ") + name + "\n") != std::string::npos, name);
  CHECK(elsewhere.header() == header);  // whatever the directory
  project.write("lut/other.h", "constexpr int kOther = 2;\n");
  CHECK(project.header() == header);
  project.write("lut/deep.h", "constexpr int kDeep = 2;\n");
  CHECK(project.header() != header);
}

TEST_CASE("this build's hash covers the bakes and the shared headers they need, and no pass") {
  const std::string header = read_file(NEPHELE_BINARY_DIR "/generated/nephele_lut/lut_hash.h");
  for (const char* name : {"lut/optical_depth_bake.cpp", "lut/scattering_bake.cpp", "lut/sphere_solver.cpp",
                           "shaders/shared/noise.h", "shaders/shared/phase.h", "shaders/shared/table_axes.h"})
    CHECK_MESSAGE(header.find(std::string("//   ") + name + "\n") != std::string::npos, name);
  for (const char* folder : {"passes/", "tools/", "tests/", "shaders/layer/", "lut/tables", "lut/gpu_tables"})
    CHECK_MESSAGE(header.find(std::string("//   ") + folder) == std::string::npos, folder);
}
