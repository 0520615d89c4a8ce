// What the tests of the program share.
#pragma once

#include <doctest/doctest.h>

#include <string>

#include "tests/support/support.h"

namespace nephele::test {

// The smallest tables there are, for the default scene's phase function: quick to bake, good enough to render with.
inline void bake_small_tables(const std::string& directory) {
  const ProgramResult result = run_program({"bake", "--preset", "fast", "--size-optical-depth", "4",
                                            "--size-scattering", "4x3x4", "--residual", "0.01", "--out", directory});
  REQUIRE_MESSAGE(result.status == 0, result.err);
}

// The same, baked once.
inline const std::string& small_tables() {
  static const TempDirectory directory;
  static const std::string tables = [] {
    bake_small_tables(directory / "tables");
    return directory / "tables";
  }();
  return tables;
}

}  // namespace nephele::test
