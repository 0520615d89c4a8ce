#include "engine/tuning.h"

#include "engine/check.h"
#include "engine/device.h"

namespace nephele {
namespace {

// Texels that one buffer of a frame may hold: 1920 x 1080 pixels have 32 400 tiles with room for 256 (tile, particle)
// pairs each, two words a pair in the largest array. Vulkan guarantees no more than 65 536.
constexpr std::uint32_t kTexelsOfAFrame = 1u << 24;

// A software driver runs eight threads in step on each core. Cache misses and dispatches are dear, threads are few.
Tuning cpu_tuning(const DeviceInfo& device) {
  Tuning tuning{};
  tuning.kind = TuningKind::cpu;
  // Lavapipe loads storage buffers lane by lane and word by word, but gathers four words of a texel for eight threads.
  tuning.texel_buffers = device.max_texel_buffer_elements >= kTexelsOfAFrame;
  // Every lane goes through every branch, so threads with work of one kind are worth a stack of segments in memory; and
  // a filtered fetch is done in software, which bytes by integer arithmetic beat.
  tuning.pixel_columns = true;
  // Lavapipe ends all loops of eight threads once they have gone round this often.
  tuning.loop_rounds = 65535;
  // A place of a list takes eight rounds, and up to ten where many particles overlap.
  tuning.exact_places = 6144;
  // A dispatch costs as much as some thousand values: long runs take fewer levels.
  tuning.sum_run = 256;
  tuning.sum_local_size = 16;
  // Some sixty threads, eight in a batch, keep all cores busy, and their table of counts is short.
  tuning.sort_run = 512;
  tuning.sort_max_threads = 64;
  tuning.sort_local_size = 8;
  return tuning;
}

// Hardware wants thousands of threads in groups of its own width (32 or 64).
Tuning gpu_tuning() {
  Tuning tuning{};
  tuning.kind = TuningKind::gpu;
  // Hardware loads four words of a storage buffer at once, and storage buffers have no limit of elements.
  tuning.texel_buffers = false;
  // Branches cost only those who take them, and a texture unit filters for nothing.
  tuning.pixel_columns = false;
  tuning.loop_rounds = ~0u;
  tuning.exact_places = 1u << 20;
  tuning.sum_run = 64;
  tuning.sum_local_size = 64;
  // Runs shorter than this would make the table of counts longer than the data.
  tuning.sort_run = 128;
  tuning.sort_max_threads = 8192;
  tuning.sort_local_size = 32;
  return tuning;
}

}  // namespace

const char* tuning_kind_name(TuningKind kind) {
  switch (kind) {
    case TuningKind::cpu:
      return "cpu";
    case TuningKind::gpu:
      return "gpu";
    case TuningKind::automatic:
      break;
  }
  return "auto";
}

Result<TuningKind> parse_tuning_kind(const std::string& s) {
  if (s.empty()) return TuningKind::automatic;
  for (const TuningKind kind : {TuningKind::automatic, TuningKind::cpu, TuningKind::gpu})
    if (s == tuning_kind_name(kind)) return kind;
  return Error{concat("unknown tuning '", s, "'; accepted: auto, cpu, gpu")};
}

Tuning tuning_for(const DeviceInfo& device, TuningKind wanted) {
  const bool cpu =
      wanted == TuningKind::automatic ? device.type == VK_PHYSICAL_DEVICE_TYPE_CPU : wanted == TuningKind::cpu;
  return cpu ? cpu_tuning(device) : gpu_tuning();
}

const char* device_type_name(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "CPU";
    default:
      return "other";
  }
}

int device_preference(const DeviceInfo& device) { return device.type == VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU ? 1 : 0; }

}  // namespace nephele
