// Cloud fields that are given whole, run through the passes that make particles.
#pragma once

#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "passes/sources/cell_source.h"
#include "passes/sources/cloud_particles.h"
#include "tests/support/cloud_frame.h"
#include "tests/support/test_device.h"

namespace nephele::test {

// A cell source that looks at the field it is told instead of at a scene.
class GivenField final : public CloudSource {
 public:
  explicit GivenField(Workshop& make, const shared::FieldFrame& frame, std::uint32_t capacity = 0,
                      const WeatherMap* map = nullptr)
      : GivenField(std::make_unique<CellSource>(make, "field", frame.field, map, capacity), frame) {}
  GivenField(std::unique_ptr<CellSource> cells, const shared::FieldFrame& frame)
      : CloudSource(cells->name(), cells->capacity()), cells_(std::move(cells)), frame_(frame) {}
  CloudExtent extent() const override { return cells_->extent(); }
  float extinction_per_m() const override { return cells_->extinction_per_m(); }
  InputBytes inputs(const FrameView&) const override { return as_inputs(frame_); }
  void add(FrameBuilder& builder, const FrameView&, const ParticleSink& sink) override {
    cells_->add_field(builder, frame_, sink);
  }
  CellSource::Grid grid() const { return cells_->grid(); }
  void look_at(const shared::FieldFrame& frame) { frame_ = frame; }

 private:
  std::unique_ptr<CellSource> cells_;
  shared::FieldFrame frame_;
};

struct ParticleRun {
  shared::FrameCounters counters;
  std::vector<shared::SourceRecord> records;
  std::vector<shared::Particle> particles;
  std::vector<std::uint32_t> visible;
};

inline ParticleRun run_particles(CloudParticles& pass, FrameExecutor& executor, const shared::FrameConstants& constants,
                                 const FrameView& view = {}) {
  Buffer buffer(test_device(), "frame_constants", sizeof constants);
  FrameBuilder frame(executor);
  frame.update("frame_constants", buffer, as_push(constants));
  const CloudParticles::Outputs outputs = pass.add(frame, buffer, view);
  executor.run(frame);
  ParticleRun result{outputs.counters.read_vector<shared::FrameCounters>(1)[0], {}, {}, {}};
  result.records = outputs.records.read_vector<shared::SourceRecord>(pass.sources().size());
  result.particles = outputs.particles.read_vector<shared::Particle>(result.counters.particle_count);
  result.visible = outputs.visible.read_vector<std::uint32_t>(result.counters.visible_count);
  return result;
}

inline std::vector<std::unique_ptr<CloudSource>> sources_of(std::unique_ptr<CloudSource> source) {
  std::vector<std::unique_ptr<CloudSource>> sources;
  sources.push_back(std::move(source));
  return sources;
}

// Sources and all that they need to run.
class SourcesRun {
 public:
  // make: takes a Workshop and returns the sources.
  template <class Make>
  explicit SourcesRun(Make&& make) : pass_(make_, make(make_)) {}

  ParticleRun run(const shared::FrameConstants& constants, const FrameView& view = {}) {
    return run_particles(pass_, executor_, constants, view);
  }
  const CloudParticles& pass() const { return pass_; }

 private:
  Workshop make_{test_kernels()};
  CloudParticles pass_;
  FrameExecutor executor_{test_device()};
};

// One field alone, with the memory of a renderer.
class FieldRun {
 public:
  explicit FieldRun(const shared::FieldFrame& frame, std::uint32_t capacity = 0, const WeatherMap* map = nullptr)
      : sources_([&](Workshop& make) {
          auto field = std::make_unique<GivenField>(make, frame, capacity, map);
          field_ = field.get();
          return sources_of(std::move(field));
        }) {}

  ParticleRun run(const shared::FieldFrame& frame, const shared::FrameConstants& constants = cloud_view()) {
    field_->look_at(frame);
    return sources_.run(constants);
  }
  CellSource::Grid grid() const { return field_->grid(); }
  shared::FieldCounters counters() const { return grid().counters.read_vector<shared::FieldCounters>(1)[0]; }

 private:
  GivenField* field_ = nullptr;
  SourcesRun sources_;
};

inline bool same_bytes(const std::vector<shared::Particle>& a, const std::vector<shared::Particle>& b) {
  if (a.size() != b.size()) return false;
  return a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(shared::Particle)) == 0;
}

}  // namespace nephele::test
