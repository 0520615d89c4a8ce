// What the embedded shaders use of a device is no more than what a device is asked for.
#include "engine/device_needs.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>

#include "engine/kernel.h"
#include "nephele_shaders.h"

using namespace nephele;

namespace {

std::vector<const ShaderCode*> all_modules() {
  std::vector<const ShaderCode*> modules;
  for (const ShaderCode* code : shaders::all_of_nephele_shaders) {
    modules.push_back(code);
    if (code->storage) modules.push_back(code->storage);
  }
  return modules;
}

std::uint32_t asked(const std::string& name) {
  for (const RequiredLimit& limit : required_limits())
    if (limit.name == name) return limit.least;
  FAIL("no limit " << name);
  return 0;
}

// The capabilities that a SPIR-V module declares (OpCapability, opcode 17).
std::set<std::uint32_t> capabilities(const ShaderCode& code) {
  std::set<std::uint32_t> found;
  const std::size_t count = code.bytes / sizeof(std::uint32_t);
  for (std::size_t at = 5; at < count; at += code.words[at] >> 16)
    if ((code.words[at] & 0xffffu) == 17u) found.insert(code.words[at + 1]);
  return found;
}

}  // namespace

TEST_CASE("bindings, push constants and workgroups of every shader are within the limits that are asked for") {
  std::map<std::string, std::uint32_t> used;
  for (const ShaderCode* code : all_modules()) {
    CAPTURE(code->name);
    const Reflection reflection = reflect(*code);
    std::map<VkDescriptorType, std::uint32_t> counts;
    for (const ReflectedBinding& binding : reflection.bindings) ++counts[binding.type];
    const std::uint32_t sampled = counts[VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER];
    const auto use = [&](const char* name, std::uint32_t count) {
      CAPTURE(name);
      CHECK(count <= asked(name));
      used[name] = std::max(used[name], count);
    };
    use("maxPerStageDescriptorUniformBuffers", counts[VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER]);
    use("maxPerStageDescriptorStorageBuffers", counts[VK_DESCRIPTOR_TYPE_STORAGE_BUFFER]);
    use("maxPerStageDescriptorStorageImages", counts[VK_DESCRIPTOR_TYPE_STORAGE_IMAGE]);
    use("maxPerStageDescriptorSamplers", sampled);
    use("maxPerStageDescriptorSampledImages", sampled + counts[VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER]);
    use("maxPerStageResources", static_cast<std::uint32_t>(reflection.bindings.size()) + 4);  // attachments count too
    use("maxPushConstantsSize", reflection.push_constant_bytes);
    use("maxComputeWorkGroupInvocations",
        reflection.local_size[0] * reflection.local_size[1] * reflection.local_size[2]);
    for (int axis = 0; axis < 3; ++axis)
      use(("maxComputeWorkGroupSize[" + std::to_string(axis) + "]").c_str(), reflection.local_size[axis]);
  }
  // Nor is more asked for than is used, of what devices differ in.
  CHECK(used["maxPerStageDescriptorStorageBuffers"] == asked("maxPerStageDescriptorStorageBuffers"));
  CHECK(used["maxPerStageDescriptorStorageImages"] == asked("maxPerStageDescriptorStorageImages"));
}

TEST_CASE("no shader declares a capability without a feature that is enabled") {
  // Vulkan gives the first four without a feature; StorageImageExtendedFormats comes with
  // shaderStorageImageExtendedFormats, FragmentShaderPixelInterlockEXT with the backend interlock.
  const std::set<std::uint32_t> known = {1 /* Shader */,
                                         40 /* InputAttachment */,
                                         46 /* SampledBuffer */,
                                         50 /* ImageQuery */,
                                         49 /* StorageImageExtendedFormats */,
                                         5378 /* FragmentShaderPixelInterlockEXT */};
  for (const ShaderCode* code : all_modules())
    for (const std::uint32_t capability : capabilities(*code)) {
      CAPTURE(code->name);
      CAPTURE(capability);
      CHECK(known.count(capability) == 1);
    }
}

TEST_CASE("a shader's storage module has the same bindings and no texel buffers") {
  std::size_t texel_shaders = 0;
  for (const ShaderCode* code : shaders::all_of_nephele_shaders) {
    CAPTURE(code->name);
    const Reflection reflection = reflect(*code);
    const bool reads_texels =
        std::any_of(reflection.bindings.begin(), reflection.bindings.end(),
                    [](const ReflectedBinding& b) { return b.type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER; });
    texel_shaders += reads_texels;
    if (reads_texels) REQUIRE(code->storage);
    if (!code->storage) continue;
    const Reflection storage = reflect(*code->storage);
    REQUIRE(storage.bindings.size() == reflection.bindings.size());
    for (std::size_t i = 0; i < storage.bindings.size(); ++i) {
      const ReflectedBinding &with = reflection.bindings[i], &without = storage.bindings[i];
      CHECK(with.binding == without.binding);
      if (with.type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER) {
        CHECK(without.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
        CHECK_FALSE(without.writes);
      } else {
        CHECK(with.type == without.type);
      }
    }
  }
  CHECK(texel_shaders > 20);
}
