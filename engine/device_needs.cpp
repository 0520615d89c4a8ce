#include "engine/device_needs.h"

#include "engine/check.h"

namespace nephele {
namespace {

struct FormatUse {
  VkFormatFeatureFlagBits feature;
  const char* name;
};
constexpr FormatUse kFormatUses[] = {{VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT, "sampling"},
                                     {VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT, "linear filtering"},
                                     {VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT, "storage images"}};

constexpr VkFormatFeatureFlags kSampled = VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
constexpr VkFormatFeatureFlags kFiltered = kSampled | VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
constexpr VkFormatFeatureFlags kStored = VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;

}  // namespace

void FeatureChain::link(bool with_interlock, bool with_ordered) {
  core.pNext = &v12;
  v12.pNext = &v13;
  void** tail = &v13.pNext;
  if (with_interlock) {
    *tail = &interlock;
    tail = &interlock.pNext;
  }
  if (with_ordered) *tail = &ordered;
}

std::vector<RequiredFeature> required_features(FeatureChain& chain) {
  VkPhysicalDeviceFeatures& core = chain.core.features;
  return {
      {"fragmentStoresAndAtomics", &core.fragmentStoresAndAtomics},                    // counts of shaded pairs
      {"independentBlend", &core.independentBlend},                                    // backend alpha
      {"shaderStorageImageExtendedFormats", &core.shaderStorageImageExtendedFormats},  // noise in R8, lattice in R16F
      {"scalarBlockLayout", &chain.v12.scalarBlockLayout},                             // structures as C++ has them
      {"synchronization2", &chain.v13.synchronization2},                               // barriers, timestamps
      {"maintenance4", &chain.v13.maintenance4},  // LocalSizeId, which glslang emits for Vulkan 1.3
  };
}

const std::vector<RequiredLimit>& required_limits() {
  using Limits = VkPhysicalDeviceLimits;
  // Counts of bindings are those of the shader with the most; a test compares them with the embedded shaders.
  static const std::vector<RequiredLimit> limits = {
      {"maxComputeWorkGroupInvocations", 64, [](const Limits& l) { return l.maxComputeWorkGroupInvocations; }},
      {"maxComputeWorkGroupSize[0]", 64, [](const Limits& l) { return l.maxComputeWorkGroupSize[0]; }},
      {"maxComputeWorkGroupSize[1]", 8, [](const Limits& l) { return l.maxComputeWorkGroupSize[1]; }},
      {"maxComputeWorkGroupSize[2]", 4, [](const Limits& l) { return l.maxComputeWorkGroupSize[2]; }},
      {"maxComputeWorkGroupCount[0]", 65535, [](const Limits& l) { return l.maxComputeWorkGroupCount[0]; }},
      {"maxPushConstantsSize", 128, [](const Limits& l) { return l.maxPushConstantsSize; }},
      {"maxUniformBufferRange", 16384, [](const Limits& l) { return l.maxUniformBufferRange; }},
      {"maxStorageBufferRange", 1u << 27, [](const Limits& l) { return l.maxStorageBufferRange; }},
      {"maxPerStageDescriptorUniformBuffers", 1, [](const Limits& l) { return l.maxPerStageDescriptorUniformBuffers; }},
      {"maxPerStageDescriptorStorageBuffers", 8, [](const Limits& l) { return l.maxPerStageDescriptorStorageBuffers; }},
      {"maxPerStageDescriptorStorageImages", 4, [](const Limits& l) { return l.maxPerStageDescriptorStorageImages; }},
      {"maxPerStageDescriptorSampledImages", 16, [](const Limits& l) { return l.maxPerStageDescriptorSampledImages; }},
      {"maxPerStageDescriptorSamplers", 16, [](const Limits& l) { return l.maxPerStageDescriptorSamplers; }},
      {"maxPerStageResources", 24, [](const Limits& l) { return l.maxPerStageResources; }},
      {"maxColorAttachments", 4, [](const Limits& l) { return l.maxColorAttachments; }},
  };
  return limits;
}

const std::vector<RequiredFormat>& required_formats() {
  static const std::vector<RequiredFormat> formats = {
      {"R8_UNORM", VK_FORMAT_R8_UNORM, kFiltered | kStored},                        // noise
      {"R16_SFLOAT", VK_FORMAT_R16_SFLOAT, kFiltered | kStored},                    // lattice of a ray march
      {"R16G16_SFLOAT", VK_FORMAT_R16G16_SFLOAT, kFiltered},                        // optical depth table
      {"R16G16B16A16_SFLOAT", VK_FORMAT_R16G16B16A16_SFLOAT, kFiltered | kStored},  // scattering table
      {"R32_SFLOAT", VK_FORMAT_R32_SFLOAT, kSampled | kStored},                     // distances
      {"R32G32B32A32_SFLOAT", VK_FORMAT_R32G32B32A32_SFLOAT, kFiltered | kStored},  // radiance, sky, shadows
      {"R8G8B8A8_UNORM", VK_FORMAT_R8G8B8A8_UNORM, kSampled | kStored},             // the picture
  };
  return formats;
}

std::string what_is_missing(FeatureChain& offered, const VkPhysicalDeviceLimits& limits,
                            const std::function<VkFormatFeatureFlags(VkFormat)>& format_features) {
  std::string missing;
  const auto add = [&](const std::string& what) { missing += (missing.empty() ? "" : ", ") + what; };
  for (const RequiredFeature& feature : required_features(offered))
    if (!*feature.value) add(feature.name);
  for (const RequiredLimit& limit : required_limits())
    if (limit.of(limits) < limit.least)
      add(concat(limit.name, " of at least ", limit.least, " (it is ", limit.of(limits), ")"));
  for (const RequiredFormat& format : required_formats())
    for (const FormatUse& use : kFormatUses)
      if ((format.features & use.feature) && !(format_features(format.format) & use.feature))
        add(concat(use.name, " of ", format.name));
  return missing;
}

}  // namespace nephele
