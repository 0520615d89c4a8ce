// The product's default tables, from the user's cache or baked into it once, and a sky of the test device with them.
#pragma once

#include <memory>

#include "lut/tables.h"
#include "passes/nephele.h"

namespace nephele::test {

const Tables& test_tables();

// Shared by all tests of the executable: their renderers find its pipelines made.
Sky& test_sky();

// A renderer of it; ends the tests where it can't be made.
std::unique_ptr<Renderer> renderer_of(const Scene& scene, const RenderSettings& settings);

}  // namespace nephele::test
