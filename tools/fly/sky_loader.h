// Gets a sky ready while the window goes on: tables from the cache or baked, pipelines, the scene's renderer and its
// first frame, on a thread of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "engine/result.h"
#include "lut/tables.h"
#include "passes/nephele.h"

namespace nephele::fly {

struct ReadySky {
  std::unique_ptr<Sky> sky;
  std::unique_ptr<Renderer> renderer;  // before the sky in destruction
  std::uint32_t particle_seed = 0;     // of its tables
  ReadySky() = default;
  ReadySky(ReadySky&&) = default;
  ReadySky& operator=(ReadySky&& other) noexcept {
    renderer = std::move(other.renderer);
    sky = std::move(other.sky);
    particle_seed = other.particle_seed;
    return *this;
  }
};

class SkyLoader {
 public:
  // tables: reads or bakes them; it is called on the loader's thread and may show its progress.
  using GetTables = std::function<Result<Tables>(const Scene& scene, const ProgressCallback& progress)>;
  SkyLoader(Device& device, GetTables tables, Scene scene, RenderSettings settings, double time_s);
  ~SkyLoader();  // waits for the thread
  SkyLoader(const SkyLoader&) = delete;
  SkyLoader& operator=(const SkyLoader&) = delete;

  struct Stage {
    std::string name;
    double fraction = 0;
  };
  Stage stage() const;
  // The sky, or why there is none; nothing while it is not ready. Once.
  std::optional<Result<ReadySky>> take();

 private:
  Result<ReadySky> load();
  void show(const std::string& name, double fraction);

  Device& device_;
  GetTables tables_;
  Scene scene_;
  RenderSettings settings_;
  double time_s_;
  mutable std::mutex mutex_;
  Stage stage_;
  std::optional<Result<ReadySky>> ready_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

}  // namespace nephele::fly
