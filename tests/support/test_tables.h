// The product's default tables, from the user's cache or baked into it once, and a sky of the test device with them.
#pragma once

#include "lut/tables.h"
#include "passes/nephele.h"

namespace nephele::test {

const Tables& test_tables();

// Shared by all tests of the executable: their renderers find its pipelines made.
Sky& test_sky();

}  // namespace nephele::test
