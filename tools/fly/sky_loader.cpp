#include "tools/fly/sky_loader.h"

#include <utility>

namespace nephele::fly {

SkyLoader::SkyLoader(Device& device, GetTables tables, Scene scene, RenderSettings settings, double time_s)
    : device_(device), tables_(std::move(tables)), scene_(std::move(scene)), settings_(settings), time_s_(time_s) {
  thread_ = std::thread([this] {
    Result<ReadySky> ready = load();
    const std::lock_guard lock(mutex_);
    ready_.emplace(std::move(ready));
    done_ = true;
  });
}

SkyLoader::~SkyLoader() { thread_.join(); }

void SkyLoader::show(const std::string& name, double fraction) {
  const std::lock_guard lock(mutex_);
  stage_ = {name, fraction};
}

SkyLoader::Stage SkyLoader::stage() const {
  const std::lock_guard lock(mutex_);
  return stage_;
}

Result<ReadySky> SkyLoader::load() {
  show("look-up tables", 0.0);
  const Result<Tables> tables =
      tables_(scene_, [this](const std::string& name, double fraction) { show(name, fraction); });
  if (!tables) return tables.error();
  show("kernels", 0.0);
  Result<std::unique_ptr<Sky>> sky = Sky::create(device_, *tables);
  if (!sky) return sky.error();
  show("kernels", 0.4);
  Result<std::unique_ptr<Renderer>> renderer = Renderer::create(**sky, scene_, settings_);
  if (!renderer) return renderer.error();
  show("first picture", 0.8);
  (*renderer)->render(scene_.camera, time_s_);
  ReadySky ready;
  ready.sky = std::move(*sky);
  ready.renderer = std::move(*renderer);
  ready.particle_seed = tables->parameters.particle_seed;
  return ready;
}

std::optional<Result<ReadySky>> SkyLoader::take() {
  if (!done_) return std::nullopt;
  const std::lock_guard lock(mutex_);
  return std::exchange(ready_, std::nullopt);
}

}  // namespace nephele::fly
