// A frame is an explicit, ordered list of steps. Each step names the resources it touches and how; the
// barriers between steps are derived (barriers.h), descriptor sets are written, timestamps are taken by name.
//
//   FrameBuilder frame(executor);
//   frame.compute({.name = "sort", .kernel = &histogram, .bindings = {{0, keys, Access::storage_read},
//                  {1, counts, Access::storage_write}}, .push = as_push(params), .groups = {n, 1, 1}});
//   executor.run(frame);
//
// The list is rebuilt every frame (it costs microseconds), so a step that a scene doesn't need is not there; nor is one
// whose result stands from an earlier frame (FrameBuilder::stands).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "engine/barriers.h"
#include "engine/kernel.h"
#include "engine/pass_time.h"
#include "engine/resources.h"
#include "engine/step_memory.h"

namespace nephele {

enum class Sampler : std::uint8_t { linear_clamp, linear_repeat, nearest_clamp };

// Buffer or image; the objects must outlive the frame's execution.
using ResourceRef = std::variant<const Buffer*, const Image*>;

// A resource at a binding of set 0. Its access must agree with what the shader's reflection says.
struct Binding {
  std::uint32_t binding;
  ResourceRef resource;
  Access access;
  Sampler sampler = Sampler::linear_clamp;

  Binding(std::uint32_t at, const Buffer& buffer, Access how) : binding(at), resource(&buffer), access(how) {}
  Binding(std::uint32_t at, const Image& image, Access how, Sampler with = Sampler::linear_clamp)
      : binding(at), resource(&image), access(how), sampler(with) {}
};

using PushConstants = std::vector<std::byte>;
template <class T>
PushConstants as_push(const T& value) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&value);
  return PushConstants(bytes, bytes + sizeof(T));
}

// Arguments read from a buffer by the device: 3 uints for a dispatch, 4 for a draw.
struct Indirect {
  const Buffer* buffer = nullptr;
  VkDeviceSize offset = 0;
};

struct ComputeStep {
  std::string name;  // the pass's row in the timings; several steps may share it
  const ComputeKernel* kernel = nullptr;
  std::vector<Binding> bindings;
  PushConstants push;
  std::array<std::uint32_t, 3> groups = {1, 1, 1};  // ignored when indirect
  Indirect indirect;
};

struct RasterStep {
  std::string name;
  const RasterPipeline* pipeline = nullptr;
  std::vector<Binding> bindings;  // input attachments of an ordered pipeline are bound here as color_ordered
  PushConstants push;
  std::vector<const Image*> color;          // attachments, in order
  std::vector<std::array<float, 4>> clear;  // clear values, one per attachment
  std::uint32_t vertex_count = 0;           // ignored when indirect
  Indirect indirect;
};

class FrameExecutor;

// How long what a step leaves may serve later frames.
enum class Keep : std::uint8_t {
  while_equal,  // as long as its inputs stay equal; not at all in frames built with Reuse::lasting
  lasting,      // the same, and in those frames too: tables and noise that outlast every camera
};
enum class Reuse : std::uint8_t { all, lasting };

class FrameBuilder {
 public:
  // A frame that does all its work.
  explicit FrameBuilder(Device&) {}
  // A frame that may leave out what stands from frames that the executor has recorded.
  explicit FrameBuilder(FrameExecutor& executor, Reuse reuse = Reuse::all);

  // Whether the resource holds what steps with these inputs would write into it. If not, the caller adds those steps;
  // once the frame has been recorded, the resource counts as made from these inputs.
  bool stands(const ResourceRef& resource, InputBytes inputs, Keep keep = Keep::while_equal);

  // The same without a claim: whether an earlier frame has left that there. Never in frames built with Reuse::lasting.
  bool holds(const ResourceRef& resource, const InputBytes& inputs) const;
  Reuse reuse() const { return reuse_; }

  void compute(ComputeStep step);
  void raster(RasterStep step);
  // Fills a buffer with a 32-bit value.
  void fill(std::string name, const Buffer& buffer, std::uint32_t value);
  // Writes up to 64 KiB at offset 0 from the CPU, in frame order.
  void update(std::string name, const Buffer& buffer, std::vector<std::byte> data);
  // Copies a whole image or the first `bytes` of a buffer to a read-back buffer, readable after the frame.
  void read_back(std::string name, const Image& image, const Buffer& to);
  void read_back(std::string name, const Buffer& buffer, const Buffer& to, VkDeviceSize bytes);

