// What the raster backends ask the driver for, so that a pixel's particles blend in order. Lavapipe orders without
// being asked and has no interlock, so no picture tells a forgotten flag: the calls and the shader's code are looked at
// instead.
#include <dlfcn.h>
#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include "nephele_shaders.h"
#include "tests/support/layer_scene.h"

using namespace nephele;
using namespace nephele::test;

namespace {

struct CreatedPass {
  VkSubpassDescriptionFlags subpass_flags = 0;
  std::vector<std::pair<std::uint32_t, VkImageLayout>> colors, inputs;
};
struct CreatedPipeline {
  CreatedPass pass;
  VkPipelineColorBlendStateCreateFlags blend_flags = 0;
  bool blends = false;  // in fixed function
};
std::map<VkRenderPass, CreatedPass> created_passes;
std::vector<CreatedPipeline> created_pipelines;

std::vector<std::pair<std::uint32_t, VkImageLayout>> references(const VkAttachmentReference* list,
                                                                std::uint32_t count) {
  std::vector<std::pair<std::uint32_t, VkImageLayout>> copy;
  for (std::uint32_t i = 0; i < count; ++i) copy.emplace_back(list[i].attachment, list[i].layout);
  return copy;
}

std::vector<CreatedPipeline> pipelines_of(Backend backend) {
  created_pipelines.clear();
  Kernels kernels(test_device());  // with no pipeline made before
  Workshop make(kernels);
  const RasterBlend blend(make, backend, 16, 16, {.light_field = false});
  return created_pipelines;
}

constexpr std::uint32_t kOpExecutionMode = 16, kOpImageRead = 98, kOpImageWrite = 99, kOpBeginInterlock = 5364,
                        kOpEndInterlock = 5365;
constexpr std::uint32_t kPixelInterlockOrdered = 5366;

struct Instruction {
  std::uint32_t op;
  std::vector<std::uint32_t> operands;
};

std::vector<Instruction> instructions(const ShaderCode& code) {
  std::vector<Instruction> list;
  const std::size_t words = code.bytes / sizeof(std::uint32_t);
  for (std::size_t at = 5; at < words; at += code.words[at] >> 16)  // a header of five words
    list.push_back({code.words[at] & 0xFFFFu, {code.words + at + 1, code.words + at + (code.words[at] >> 16)}});
  return list;
}

}  // namespace

// The program's own definitions come before the loader's and pass calls on to it.
extern "C" VKAPI_ATTR VkResult VKAPI_CALL vkCreateRenderPass(VkDevice device, const VkRenderPassCreateInfo* info,
                                                             const VkAllocationCallbacks* allocator,
                                                             VkRenderPass* pass) {
  const VkResult result =
      reinterpret_cast<PFN_vkCreateRenderPass>(dlsym(RTLD_NEXT, "vkCreateRenderPass"))(device, info, allocator, pass);
  const VkSubpassDescription& subpass = info->pSubpasses[0];
  created_passes[*pass] = {subpass.flags, references(subpass.pColorAttachments, subpass.colorAttachmentCount),
                           references(subpass.pInputAttachments, subpass.inputAttachmentCount)};
  return result;
}

extern "C" VKAPI_ATTR VkResult VKAPI_CALL vkCreateGraphicsPipelines(VkDevice device, VkPipelineCache cache,
                                                                    std::uint32_t count,
                                                                    const VkGraphicsPipelineCreateInfo* infos,
                                                                    const VkAllocationCallbacks* allocator,
                                                                    VkPipeline* pipelines) {
  for (std::uint32_t i = 0; i < count; ++i) {
    const VkPipelineColorBlendStateCreateInfo& blend = *infos[i].pColorBlendState;
    const bool blends = std::any_of(blend.pAttachments, blend.pAttachments + blend.attachmentCount,
                                    [](const auto& a) { return a.blendEnable; });
    created_pipelines.push_back({created_passes[infos[i].renderPass], blend.flags, blends});
  }
  return reinterpret_cast<PFN_vkCreateGraphicsPipelines>(dlsym(RTLD_NEXT, "vkCreateGraphicsPipelines"))(
      device, cache, count, infos, allocator, pipelines);
}

TEST_CASE(
    "attachment: the subpass and every pipeline ask for raster order, and the shader reads the attachments that it "
    "writes") {
  if (!backend_available(test_device().info(), Backend::attachment)) return;
  const std::vector<CreatedPipeline> pipelines = pipelines_of(Backend::attachment);
  REQUIRE(!pipelines.empty());
  for (const CreatedPipeline& pipeline : pipelines) {
    CHECK(pipeline.blend_flags == VK_PIPELINE_COLOR_BLEND_STATE_CREATE_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_BIT_EXT);
    CHECK(pipeline.pass.subpass_flags == VK_SUBPASS_DESCRIPTION_RASTERIZATION_ORDER_ATTACHMENT_COLOR_ACCESS_BIT_EXT);
    CHECK_FALSE(pipeline.blends);
    CHECK(pipeline.pass.colors.size() == 3);
    CHECK(pipeline.pass.inputs == pipeline.pass.colors);
    for (const auto& [attachment, layout] : pipeline.pass.colors) CHECK(layout == VK_IMAGE_LAYOUT_GENERAL);
  }
}

TEST_CASE("alpha: blends in fixed function and asks for nothing") {
  const std::vector<CreatedPipeline> pipelines = pipelines_of(Backend::alpha);
  REQUIRE(pipelines.size() == 1);
  CHECK(pipelines[0].blends);
  CHECK(pipelines[0].blend_flags == 0);
  CHECK(pipelines[0].pass.subpass_flags == 0);
  CHECK(pipelines[0].pass.inputs.empty());
}

TEST_CASE("interlock: the shader locks its pixel in order, and touches the state inside the lock only") {
  const std::vector<Instruction> code = instructions(shaders::cloud_frag_interlock);
  const auto ordered = [](const Instruction& i) {
    return i.op == kOpExecutionMode && i.operands.at(1) == kPixelInterlockOrdered;
  };
  CHECK(std::count_if(code.begin(), code.end(), ordered) == 1);
  int begins = 0, ends = 0, touches = 0;
  for (const Instruction& i : code) {
    begins += i.op == kOpBeginInterlock;
    ends += i.op == kOpEndInterlock;
    if (i.op != kOpImageRead && i.op != kOpImageWrite) continue;
    ++touches;
    CHECK(begins == 1);
    CHECK(ends == 0);
  }
  CHECK(begins == 1);
  CHECK(ends == 1);
  CHECK(touches == 6);  // three images, read and written
}
