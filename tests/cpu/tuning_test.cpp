// What a device is asked for and tuned to, without a device; and that nothing else asks what a device is.
#include "engine/tuning.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "engine/device.h"
#include "engine/device_needs.h"

using namespace nephele;

namespace {

DeviceInfo device_of(VkPhysicalDeviceType type, std::uint32_t texel_buffer_elements) {
  DeviceInfo device;
  device.type = type;
  device.max_texel_buffer_elements = texel_buffer_elements;
  return device;
}

// A device that has all that is asked for, and no more.
struct Offer {
  FeatureChain features;
  VkPhysicalDeviceLimits limits{};
  VkFormat poor_format = VK_FORMAT_UNDEFINED;  // lacks these features
  VkFormatFeatureFlags lacks = 0;

  Offer() {
    for (const RequiredFeature& feature : required_features(features)) *feature.value = VK_TRUE;
    limits.maxComputeWorkGroupInvocations = 128;
    limits.maxComputeWorkGroupSize[0] = limits.maxComputeWorkGroupSize[1] = 128;
    limits.maxComputeWorkGroupSize[2] = 64;
    limits.maxComputeWorkGroupCount[0] = 65535;
    limits.maxPushConstantsSize = 128;
    limits.maxUniformBufferRange = 16384;
    limits.maxStorageBufferRange = 1u << 27;
    limits.maxPerStageDescriptorUniformBuffers = 12;
    limits.maxPerStageDescriptorStorageBuffers = 16;
    limits.maxPerStageDescriptorStorageImages = 4;
    limits.maxPerStageDescriptorSampledImages = limits.maxPerStageDescriptorSamplers = 16;
    limits.maxPerStageResources = 128;
    limits.maxColorAttachments = 4;
  }
  std::string missing() {
    return what_is_missing(features, limits, [&](VkFormat format) {
      const VkFormatFeatureFlags all = ~VkFormatFeatureFlags{0};
      return format == poor_format ? all & ~lacks : all;
    });
  }
};

std::string without_comments(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string text, line;
  while (std::getline(file, line)) text += line.substr(0, line.find("//")) + "\n";
  return text;
}

}  // namespace

TEST_CASE("a device is tuned by its type, unless a tuning is asked for") {
  const DeviceInfo cpu = device_of(VK_PHYSICAL_DEVICE_TYPE_CPU, 1u << 27);
  const DeviceInfo gpu = device_of(VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU, 1u << 27);
  CHECK(tuning_for(cpu).kind == TuningKind::cpu);
  CHECK(tuning_for(gpu).kind == TuningKind::gpu);
  CHECK(tuning_for(cpu, TuningKind::gpu).kind == TuningKind::gpu);
  CHECK(tuning_for(gpu, TuningKind::cpu).kind == TuningKind::cpu);
}

TEST_CASE("texel buffers are read only where they hold a frame's records") {
  CHECK(tuning_for(device_of(VK_PHYSICAL_DEVICE_TYPE_CPU, 1u << 27)).texel_buffers);
  CHECK_FALSE(tuning_for(device_of(VK_PHYSICAL_DEVICE_TYPE_CPU, 65536)).texel_buffers);
  CHECK_FALSE(tuning_for(device_of(VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU, 65536), TuningKind::cpu).texel_buffers);
  CHECK_FALSE(tuning_for(device_of(VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU, 65536)).texel_buffers);
}

TEST_CASE("a tuning's name is read back, and another is refused by name") {
  for (const TuningKind kind : {TuningKind::automatic, TuningKind::cpu, TuningKind::gpu}) {
    const Result<TuningKind> read = parse_tuning_kind(tuning_kind_name(kind));
    REQUIRE(read);
    CHECK(*read == kind);
  }
  CHECK(*parse_tuning_kind("") == TuningKind::automatic);
  const Result<TuningKind> unknown = parse_tuning_kind("npu");
  REQUIRE_FALSE(unknown);
  CHECK(unknown.error().message == "unknown tuning 'npu'; accepted: auto, cpu, gpu");
}

TEST_CASE("a device that has what is needed lacks nothing") { CHECK(Offer().missing().empty()); }

TEST_CASE("each feature, limit and format that a device lacks is named, and all of them in one line") {
  Offer poor;
  poor.features.v12.scalarBlockLayout = VK_FALSE;
  CHECK(poor.missing() == "scalarBlockLayout");
  poor.limits.maxPushConstantsSize = 64;
  CHECK(poor.missing() == "scalarBlockLayout, maxPushConstantsSize of at least 128 (it is 64)");
  poor.poor_format = VK_FORMAT_R32G32B32A32_SFLOAT;
  poor.lacks = VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
  CHECK(poor.missing() ==
        "scalarBlockLayout, maxPushConstantsSize of at least 128 (it is 64), "
        "linear filtering of R32G32B32A32_SFLOAT");

  FeatureChain any;
  for (std::size_t i = 0; i < required_features(any).size(); ++i) {
    Offer offer;
    const RequiredFeature feature = required_features(offer.features)[i];
    *feature.value = VK_FALSE;
    CHECK(offer.missing() == feature.name);
  }
}

TEST_CASE("what a device is, one file asks") {
  const std::filesystem::path root = NEPHELE_SOURCE_DIR;
  for (const char* folder : {"engine", "passes", "lut", "tools"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".cpp" && extension != ".h") continue;
      const std::string text = without_comments(entry.path());
      for (const char* word :
           {"on_cpu", "VK_PHYSICAL_DEVICE_TYPE_", "VK_DRIVER_ID_", "driverID", "vendorID", "llvmpipe", "SwiftShader"}) {
        CAPTURE(entry.path().string());
        CAPTURE(word);
        CHECK((text.find(word) == std::string::npos || entry.path().filename() == "tuning.cpp"));
      }
    }
}
