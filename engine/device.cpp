#include "engine/device.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "engine/check.h"
#include "engine/device_needs.h"

namespace nephele {
namespace {

std::atomic<std::uint64_t> validation_message_count{0};

VKAPI_ATTR VkBool32 VKAPI_CALL on_validation_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                     VkDebugUtilsMessageTypeFlagsEXT,
                                                     const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
  validation_message_count.fetch_add(1);
  std::fprintf(stderr, "vulkan validation: %s\n", data->pMessage);
  return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messenger_info() {
  VkDebugUtilsMessengerCreateInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  info.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  info.pfnUserCallback = on_validation_message;
  return info;
}

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

bool has_validation_layer() {
  std::uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.end(),
                     [](const auto& l) { return std::strcmp(l.layerName, kValidationLayer) == 0; });
}

std::vector<const char*> c_strings(const std::vector<std::string>& texts) {
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  return pointers;
}

std::string join(const std::vector<std::string>& names) {
  std::string joined;
  for (const std::string& name : names) joined += (joined.empty() ? "" : ", ") + name;
  return joined;
}

Result<VkInstance> create_instance(bool validation, std::vector<std::string> extensions = {}) {
  if (validation && !has_validation_layer())
    return Error{
        "validation was asked for (NEPHELE_VALIDATION=1), but the layer VK_LAYER_KHRONOS_validation is not installed"};
  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.pApplicationName = "nephele";
  application.apiVersion = VK_API_VERSION_1_3;
  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  info.pApplicationInfo = &application;
  VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info();
  const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = enabled;
  features.pNext = &messenger;
  const char* layers[] = {kValidationLayer};
  if (validation) {
    extensions.emplace_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = layers;
    info.pNext = &features;
  }
  const std::vector<const char*> names = c_strings(extensions);
  info.enabledExtensionCount = static_cast<std::uint32_t>(names.size());
  info.ppEnabledExtensionNames = names.data();
  VkInstance instance = VK_NULL_HANDLE;
  const VkResult result = vkCreateInstance(&info, nullptr, &instance);
  if (result == VK_ERROR_EXTENSION_NOT_PRESENT)
    return Error{concat("Vulkan lacks one of the instance extensions ", join(extensions))};
  if (result != VK_SUCCESS)
    return Error{concat("no Vulkan 1.3 driver could be loaded (VkResult ", static_cast<int>(result),
                        "); Debian's package mesa-vulkan-drivers provides one that needs no GPU")};
  return instance;
}

bool has_extension(VkPhysicalDevice physical, const std::string& name) {
  std::uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, extensions.data());
  return std::any_of(extensions.begin(), extensions.end(), [&](const auto& e) { return name == e.extensionName; });
}

constexpr std::uint32_t kNoQueue = ~0u;

std::uint32_t find_queue_family(VkPhysicalDevice physical) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  const VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  for (std::uint32_t i = 0; i < count; ++i)
    if ((families[i].queueFlags & wanted) == wanted && families[i].timestampValidBits > 0) return i;
  return kNoQueue;
}

