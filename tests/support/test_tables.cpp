#include "tests/support/test_tables.h"

#include "engine/check.h"

namespace nephele::test {

const Tables& test_tables() {
  static const Tables tables = [] {
    auto loaded = load_or_bake(TableParameters{}, default_cache_dir());
    NEPHELE_CHECK(loaded, loaded ? "" : loaded.error().message);
    return std::move(*loaded);
  }();
  return tables;
}

}  // namespace nephele::test
