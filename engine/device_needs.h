// What Nephele needs of a Vulkan device, and the line that says what a device lacks.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace nephele {

// The features that are asked about and enabled, with the two optional ordering extensions chained behind.
struct FeatureChain {
  VkPhysicalDeviceFeatures2 core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
  VkPhysicalDeviceVulkan12Features v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  VkPhysicalDeviceFragmentShaderInterlockFeaturesEXT interlock{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FRAGMENT_SHADER_INTERLOCK_FEATURES_EXT};
  VkPhysicalDeviceRasterizationOrderAttachmentAccessFeaturesEXT ordered{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_FEATURES_EXT};

  void link(bool with_interlock, bool with_ordered);
};

// A feature that every device must have, in a chain that a device has filled or that is about to enable it.
struct RequiredFeature {
  const char* name;  // as Vulkan spells it
  VkBool32* value;
};
std::vector<RequiredFeature> required_features(FeatureChain& chain);

// A limit that the shaders or the frame reach.
struct RequiredLimit {
  const char* name;  // as Vulkan spells it
  std::uint32_t least;
  std::uint32_t (*of)(const VkPhysicalDeviceLimits& limits);
};
const std::vector<RequiredLimit>& required_limits();

// A format of images, and what is done with them.
struct RequiredFormat {
  const char* name;
  VkFormat format;
  VkFormatFeatureFlags features;
};
const std::vector<RequiredFormat>& required_formats();

// Everything that a device of Vulkan 1.3 lacks, separated by commas, each limit and format with what is needed; empty
// when the device will do.
std::string what_is_missing(FeatureChain& offered, const VkPhysicalDeviceLimits& limits,
                            const std::function<VkFormatFeatureFlags(VkFormat)>& format_features);

}  // namespace nephele
