#include "tools/render_stats.h"

#include <algorithm>
#include <map>

#include "engine/check.h"
#include "engine/statistics.h"

namespace nephele::tools {
namespace {

using nlohmann::ordered_json;

// Median over the frames of each pass's time, 0 in frames that had no need of it; in the order of the fullest frame.
ordered_json pass_times(const std::vector<FrameStats>& frames) {
  std::map<std::string, std::vector<double>> times;
  for (const FrameStats& frame : frames)
    for (const PassTime& pass : frame.passes) times[pass.name].push_back(pass.gpu_ms);
  const auto fullest = std::max_element(frames.begin(), frames.end(), [](const FrameStats& a, const FrameStats& b) {
    return a.passes.size() < b.passes.size();
  });
  ordered_json passes = ordered_json::array();
  for (const PassTime& pass : fullest->passes) {
    std::vector<double>& ms = times[pass.name];
    ms.resize(frames.size(), 0.0);
    passes.push_back({{"name", pass.name}, {"ms", percentiles(ms).median}});
  }
  return passes;
}

ordered_json worst_overflow(const std::vector<FrameStats>& frames) {
  std::map<std::string, std::uint64_t> worst;
  for (const FrameStats& frame : frames)
    for (const auto& [buffer, lost] : frame.overflow) worst[buffer] = std::max(worst[buffer], lost);
  return worst;
}

// Of the last frame, but for the overflow: the worst of all.
ordered_json source_counts(const std::vector<FrameStats>& frames) {
  std::map<std::string, std::uint64_t> worst;
  for (const FrameStats& frame : frames)
    for (const SourceStats& source : frame.sources) worst[source.name] = std::max(worst[source.name], source.overflow);
  ordered_json sources = ordered_json::array();
  for (const SourceStats& source : frames.back().sources)
    sources.push_back(
        {{"name", source.name}, {"particles_generated", source.particles_generated}, {"overflow", worst[source.name]}});
  return sources;
}

// As asked for; the keys beside it tell what the frames had.
ordered_json settings_json(const RenderSettings& settings) {
  ordered_json json;
  for (const Setting& setting : all_settings()) json[setting.key] = json_of(setting.get(settings));
  return json;
}

}  // namespace

nlohmann::ordered_json json_of(const Value& value) {
  return std::visit(
      [&](const auto& held) -> ordered_json {
        if constexpr (std::is_same_v<std::remove_cvref_t<decltype(held)>, ImageSize>)
          return value_text(value);
        else
          return held;
      },
      value);
}

std::string render_stats_json(const DeviceInfo& device, const RenderSettings& settings,
                              const std::vector<FrameStats>& frames) {
  NEPHELE_CHECK(!frames.empty());
  const FrameStats& last = frames.back();
  std::vector<double> frame_ms, cpu_ms;
  for (const FrameStats& frame : frames) {
    frame_ms.push_back(frame.frame_ms);
    cpu_ms.push_back(frame.cpu_ms);
  }
  const Percentiles times = percentiles(frame_ms);
  const ordered_json stats{
      {"device", device.name},
      {"driver", device.driver},
      {"width", settings.width},
      {"height", settings.height},
      {"scale", settings.scale},
      {"quality", quality_name(settings.quality)},
      {"backend", last.backend},
      {"blend", last.backend == backend_name(Backend::alpha) ? "alpha" : blend_mode_name(settings.blend)},
      {"particles_generated", last.particles_generated},
      {"particles_visible", last.particles_visible},
      {"sources", source_counts(frames)},
      {"overflow", worst_overflow(frames)},
      {"frames", frames.size()},
      {"frame_ms", {{"median", times.median}, {"p95", times.p95}, {"min", times.min}}},
      {"cpu_ms", percentiles(cpu_ms).median},
      {"passes", pass_times(frames)},
      {"gpu_memory_bytes", last.gpu_memory_bytes},
      {"fragments_shaded", last.fragments_shaded},
      {"pairs_shaded", last.pairs_shaded},
      {"settings", settings_json(settings)},
  };
  return stats.dump(2) + '\n';
}

}  // namespace nephele::tools
