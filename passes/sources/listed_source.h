// Particles that a scene or a file lists, placed in the world.
//
// reads -> writes: placed particles -> particles, the source's record; particle_* of the counters
// cost: one thread a particle, some twenty operations.
//
// Places are exact to a fraction of a millimetre 10 000 km out: what is near the camera is subtracted before it becomes
// a float. A source that drifts is seen by a camera that moves against the wind instead.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "passes/kit/cloud_source.h"
#include "shared/listed_particles.h"

namespace nephele {

class ListedSource final : public CloudSource {
 public:
  // wind_m_per_s: of the scene, for a group that drifts and names no wind of its own. At most `most` particles, the
  // first ones; the others are counted as overflow.
  ListedSource(Workshop& make, std::string name, const ParticleGroup& group, const glm::dvec2& wind_m_per_s,
               const glm::dvec2& world_origin_m, std::uint32_t most);

  CloudExtent extent() const override { return extent_; }
  std::optional<CloudBounds> bounds() const override { return bounds_; }
  float extinction_per_m() const override { return extinction_per_m_; }
  bool has_soft_particles() const override { return has_soft_particles_; }
  InputBytes inputs(const FrameView& view) const override;
  void add(FrameBuilder& frame, const FrameView& view, const ParticleSink& sink) override;

 private:
  shared::SplitPlace camera(const FrameView& view) const;

  const ComputeKernel& claim_;
  const ComputeKernel& place_;
  glm::dvec2 drift_m_per_s_;
  std::uint32_t demand_;
  CloudExtent extent_;
  CloudBounds bounds_;
  float extinction_per_m_;
  bool has_soft_particles_;
  const Buffer& placed_;
};

}  // namespace nephele
