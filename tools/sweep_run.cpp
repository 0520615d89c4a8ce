#include "tools/sweep_run.h"

#include <chrono>
#include <cmath>
#include <map>

#include "engine/check.h"
#include "engine/image_compare.h"
#include "tools/progress.h"
#include "tools/scene_tables.h"

namespace nephele::tools {
namespace {

using Clock = std::chrono::steady_clock;

// Renderers are kept from one repetition to the next as long as all of them together take no more device memory.
constexpr std::uint64_t kKeptBytes = std::uint64_t{1} << 30;

ImageF linear_image(Renderer& renderer, const RenderSettings& settings) {
  ImageF image{settings.width, settings.height, {"R", "G", "B"}, {}};
  const std::vector<float> rgba = renderer.read_hdr();
  image.data.reserve(rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    image.data.insert(image.data.end(), {rgba[i], rgba[i + 1], rgba[i + 2]});
  return image;
}

class SweepRun {
 public:
  SweepRun(const Sweep& sweep, Device& device, SweepRecord& record, bool quiet)
      : sweep_(sweep), device_(device), record_(record), progress_(quiet) {}

  Result<void> run() {
    for (const SweepVariant& variant : sweep_.variants) {
      if (auto ok = check(variant.name(), variant.picture); !ok) return ok;
      if (variant.reference_picture)
        if (auto ok = check("the reference of " + variant.name(), *variant.reference_picture); !ok) return ok;
    }
    for (std::uint32_t repetition = 0; repetition < sweep_.repetitions; ++repetition)
      for (const SweepVariant& variant : sweep_.variants) {
        if (record_.has(variant.picture.key, repetition)) continue;
        if (auto measured = measure(variant, repetition); !measured) return measured;
      }
    return {};
  }

 private:
  // Everything that can be refused is, before anything is measured; the skies are made on the way.
  Result<void> check(const std::string& name, const SweepPicture& picture) {
    if (auto ok = Renderer::check(device_, picture.render); !ok) return Error{name + ": " + ok.error().message};
    const Result<Sky*> sky = sky_for(picture);
    if (!sky) return sky.error();
    return {};
  }

  // One for each set of tables.
  Result<Sky*> sky_for(const SweepPicture& picture) {
    Result<TableParameters> preset = TableParameters::preset(picture.table_preset);
    if (!preset) return preset.error();
    const TableParameters parameters = with_phase(*preset, picture.scene);
    const std::string key = concat(picture.table_preset, ' ', parameters.phase_function, ' ', parameters.g_multiple);
    if (const auto found = skies_.find(key); found != skies_.end()) return found->second.get();
    const Result<Tables> tables =
        load_or_bake(parameters, default_cache_dir(),
                     [&](const std::string& stage, double fraction) { progress_.show(stage, fraction); });
    if (!tables) return tables.error();
    Result<std::unique_ptr<Sky>> sky = Sky::create(device_, *tables);
    if (!sky) return sky.error();
    return skies_.emplace(key, std::move(*sky)).first->second.get();
  }

  Result<std::unique_ptr<Renderer>> make_renderer(const SweepPicture& picture) {
    const Result<Sky*> sky = sky_for(picture);
    if (!sky) return sky.error();
    return Renderer::create(**sky, picture.scene, picture.render);
  }

  Result<const ImageF*> reference_for(const SweepVariant& variant) {
    if (variant.reference_image) return variant.reference_image.get();
    const SweepPicture& picture = *variant.reference_picture;
    if (reference_key_ != picture.key) {
      Result<std::unique_ptr<Renderer>> renderer = make_renderer(picture);
      if (!renderer) return renderer.error();
      (*renderer)->render(picture.scene.camera, 0);
      reference_ = linear_image(**renderer, picture.render);
      reference_key_ = picture.key;
    }
    return &reference_;
  }

  Result<SweepErrors> errors_of(const SweepVariant& variant, const ImageF& image) {
    const Result<const ImageF*> reference = reference_for(variant);
    if (!reference) return reference.error();
    const Result<ImageErrors> errors =
        compare_images(image, variant.name(), **reference, "its reference", image.channels);
    if (!errors) return errors.error();
    return SweepErrors{errors->rmse, errors->relmse, errors->bias};
  }

  // A renderer with its first frames behind it, and the memory it takes.
  struct Warm {
    std::unique_ptr<Renderer> renderer;
    std::uint64_t bytes = 0;
  };

  Result<Warm> warm_renderer(const SweepPicture& picture) {
    Warm warm;
    if (const auto kept = kept_.find(picture.key); kept != kept_.end()) {
      warm = std::move(kept->second);
      kept_.erase(kept);
    } else {
      const std::uint64_t before = device_.allocated_bytes();
      Result<std::unique_ptr<Renderer>> made = make_renderer(picture);
      if (!made) return made.error();
      warm = {std::move(*made), device_.allocated_bytes() - before};
    }
    for (std::uint32_t i = 0; i < sweep_.warmup_frames; ++i) warm.renderer->render(picture.scene.camera, 0);
    return warm;
  }

  Result<void> measure(const SweepVariant& variant, std::uint32_t repetition) {
    show_progress(variant.name());
    const SweepPicture& picture = variant.picture;
    SweepMeasurement measurement{.variant = picture.key, .repetition = repetition};
    Result<Warm> warm = warm_renderer(picture);
    if (!warm) return warm.error();
    Renderer& renderer = *warm->renderer;
    for (std::uint32_t i = 0; i < sweep_.frames; ++i) {
      renderer.render(picture.scene.camera, 0);
      add_times(renderer.stats(), measurement);
    }
    add_work(renderer.stats(), warm->bytes, measurement);
    // Two runs give the same picture: one repetition tells its error.
    if (repetition == 0 && (variant.reference_image || variant.reference_picture)) {
      const Result<SweepErrors> errors = errors_of(variant, linear_image(renderer, picture.render));
      if (!errors) return errors.error();
      measurement.errors = *errors;
    }
    if (device_.allocated_bytes() <= kKeptBytes) kept_.emplace(picture.key, std::move(*warm));
    ++measured_;
    return record_.add(std::move(measurement));
  }

  static void add_times(const FrameStats& stats, SweepMeasurement& measurement) {
    measurement.frame_ms.push_back(stats.frame_ms);
    measurement.cpu_ms.push_back(stats.cpu_ms);
    if (measurement.passes_ms.empty())
      for (const PassTime& pass : stats.passes) measurement.passes_ms.emplace_back(pass.name, std::vector<double>());
    NEPHELE_CHECK(stats.passes.size() == measurement.passes_ms.size());
    for (std::size_t i = 0; i < stats.passes.size(); ++i)
      measurement.passes_ms[i].second.push_back(stats.passes[i].gpu_ms);
  }

  static void add_work(const FrameStats& stats, std::uint64_t bytes, SweepMeasurement& measurement) {
    std::uint64_t lost = 0;
    for (const auto& [buffer, count] : stats.overflow) lost += count;
    measurement.work = {{"particles_generated", stats.particles_generated},
                        {"particles_visible", stats.particles_visible},
                        {"fragments_shaded", stats.fragments_shaded},
                        {"pairs_shaded", stats.pairs_shaded},
                        {"overflow", lost},
                        {"gpu_memory_bytes", bytes}};
  }

  void show_progress(const std::string& name) {
    const std::size_t total = sweep_.variants.size() * sweep_.repetitions;
    const std::size_t done = record_.measurements().size();
    std::string label = name;
    if (measured_ > 0) {
      const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
      label =
          concat("about ", std::ceil(seconds / static_cast<double>(measured_) * static_cast<double>(total - done) / 60),
                 " min left: ", name);
    } else {
      start_ = Clock::now();
    }
    progress_.show(label, static_cast<double>(done) / static_cast<double>(total));
  }

  const Sweep& sweep_;
  Device& device_;
  SweepRecord& record_;
  Progress progress_;
  std::map<std::string, std::unique_ptr<Sky>> skies_;
  std::map<std::string, Warm> kept_;
  ImageF reference_;
  std::string reference_key_;
  Clock::time_point start_{};
  std::size_t measured_ = 0;
};

}  // namespace

Result<void> run_sweep(const Sweep& sweep, Device& device, SweepRecord& record, bool quiet) {
  return SweepRun(sweep, device, record, quiet).run();
}

}  // namespace nephele::tools