  const std::vector<StepDeclaration>& declarations() const { return declarations_; }
  std::vector<PlannedBarrier> plan() const;
  std::string describe() const;  // the plan in words

 private:
  friend class FrameExecutor;
  using RecordFunction = std::function<void(VkCommandBuffer, class FrameExecutor&)>;
  struct Step {
    RecordFunction record;
  };
  std::uint32_t resource_index(const ResourceRef& resource);
  // Is a resource's content made from these inputs, by this frame's steps so far or by frames before?
  bool held(std::uint64_t id, const InputBytes& inputs) const;
  void add(std::string name, const std::vector<std::pair<ResourceRef, Access>>& uses, RecordFunction record);

  const StepMemory* memory_ = nullptr;
  Reuse reuse_ = Reuse::all;
  std::vector<StepMemory::Claim> claims_;
  std::vector<ResourceRef> resources_;
  std::vector<std::string> resource_names_;
  std::vector<StepDeclaration> declarations_;
  std::vector<Step> steps_;
};

// Frames that may be on their way through the device at once. What a frame needs for itself alone (descriptor sets,
// framebuffers, queries, read-back buffers) exists so many times.
inline constexpr std::uint32_t kFramesInFlight = 2;

// Records and runs frames, and remembers what they left (StepMemory).
class FrameExecutor {
 public:
  explicit FrameExecutor(Device& device);
  ~FrameExecutor();
  FrameExecutor(const FrameExecutor&) = delete;
  FrameExecutor& operator=(const FrameExecutor&) = delete;

  // Records, submits and waits. Times of all passes are available afterwards.
  void run(const FrameBuilder& frame);
  // Records into a host's command buffer; the host submits its command buffers in the order they were recorded in. Up
  // to kFramesInFlight frames may be under way: before frame n is recorded, frame n - kFramesInFlight must have
  // finished.
  void record(const FrameBuilder& frame, VkCommandBuffer commands);

  // Frames recorded so far; the next one uses slot frames_recorded() % kFramesInFlight of whatever is kept per frame.
  std::uint64_t frames_recorded() const { return frames_recorded_; }

  // GPU milliseconds per pass name, in frame order, of the last recorded frame or one of the kFramesInFlight - 1 before
  // it; the frame must have finished.
  std::vector<PassTime> pass_times(std::uint32_t frames_ago = 0);

  // Fragment shader invocations of that frame's raster steps; 0 where the device can't count them.
  std::uint64_t fragments_shaded(std::uint32_t frames_ago = 0);

  // What recorded frames left. A host that recorded a frame and will not submit it has to clear it.
  StepMemory& memory() { return memory_; }

  // For the steps' own recording.
  void begin_fragment_count(VkCommandBuffer commands);
  void end_fragment_count(VkCommandBuffer commands);
  VkDescriptorSet allocate_set(const PipelineLayout& layout, const std::vector<Binding>& bindings);
  VkFramebuffer framebuffer(const RasterPipeline& pipeline, const std::vector<const Image*>& color);

 private:
  friend class FrameBuilder;
  // What one frame under way needs for itself.
  struct Slot {
    VkDescriptorPool descriptors = VK_NULL_HANDLE;
    VkQueryPool queries = VK_NULL_HANDLE;
    std::uint32_t query_capacity = 0, set_capacity = 0;
    VkQueryPool fragment_queries = VK_NULL_HANDLE;  // null: not supported
    std::uint32_t raster_steps = 0;
    std::vector<std::string> step_names;
    std::vector<VkFramebuffer> framebuffers;
  };
  void make_slot(Slot& slot);
  void make_descriptors(Slot& slot, std::uint32_t sets);
  Slot& begin_frame(std::size_t step_count);
  Slot& slot_of(std::uint32_t frames_ago);

  Device& device_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  std::array<Slot, kFramesInFlight> slots_;
  Slot* recording_ = nullptr;  // the slot of the frame that is being recorded
  std::uint64_t frames_recorded_ = 0;
  StepMemory memory_;
};

}  // namespace nephele
