// The barrier planner: a pure function from what the steps of a frame declare to the memory barriers between
// them. Knows nothing of Vulkan objects; tested without a device and printable in words.
#pragma once

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace nephele {

// How a step touches a resource. One table (barriers.cpp) gives stages and access masks.
enum class Access : std::uint8_t {
  uniform,             // uniform buffer, any shader stage
  sampled,             // sampled image, any shader stage
  texels,              // a buffer as uniform texel buffer of four 32-bit words a texel, any shader stage; as
                       // storage_read where the tuning reads storage buffers instead
  words,               // the same of one word a texel
  storage_read,        // storage buffer or image, read only
  storage_write,       // storage buffer or image, write only (whatever is not written keeps its value)
  storage_read_write,  // both, atomics included
  color,               // colour attachment (write, blend)
  color_ordered,       // colour and input attachment at once (rasterization-order access)
  indirect,            // arguments of an indirect dispatch or draw
  transfer_read,
  transfer_write,
  host_read,  // read by the CPU after the frame
};

struct AccessMasks {
  VkPipelineStageFlags2 stages;
  VkAccessFlags2 reads, writes;
};
AccessMasks access_masks(Access access);
const char* access_name(Access access);

struct ResourceUse {
  std::uint32_t resource;  // index given by the frame
  Access access;
};

struct StepDeclaration {
  std::string name;
  std::vector<ResourceUse> uses;
};

// Issued before a step; empty when no earlier access conflicts.
struct PlannedBarrier {
  VkPipelineStageFlags2 src_stages = 0, dst_stages = 0;
  VkAccessFlags2 src_access = 0, dst_access = 0;
  bool empty() const { return src_stages == 0; }
};

// One barrier per step, covering read-after-write, write-after-read and write-after-write hazards with all
// earlier steps since the last barrier that already covered them.
std::vector<PlannedBarrier> plan_barriers(std::span<const StepDeclaration> steps, std::size_t resource_count);

// The plan in words: one line a step with its accesses and barrier.
std::string describe_plan(std::span<const StepDeclaration> steps, std::span<const PlannedBarrier> barriers,
                          std::span<const std::string> resource_names);

}  // namespace nephele