DeviceInfo query_info(VkPhysicalDevice physical, std::uint32_t index) {
  VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  vkGetPhysicalDeviceProperties(physical, &properties.properties);
  DeviceInfo info;
  info.index = index;
  info.name = properties.properties.deviceName;
  info.type = properties.properties.deviceType;
  info.api_version = properties.properties.apiVersion;
  const VkPhysicalDeviceLimits& limits = properties.properties.limits;
  info.max_storage_buffer_bytes = limits.maxStorageBufferRange;
  info.max_texel_buffer_elements = limits.maxTexelBufferElements;
  info.max_groups = limits.maxComputeWorkGroupCount[0];
  info.max_image_side_px =
      std::min({limits.maxImageDimension2D, limits.maxFramebufferWidth, limits.maxFramebufferHeight});
  info.max_volume_side_px = limits.maxImageDimension3D;
  info.timestamp_period_ns = limits.timestampPeriod;
  if (info.api_version < VK_API_VERSION_1_3) {
    info.missing = "Vulkan 1.3";
    return info;
  }
  properties.pNext = &driver;
  vkGetPhysicalDeviceProperties2(physical, &properties);
  info.driver = concat(driver.driverName, " ", driver.driverInfo);

  const bool interlock = has_extension(physical, VK_EXT_FRAGMENT_SHADER_INTERLOCK_EXTENSION_NAME);
  const bool ordered = has_extension(physical, VK_EXT_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_EXTENSION_NAME);
  FeatureChain features;
  features.link(interlock, ordered);
  vkGetPhysicalDeviceFeatures2(physical, &features.core);
  info.fragment_shader_interlock = interlock && features.interlock.fragmentShaderPixelInterlock;
  info.ordered_attachment_access = ordered && features.ordered.rasterizationOrderColorAttachmentAccess;
  info.fragment_count_query = features.core.features.pipelineStatisticsQuery;
  const auto format_features = [&](VkFormat format) {
    VkFormatProperties of_format{};
    vkGetPhysicalDeviceFormatProperties(physical, format, &of_format);
    return of_format.optimalTilingFeatures;
  };
  info.float_blending = format_features(VK_FORMAT_R32G32B32A32_SFLOAT) & format_features(VK_FORMAT_R32_SFLOAT) &
                        VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT;
  info.missing = what_is_missing(features, limits, format_features);
  if (find_queue_family(physical) == kNoQueue)
    info.missing =
        concat("a queue for graphics and compute with timestamps", info.missing.empty() ? "" : ", ", info.missing);
  info.usable = info.missing.empty();
  return info;
}

std::vector<VkPhysicalDevice> physical_devices(VkInstance instance) {
  std::uint32_t count = 0;
  NEPHELE_VK(vkEnumeratePhysicalDevices(instance, &count, nullptr));
  std::vector<VkPhysicalDevice> devices(count);
  NEPHELE_VK(vkEnumeratePhysicalDevices(instance, &count, devices.data()));
  return devices;
}

Result<std::uint32_t> choose_device(const std::vector<DeviceInfo>& infos, const std::string& wanted) {
  if (infos.empty())
    return Error{"no Vulkan device was found; Debian's package mesa-vulkan-drivers provides one that needs no GPU"};
  std::string names;
  for (const DeviceInfo& info : infos) names += concat(names.empty() ? "" : ", ", info.index, " = ", info.name);
  std::optional<std::uint32_t> match;
  if (wanted.empty()) {
    for (const DeviceInfo& info : infos)
      if (info.usable && (!match || device_preference(info) > device_preference(infos[*match]))) match = info.index;
    if (!match)
      return Error{
          concat("no device has Vulkan 1.3 and what Nephele needs (", names, "; first lacks ", infos[0].missing, ")")};
    return *match;
  }
  std::uint32_t index = 0;
  const auto parsed = std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);
  const bool is_index = parsed.ec == std::errc{} && parsed.ptr == wanted.data() + wanted.size();
  if (is_index && index < infos.size()) match = index;
  if (!is_index)
    for (const DeviceInfo& info : infos)
      if (!match && info.name.find(wanted) != std::string::npos) match = info.index;
  if (!match) return Error{concat("unknown device '", wanted, "'; this machine has: ", names)};
  if (!infos[*match].usable) return Error{concat("device '", infos[*match].name, "' lacks ", infos[*match].missing)};
  return *match;
}

std::vector<DeviceInfo> query_all(const std::vector<VkPhysicalDevice>& devices) {
  std::vector<DeviceInfo> infos;
  for (std::uint32_t i = 0; i < devices.size(); ++i) infos.push_back(query_info(devices[i], i));
  return infos;
}

}  // namespace

DeviceOptions DeviceOptions::from_environment(std::string name_or_index, std::string tuning) {
  const char* validation = std::getenv("NEPHELE_VALIDATION");
  const char* wanted = std::getenv("NEPHELE_TUNING");
  if (tuning.empty() && wanted) tuning = wanted;
  return {std::move(name_or_index), validation && std::string(validation) == "1", std::move(tuning)};
}

