// The particles of a frame: those of all sources, one source after another, and the list of the ones the camera may
// see.
//
// reads -> writes: frame constants -> particles, visible list, the sources' records; particle_*, visible_* and draw of
// the counters, the rest of them 0
// cost: the sources', then visibility's.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "passes/kit/cloud_source.h"
#include "passes/sources/visibility.h"

namespace nephele {

class CloudParticles {
 public:
  struct Outputs {
    const Buffer& particles;  // Particle; slots [0, particle_count) are filled
    const Buffer& visible;    // uint: indices of particles, ascending
    const Buffer& counters;   // FrameCounters
    const Buffer& records;    // SourceRecord of each source
  };

  CloudParticles(Workshop& make, std::vector<std::unique_ptr<CloudSource>> sources);

  // Steps: one row a source, "visibility".
  Outputs add(FrameBuilder& frame, const Buffer& frame_constants, const FrameView& view);

  // Equal bytes: equal particles.
  InputBytes inputs(const FrameView& view) const;

  std::uint32_t capacity() const { return capacity_; }
  CloudExtent extent() const;       // of all sources together
  bool has_soft_particles() const;  // any source
  VkDeviceSize records_bytes() const { return sources_.size() * sizeof(shared::SourceRecord); }
  const std::vector<std::unique_ptr<CloudSource>>& sources() const { return sources_; }

 private:
  std::vector<std::unique_ptr<CloudSource>> sources_;
  std::uint32_t capacity_;
  Visibility visibility_;
  const Buffer& particles_;
  const Buffer& counters_;
  const Buffer& records_;
};

}  // namespace nephele
