#include "tests/support/test_tables.h"

#include "engine/check.h"
#include "tests/support/test_device.h"

namespace nephele::test {

const Tables& test_tables() {
  static const Tables tables = [] {
    auto loaded = load_or_bake(TableParameters{}, default_cache_dir());
    NEPHELE_CHECK(loaded, loaded ? "" : loaded.error().message);
    return std::move(*loaded);
  }();
  return tables;
}

Sky& test_sky() {
  static std::unique_ptr<Sky> sky;
  if (!sky) {
    auto made = Sky::create(test_device(), test_tables());
    NEPHELE_CHECK(made, made ? "" : made.error().message);
    sky = std::move(*made);
    release_before_device([] { sky.reset(); });
  }
  return *sky;
}

}  // namespace nephele::test