Result<std::vector<DeviceInfo>> Device::list() {
  Result<VkInstance> instance = create_instance(false);
  if (!instance) return instance.error();
  std::vector<DeviceInfo> infos = query_all(physical_devices(*instance));
  vkDestroyInstance(*instance, nullptr);
  return infos;
}

Result<std::unique_ptr<Device>> Device::create(const DeviceOptions& options) {
  const Result<TuningKind> tuning = parse_tuning_kind(options.tuning);
  if (!tuning) return tuning.error();
  Result<VkInstance> instance = create_instance(options.validation, options.instance_extensions);
  if (!instance) return instance.error();
  const std::vector<VkPhysicalDevice> devices = physical_devices(*instance);
  const std::vector<DeviceInfo> infos = query_all(devices);
  const Result<std::uint32_t> chosen = choose_device(infos, options.name_or_index);
  if (!chosen) {
    vkDestroyInstance(*instance, nullptr);
    return chosen.error();
  }
  for (const std::string& extension : options.device_extensions)
    if (!has_extension(devices[*chosen], extension)) {
      vkDestroyInstance(*instance, nullptr);
      return Error{concat("device '", infos[*chosen].name, "' lacks ", extension)};
    }

  std::unique_ptr<Device> device(new Device);
  device->owned_ = true;
  device->instance_ = *instance;
  device->physical_ = devices[*chosen];
  device->info_ = infos[*chosen];
  device->tuning_ = tuning_for(device->info_, *tuning);
  device->queue_family_ = find_queue_family(device->physical_);
  if (options.validation) {
    const auto create_messenger = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(*instance, "vkCreateDebugUtilsMessengerEXT"));
    const VkDebugUtilsMessengerCreateInfoEXT info = messenger_info();
    NEPHELE_VK(create_messenger(*instance, &info, nullptr, &device->messenger_));
    device->set_object_name_ = reinterpret_cast<PFN_vkSetDebugUtilsObjectNameEXT>(
        vkGetInstanceProcAddr(*instance, "vkSetDebugUtilsObjectNameEXT"));
  }

  FeatureChain features;
  features.link(device->info_.fragment_shader_interlock, device->info_.ordered_attachment_access);
  for (const RequiredFeature& feature : required_features(features)) *feature.value = VK_TRUE;
  features.core.features.pipelineStatisticsQuery = device->info_.fragment_count_query;
  features.interlock.fragmentShaderPixelInterlock = VK_TRUE;
  features.ordered.rasterizationOrderColorAttachmentAccess = VK_TRUE;
  std::vector<std::string> extensions = options.device_extensions;
  if (device->info_.fragment_shader_interlock) extensions.emplace_back(VK_EXT_FRAGMENT_SHADER_INTERLOCK_EXTENSION_NAME);
  if (device->info_.ordered_attachment_access)
    extensions.emplace_back(VK_EXT_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_EXTENSION_NAME);

  const float priority = 1.0f;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = device->queue_family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkDeviceCreateInfo create{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
  create.pNext = &features.core;
  create.queueCreateInfoCount = 1;
  create.pQueueCreateInfos = &queue;
  const std::vector<const char*> names = c_strings(extensions);
  create.enabledExtensionCount = static_cast<std::uint32_t>(names.size());
  create.ppEnabledExtensionNames = names.data();
  NEPHELE_VK(vkCreateDevice(device->physical_, &create, nullptr, &device->device_));
  vkGetDeviceQueue(device->device_, device->queue_family_, 0, &device->queue_);
  device->create_common();
  return device;
}

std::unique_ptr<Device> Device::adopt(const HostDevice& host) {
  std::unique_ptr<Device> device(new Device);
  device->instance_ = host.instance;
  device->physical_ = host.physical_device;
  device->device_ = host.device;
  device->queue_ = host.queue;
  device->queue_family_ = host.queue_family;
  device->info_ = query_info(host.physical_device, 0);
  device->info_.fragment_shader_interlock = host.fragment_shader_interlock;
  device->info_.ordered_attachment_access = host.ordered_attachment_access;
  device->info_.fragment_count_query = host.fragment_count_query;
  device->tuning_ = tuning_for(device->info_, host.tuning);
  device->create_common();
  return device;
}

