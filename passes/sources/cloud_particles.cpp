#include "passes/sources/cloud_particles.h"

#include <algorithm>
#include <cmath>

namespace nephele {
namespace {

constexpr VkDeviceSize kBytesPerParticle = 160;  // the largest array with an element for every particle
constexpr VkDeviceSize kThreadsPerGroup = 64;    // of the dispatches with a thread for every particle

std::uint32_t capacity_of(const std::vector<std::unique_ptr<CloudSource>>& sources) {
  std::uint32_t sum = 0;
  for (const auto& source : sources) sum += source->capacity();
  return std::max(sum, 1u);
}

}  // namespace

std::uint32_t most_particles(const Device& device) {
  return static_cast<std::uint32_t>(
      std::min(device.max_elements(kBytesPerParticle), VkDeviceSize{device.info().max_groups} * kThreadsPerGroup));
}

CloudExtent united(const CloudExtent& a, const CloudExtent& b) {
  return {std::min(a.lowest_m, b.lowest_m), std::max(a.highest_m, b.highest_m)};
}

CloudParticles::CloudParticles(Workshop& make, std::vector<std::unique_ptr<CloudSource>> sources)
    : sources_(std::move(sources)),
      capacity_(capacity_of(sources_)),
      visibility_(make, capacity_),
      particles_(make.buffer("particles", VkDeviceSize{capacity_} * sizeof(shared::Particle))),
      counters_(make.buffer("counters", sizeof(shared::FrameCounters))),
      records_(
          make.buffer("source_records", std::max<VkDeviceSize>(sources_.size(), 1) * sizeof(shared::SourceRecord))) {}

CloudParticles::Outputs CloudParticles::add(FrameBuilder& frame, const Buffer& frame_constants, const FrameView& view) {
  shared::FrameCounters start{};
  start.particle_groups = {0, 1, 1};
  start.visible_groups = {0, 1, 1};  // where there are no particles, nothing writes these
  start.draw = {0, 1, 0, 0};
  frame.update("frame_constants", counters_, as_push(start));
  std::vector<shared::SourceRecord> records(std::max<std::size_t>(sources_.size(), 1));
  for (std::size_t i = 0; i < sources_.size(); ++i) records[i].extinction_per_m = sources_[i]->extinction_per_m();
  const auto bytes = std::as_bytes(std::span(records));
  frame.update("frame_constants", records_, {bytes.begin(), bytes.end()});
  for (std::size_t i = 0; i < sources_.size(); ++i)
    sources_[i]->add(frame, view,
                     {particles_, counters_, records_, static_cast<std::uint32_t>(i), sources_[i]->name()});
  const Buffer& visible = visibility_.add(frame, frame_constants, particles_, counters_);
  return {particles_, visible, counters_, records_};
}

InputBytes CloudParticles::inputs(const FrameView& view) const {
  InputBytes all;
  for (const auto& source : sources_) {
    const InputBytes own = source->inputs(view);
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}

CloudExtent CloudParticles::extent() const {
  CloudExtent all{kNoTopM, -kNoTopM};
  for (const auto& source : sources_) all = united(all, source->extent());
  return all;
}

bool CloudParticles::has_soft_particles() const {
  return std::any_of(sources_.begin(), sources_.end(), [](const auto& source) { return source->has_soft_particles(); });
}

}  // namespace nephele
