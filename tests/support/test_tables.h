// The product's default tables, from the user's cache or baked into it once.
#pragma once

#include "lut/tables.h"

namespace nephele::test {

const Tables& test_tables();

}  // namespace nephele::test
