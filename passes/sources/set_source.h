// Particle sets placed in the world, from a list or scattered by the weather (shared/set_instances.h): each set's
// particles lie on the device once, whatever the number of its instances.
//
// reads -> writes: particles of the sets, instances or weather map -> particles, the source's record; particle_* of the
// counters
// cost: a thread an instance within the view distance, some fifty operations; a thread a particle, with a search of
// log2(2 * instances) steps.
//
// A frame is a function of the camera and the time alone. Places are exact to a fraction of a millimetre 10 000 km out,
// as of listed particles; of the lattice to a centimetre.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "passes/kit/cloud_source.h"
#include "passes/kit/prefix_sum.h"
#include "shared/set_instances.h"

namespace nephele {

class SetSource final : public CloudSource {
 public:
  // wind_m_per_s: of the scene, for sets that drift and name no wind of their own. smallest_angle: a coarser level
  // stands where what its particles resolve is below this share of the distance. At most `most` particles.
  SetSource(Workshop& make, std::string name, const PlacedSet& placed, const glm::dvec2& wind_m_per_s,
            const glm::dvec2& world_origin_m, float smallest_angle, std::uint32_t most);
  SetSource(Workshop& make, std::string name, const ScatteredSets& scattered, const glm::dvec2& wind_m_per_s,
            const glm::dvec2& world_origin_m, float smallest_angle, std::uint32_t most);

  CloudExtent extent() const override { return plan_.extent; }
  std::optional<CloudBounds> bounds() const override { return plan_.bounds; }
  float extinction_per_m() const override { return plan_.extinction_per_m; }
  bool has_soft_particles() const override { return plan_.soft; }
  InputBytes inputs(const FrameView& view) const override;
  void add(FrameBuilder& frame, const FrameView& view, const ParticleSink& sink) override;
  std::unique_ptr<CloudSource> evenly(Workshop& make, const std::string& name, double reach_m,
                                      double cell_m) const override;

 private:
  // All that is known before there is a device.
  struct Plan {
    std::vector<shared::SetParticleRecord> records;
    std::vector<shared::SetKind> kinds;
    std::vector<std::vector<float>> level_radii_m;  // of each kind: what its levels' particles resolve
    std::vector<shared::ListedInstance> listed;     // empty: a lattice
    std::vector<std::uint32_t> weather_texels;
    shared::SetConstants constants{};  // what does not change from frame to frame
    glm::dvec2 drift_m_per_s{0.0}, world_origin_m{0.0}, map_origin_m{0.0}, map_extent_m{0.0};
    CloudExtent extent{};
    std::optional<CloudBounds> bounds;
    float extinction_per_m = 0.0f;
    bool soft = false;
    double places_per_km2 = 0.0;  // of a lattice that is full, coverage counted
    std::uint32_t capacity = 0;
  };
  friend class SetPlanner;
  SetSource(Workshop& make, std::string name, Plan plan, std::uint32_t most);
  shared::SetConstants constants(const FrameView& view) const;

  Plan plan_;
  const ComputeKernel& instances_kernel_;
  const ComputeKernel& claim_;
  const ComputeKernel& particles_kernel_;
  PrefixSum scan_;
  const Buffer& records_;
  const Buffer& kinds_;
  const Buffer& listed_;
  const Buffer& weather_map_;
  const Buffer& constants_;
  const Buffer& instances_;
  const Buffer& begins_;  // of each entry's particles; counts before
  const Buffer& total_;
};

}  // namespace nephele
