#include "passes/sources/visibility.h"

#include <algorithm>

#include "nephele_shaders.h"
#include "shared/types.h"

namespace nephele {

using shared::FrameCounters;

Visibility::Visibility(Workshop& make, std::uint32_t particle_capacity)
    : test_(make.compute(shaders::visibility_comp)),
      list_(make.compute(shaders::visible_list_comp)),
      capacity_(particle_capacity),
      scan_(make, "visibility", capacity_ + 1),
      places_(make.buffer("visible_places", VkDeviceSize{capacity_ + 1} * sizeof(std::uint32_t))),
      visible_(make.buffer("visible", VkDeviceSize{std::max(capacity_, 1u)} * sizeof(std::uint32_t))) {}

const Buffer& Visibility::add(FrameBuilder& frame, const Buffer& frame_constants, const Buffer& particles,
                              const Buffer& counters) {
  const Indirect every_particle{&counters, offsetof(FrameCounters, particle_groups)};
  frame.fill("visibility", places_, 0);
  frame.compute({.name = "visibility",
                 .kernel = &test_,
                 .bindings = {{0, frame_constants, Access::uniform},
                              {1, particles, Access::texels},
                              {2, counters, Access::storage_read},
                              {3, places_, Access::storage_write}},
                 .indirect = every_particle});
  scan_.add(frame, "visibility", places_, capacity_ + 1, counters, offsetof(FrameCounters, visible_demand));
  frame.compute({.name = "visibility",
                 .kernel = &list_,
                 .bindings = {{0, places_, Access::storage_read},
                              {1, visible_, Access::storage_write},
                              {2, counters, Access::storage_read_write}},
                 .indirect = every_particle});
  return visible_;
}

}  // namespace nephele