void Device::create_common() {
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = queue_family_;
  NEPHELE_VK(vkCreateCommandPool(device_, &pool, nullptr, &once_pool_));
  const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
  NEPHELE_VK(vkCreateFence(device_, &fence, nullptr, &once_fence_));

  const auto make_sampler = [&](VkFilter filter, VkSamplerAddressMode address) {
    VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    info.magFilter = info.minFilter = filter;
    info.addressModeU = info.addressModeV = info.addressModeW = address;
    VkSampler sampler = VK_NULL_HANDLE;
    NEPHELE_VK(vkCreateSampler(device_, &info, nullptr, &sampler));
    return sampler;
  };
  linear_clamp_ = make_sampler(VK_FILTER_LINEAR, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
  linear_repeat_ = make_sampler(VK_FILTER_LINEAR, VK_SAMPLER_ADDRESS_MODE_REPEAT);
  nearest_clamp_ = make_sampler(VK_FILTER_NEAREST, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
}

Device::~Device() {
  for (VkSampler sampler : {linear_clamp_, linear_repeat_, nearest_clamp_}) vkDestroySampler(device_, sampler, nullptr);
  vkDestroyFence(device_, once_fence_, nullptr);
  vkDestroyCommandPool(device_, once_pool_, nullptr);
  if (!owned_) return;
  vkDestroyDevice(device_, nullptr);
  if (messenger_) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    destroy(instance_, messenger_, nullptr);
  }
  vkDestroyInstance(instance_, nullptr);
}

VkDeviceSize Device::max_elements(VkDeviceSize element_bytes) const {
  const VkDeviceSize stored = info_.max_storage_buffer_bytes / element_bytes;
  if (!tuning_.texel_buffers) return stored;
  const VkDeviceSize texel_bytes = element_bytes % 16 == 0 ? 16 : 4;
  return std::min(stored, info_.max_texel_buffer_elements * texel_bytes / element_bytes);
}

std::uint32_t Device::memory_type(std::uint32_t type_bits, VkMemoryPropertyFlags wanted) const {
  for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i)
    if ((type_bits & (1u << i)) && (memory_.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
  NEPHELE_CHECK(false, "no memory type with properties ", wanted, " among bits ", type_bits);
  return 0;
}

VkCommandBuffer Device::begin_once() {
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = once_pool_;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  NEPHELE_VK(vkAllocateCommandBuffers(device_, &allocate, &commands));
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  NEPHELE_VK(vkBeginCommandBuffer(commands, &begin));
  return commands;
}

void Device::end_once(VkCommandBuffer commands) {
  NEPHELE_VK(vkEndCommandBuffer(commands));
  VkCommandBufferSubmitInfo command_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
  command_info.commandBuffer = commands;
  VkSubmitInfo2 submit{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &command_info;
  this->submit(submit, once_fence_);
  NEPHELE_VK(vkWaitForFences(device_, 1, &once_fence_, VK_TRUE, UINT64_MAX));
  NEPHELE_VK(vkResetFences(device_, 1, &once_fence_));
  vkFreeCommandBuffers(device_, once_pool_, 1, &commands);
}

void Device::submit(const VkSubmitInfo2& submit, VkFence fence) {
  const std::lock_guard lock(queue_mutex_);
  NEPHELE_VK(vkQueueSubmit2(queue_, 1, &submit, fence));
}

void Device::set_name(VkObjectType type, std::uint64_t handle, const std::string& name) const {
  if (!set_object_name_) return;
  VkDebugUtilsObjectNameInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT};
  info.objectType = type;
  info.objectHandle = handle;
  info.pObjectName = name.c_str();
  set_object_name_(device_, &info);
}

std::uint64_t Device::validation_messages() { return validation_message_count.load(); }

}  // namespace nephele
