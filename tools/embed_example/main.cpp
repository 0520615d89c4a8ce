// The smallest host: a sky, its mean brightness on stdout.
#include <cstdio>

#include "passes/nephele.h"

int main() {
  using namespace nephele;
  const auto device = Device::create(DeviceOptions::from_environment());
  if (!device) return std::fprintf(stderr, "%s\n", device.error().message.c_str()), 1;
  const auto tables = load_or_bake(TableParameters{}, default_cache_dir());
  if (!tables) return std::fprintf(stderr, "%s\n", tables.error().message.c_str()), 1;
  const Scene scene;
  const auto sky = Sky::create(**device, *tables);
  if (!sky) return std::fprintf(stderr, "%s\n", sky.error().message.c_str()), 1;
  const auto renderer = Renderer::create(**sky, scene, {.width = 64, .height = 36, .quality = Quality::low});
  if (!renderer) return std::fprintf(stderr, "%s\n", renderer.error().message.c_str()), 1;
  (*renderer)->render(scene.camera, 0.0);
  double sum = 0;
  const std::vector<float> hdr = (*renderer)->read_hdr();
  for (std::size_t i = 1; i < hdr.size(); i += 4) sum += hdr[i];
  std::printf("%g\n", sum / (64 * 36));
}
