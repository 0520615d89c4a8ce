// A Vulkan 1.3 device with one compute + graphics queue, headless. Either made here or lent by a host.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "engine/result.h"
#include "engine/tuning.h"

namespace nephele {

// What a device offers, as far as it matters here.
struct DeviceInfo {
  std::uint32_t index = 0;
  std::string name;
  std::string driver;  // driver name and version
  VkPhysicalDeviceType type{};
  std::uint32_t api_version = 0;
  bool usable = false;                     // Vulkan 1.3 and every required feature
  std::string missing;                     // what keeps it from being usable, all of it
  bool fragment_shader_interlock = false;  // the interlock blending backend
  bool ordered_attachment_access = false;  // the attachment blending backend
  bool float_blending = false;             // of 32-bit colour attachments: the alpha blending backend
  bool fragment_count_query = false;       // pipeline statistics: optional, for the figures
  VkDeviceSize max_storage_buffer_bytes = 0;
  std::uint32_t max_texel_buffer_elements = 0;
  std::uint32_t max_groups = 0;                                 // of a dispatch along x
  std::uint32_t max_image_side_px = 0, max_volume_side_px = 0;  // of 2D and 3D images
  float timestamp_period_ns = 0;
};

struct DeviceOptions {
  std::string name_or_index;  // empty: the first discrete GPU, else the first usable device
  bool validation = false;    // Khronos validation with synchronisation validation; messages are counted
  std::string tuning;         // auto (or empty), cpu, gpu: see tuning.h
  // Further ones that a host enables for itself, to present for example. One that is missing is an error.
  std::vector<std::string> instance_extensions, device_extensions;
  // Reads NEPHELE_VALIDATION (1 = on) and, where no tuning is given, NEPHELE_TUNING.
  static DeviceOptions from_environment(std::string name_or_index = {}, std::string tuning = {});
};

// Vulkan objects that a host owns and lends. The device must have been created with the features that
// Device::create enables (required_features in device_needs.cpp lists them) and outlive everything made from it.
struct HostDevice {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
  bool fragment_shader_interlock = false;  // enabled on that device
  bool ordered_attachment_access = false;  // enabled on that device
  bool fragment_count_query = false;       // pipelineStatisticsQuery enabled on that device
  TuningKind tuning = TuningKind::automatic;
};

class Device {
 public:
  static Result<std::vector<DeviceInfo>> list();
  static Result<std::unique_ptr<Device>> create(const DeviceOptions& options);
  static std::unique_ptr<Device> adopt(const HostDevice& host);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const DeviceInfo& info() const { return info_; }
  const Tuning& tuning() const { return tuning_; }
  // Another tuning than options gave, before anything is made from the device.
  void set_tuning(const Tuning& tuning) { tuning_ = tuning; }
  // The most elements of that many bytes that fit a buffer which shaders read, as storage or (a multiple of 16 bytes as
  // texels of four words, others as words) in the tuning's way.
  VkDeviceSize max_elements(VkDeviceSize element_bytes) const;
  VkInstance instance() const { return instance_; }
  VkDevice vk() const { return device_; }
  VkPhysicalDevice physical() const { return physical_; }
  VkQueue queue() const { return queue_; }
  std::uint32_t queue_family() const { return queue_family_; }
  VkSampler linear_clamp() const { return linear_clamp_; }
  VkSampler linear_repeat() const { return linear_repeat_; }
  VkSampler nearest_clamp() const { return nearest_clamp_; }

  // The queue takes one thread at a time. All of Nephele's own submissions hold this mutex; a host that uses the queue
  // of a device made here, while another of its threads is in Nephele, holds it too.
  std::mutex& queue_mutex() { return queue_mutex_; }
  void submit(const VkSubmitInfo2& submit, VkFence fence);

  std::uint32_t memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags wanted) const;

  // Runs record(command_buffer) on the queue and waits. For set-up work, not for frames.
  template <class Record>
  void run_once(Record&& record) {
    const VkCommandBuffer commands = begin_once();
    record(commands);
    end_once(commands);
  }

  // Names a Vulkan object for validation messages and captures. No effect without validation.
  void set_name(VkObjectType type, std::uint64_t handle, const std::string& name) const;

  // Bytes of device memory allocated through this device and not yet freed.
  VkDeviceSize allocated_bytes() const { return allocated_bytes_; }
  // Allocations made so far, the freed ones included.
  std::uint64_t allocation_count() const { return allocation_count_; }
  void count_allocation(VkDeviceSize bytes) {
    allocated_bytes_ += bytes;
    ++allocation_count_;
  }
  void count_free(VkDeviceSize bytes) { allocated_bytes_ -= bytes; }

  // Validation warnings and errors since the program started, over all devices.
  static std::uint64_t validation_messages();

 private:
  Device() = default;
  void create_common();
  VkCommandBuffer begin_once();
  void end_once(VkCommandBuffer commands);

  bool owned_ = false;
  DeviceInfo info_;
  Tuning tuning_{};
  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkPhysicalDeviceMemoryProperties memory_{};
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  std::uint32_t queue_family_ = 0;
  std::mutex queue_mutex_;
  VkCommandPool once_pool_ = VK_NULL_HANDLE;
  VkFence once_fence_ = VK_NULL_HANDLE;
  VkSampler linear_clamp_ = VK_NULL_HANDLE, linear_repeat_ = VK_NULL_HANDLE, nearest_clamp_ = VK_NULL_HANDLE;
  PFN_vkSetDebugUtilsObjectNameEXT set_object_name_ = nullptr;
  VkDeviceSize allocated_bytes_ = 0;
  std::uint64_t allocation_count_ = 0;
};

}  // namespace nephele
