#include "tests/support/test_tables.h"

#include <map>
#include <memory>
#include <utility>

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
  static std::map<Device*, std::unique_ptr<Sky>> skies;
  std::unique_ptr<Sky>& sky = skies[&test_device()];
  if (!sky) {
    if (skies.size() == 1) release_before_device([] { skies.clear(); });
    auto made = Sky::create(test_device(), test_tables());
    NEPHELE_CHECK(made, made ? "" : made.error().message);
    sky = std::move(*made);
  }
  return *sky;
}

std::unique_ptr<Renderer> renderer_of(const Scene& scene, const RenderSettings& settings) {
  auto renderer = Renderer::create(test_sky(), scene, settings);
  NEPHELE_CHECK(renderer, renderer ? "" : renderer.error().message);
  return std::move(*renderer);
}

}  // namespace nephele::test
