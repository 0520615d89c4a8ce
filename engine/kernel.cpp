#include "engine/kernel.h"

#include <algorithm>

#include "engine/check.h"

namespace nephele {
namespace {

// The shader in the way that the device's tuning loads records.
const ShaderCode& tuned(const Device& device, const ShaderCode& code) {
  return code.storage && !device.tuning().texel_buffers ? *code.storage : code;
}

VkShaderModule make_module(Device& device, const ShaderCode& code) {
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = code.bytes;
  info.pCode = code.words;
  VkShaderModule module = VK_NULL_HANDLE;
  NEPHELE_VK(vkCreateShaderModule(device.vk(), &info, nullptr, &module));
  return module;
}

// Storage of one VkSpecializationInfo: constants are 32 bits each, in the order given.
struct Specialisation {
  explicit Specialisation(std::span<const SpecConstant> constants) {
    for (const SpecConstant& constant : constants) {
      entries.push_back(
          {constant.id, static_cast<std::uint32_t>(values.size() * sizeof(std::uint32_t)), sizeof(std::uint32_t)});
      values.push_back(constant.value);
    }
    info = {static_cast<std::uint32_t>(entries.size()), entries.data(), values.size() * sizeof(std::uint32_t),
            values.data()};
  }
  std::vector<VkSpecializationMapEntry> entries;
  std::vector<std::uint32_t> values;
  VkSpecializationInfo info{};
};

void merge(Reflection& into, const Reflection& from, const std::string& name) {
  for (const ReflectedBinding& binding : from.bindings) {
    const auto at = std::find_if(into.bindings.begin(), into.bindings.end(),
                                 [&](const auto& b) { return b.binding == binding.binding; });
    if (at == into.bindings.end()) {
      into.bindings.push_back(binding);
      continue;
    }
    NEPHELE_CHECK(at->type == binding.type, name, ": binding ", binding.binding, " differs between stages");
    at->reads |= binding.reads;
    at->writes |= binding.writes;
  }
  into.push_constant_bytes = std::max(into.push_constant_bytes, from.push_constant_bytes);
  std::copy(std::begin(from.local_size), std::end(from.local_size), into.local_size);
}

VkRenderPass make_render_pass(Device& device, const RasterDesc& desc) {
  const std::uint32_t count = static_cast<std::uint32_t>(desc.color_formats.size());
  std::vector<VkAttachmentDescription> attachments(count);
  std::vector<VkAttachmentReference> references(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    attachments[i].format = desc.color_formats[i];
    attachments[i].samples = VK_SAMPLE_COUNT_1_BIT;
    attachments[i].loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    attachments[i].storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    attachments[i].stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    attachments[i].stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    attachments[i].initialLayout = attachments[i].finalLayout = VK_IMAGE_LAYOUT_GENERAL;
    references[i] = {i, VK_IMAGE_LAYOUT_GENERAL};
  }
  VkSubpassDescription subpass{};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = count;
  subpass.pColorAttachments = references.data();
  if (desc.ordered) {
    subpass.flags = VK_SUBPASS_DESCRIPTION_RASTERIZATION_ORDER_ATTACHMENT_COLOR_ACCESS_BIT_EXT;
    subpass.inputAttachmentCount = count;
    subpass.pInputAttachments = references.data();
  }
  VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  info.attachmentCount = count;
  info.pAttachments = attachments.data();
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  VkRenderPass render_pass = VK_NULL_HANDLE;
  NEPHELE_VK(vkCreateRenderPass(device.vk(), &info, nullptr, &render_pass));
  return render_pass;
}

VkPipelineColorBlendAttachmentState blend_state(Blend blend) {
  VkPipelineColorBlendAttachmentState state{};
  state.colorWriteMask =
      VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
  state.blendEnable = blend != Blend::none;
  state.srcColorBlendFactor = VK_BLEND_FACTOR_ONE;
  state.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  state.srcAlphaBlendFactor = VK_BLEND_FACTOR_ZERO;
  state.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  state.colorBlendOp = state.alphaBlendOp = blend == Blend::minimum ? VK_BLEND_OP_MIN : VK_BLEND_OP_ADD;
  return state;
}

}  // namespace

PipelineLayout::PipelineLayout(Device& device, std::string name, std::span<const ShaderCode* const> stages,
                               VkShaderStageFlags stage_flags)
    : device_(&device), name_(std::move(name)), stage_flags_(stage_flags) {
  for (const ShaderCode* code : stages) merge(reflection_, reflect(*code), name_);
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (const ReflectedBinding& binding : reflection_.bindings) {
    const VkShaderStageFlags visible = binding.type == VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT
                                           ? VkShaderStageFlags{VK_SHADER_STAGE_FRAGMENT_BIT}
                                           : stage_flags;
    bindings.push_back({binding.binding, binding.type, 1, visible, nullptr});
  }
  VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  set.bindingCount = static_cast<std::uint32_t>(bindings.size());
  set.pBindings = bindings.data();
  NEPHELE_VK(vkCreateDescriptorSetLayout(device.vk(), &set, nullptr, &set_layout_));
  const VkPushConstantRange push{stage_flags, 0, reflection_.push_constant_bytes};
  NEPHELE_CHECK(push.size <= 128, name_, ": push constants past the guaranteed 128 bytes");
  VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout.setLayoutCount = 1;
  layout.pSetLayouts = &set_layout_;
  layout.pushConstantRangeCount = push.size > 0 ? 1 : 0;
  layout.pPushConstantRanges = &push;
  NEPHELE_VK(vkCreatePipelineLayout(device.vk(), &layout, nullptr, &layout_));
}

PipelineLayout::~PipelineLayout() {
  if (!layout_) return;
  vkDestroyPipelineLayout(device_->vk(), layout_, nullptr);
  vkDestroyDescriptorSetLayout(device_->vk(), set_layout_, nullptr);
}

void PipelineLayout::swap(PipelineLayout& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(name_, other.name_);
  std::swap(reflection_, other.reflection_);
  std::swap(stage_flags_, other.stage_flags_);
  std::swap(set_layout_, other.set_layout_);
  std::swap(layout_, other.layout_);
}

ComputeKernel::ComputeKernel(Device& device, const ShaderCode& shader, std::span<const SpecConstant> constants)
    : device_(&device) {
  const ShaderCode& code = tuned(device, shader);
  const ShaderCode* stages[] = {&code};
  layout_ = PipelineLayout(device, code.name, stages, VK_SHADER_STAGE_COMPUTE_BIT);
  const Specialisation specialisation(constants);
  const VkShaderModule module = make_module(device, code);
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &specialisation.info;
  info.layout = layout_.vk();
  NEPHELE_VK(vkCreateComputePipelines(device.vk(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_));
  vkDestroyShaderModule(device.vk(), module, nullptr);
  device.set_name(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<std::uint64_t>(pipeline_), code.name);
}

ComputeKernel::~ComputeKernel() {
  if (pipeline_) vkDestroyPipeline(device_->vk(), pipeline_, nullptr);
}

void ComputeKernel::swap(ComputeKernel& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(layout_, other.layout_);
  std::swap(pipeline_, other.pipeline_);
}

RasterPipeline::RasterPipeline(Device& device, const RasterDesc& desc) : device_(&device), desc_(desc) {
  const std::size_t count = desc.color_formats.size();
  NEPHELE_CHECK(count >= 1 && count <= 4, desc.fragment->name, ": ", count, " attachments");
  NEPHELE_CHECK(desc.ordered || desc.blends.size() == count, desc.fragment->name);
  NEPHELE_CHECK(!desc.ordered || device.info().ordered_attachment_access, desc.fragment->name,
                " needs rasterization-order access");
  const ShaderCode* codes[] = {&tuned(device, *desc.vertex), &tuned(device, *desc.fragment)};
  layout_ =
      PipelineLayout(device, desc.fragment->name, codes, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT);
  render_pass_ = make_render_pass(device, desc);

  const Specialisation specialisation(desc.constants);
  VkPipelineShaderStageCreateInfo stages[2]{};
  for (int i = 0; i < 2; ++i) {
    stages[i].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    stages[i].stage = i == 0 ? VK_SHADER_STAGE_VERTEX_BIT : VK_SHADER_STAGE_FRAGMENT_BIT;
    stages[i].module = make_module(device, *codes[i]);
    stages[i].pName = "main";
    stages[i].pSpecializationInfo = &specialisation.info;
  }
  VkPipelineVertexInputStateCreateInfo vertex_input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewport.viewportCount = viewport.scissorCount = 1;
  VkPipelineRasterizationStateCreateInfo rasterization{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  rasterization.cullMode = VK_CULL_MODE_NONE;
  rasterization.lineWidth = 1.0f;
  VkPipelineMultisampleStateCreateInfo multisample{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  multisample.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  std::vector<VkPipelineColorBlendAttachmentState> blends;
  for (std::size_t i = 0; i < count; ++i) blends.push_back(blend_state(desc.ordered ? Blend::none : desc.blends[i]));
  VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  // The subpass asks for ordered access too (make_render_pass): hardware needs both flags, validation misses this one.
  if (desc.ordered) blend.flags = VK_PIPELINE_COLOR_BLEND_STATE_CREATE_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_BIT_EXT;
  blend.attachmentCount = static_cast<std::uint32_t>(count);
  blend.pAttachments = blends.data();
  const VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
  dynamic.dynamicStateCount = 2;
  dynamic.pDynamicStates = dynamic_states;

  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  info.stageCount = 2;
  info.pStages = stages;
  info.pVertexInputState = &vertex_input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &rasterization;
  info.pMultisampleState = &multisample;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
  info.layout = layout_.vk();
  info.renderPass = render_pass_;
  NEPHELE_VK(vkCreateGraphicsPipelines(device.vk(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_));
  for (const auto& stage : stages) vkDestroyShaderModule(device.vk(), stage.module, nullptr);
  device.set_name(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<std::uint64_t>(pipeline_), desc.fragment->name);
}

RasterPipeline::~RasterPipeline() {
  if (!pipeline_) return;
  vkDestroyPipeline(device_->vk(), pipeline_, nullptr);
  vkDestroyRenderPass(device_->vk(), render_pass_, nullptr);
}

void RasterPipeline::swap(RasterPipeline& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(desc_, other.desc_);
  std::swap(layout_, other.layout_);
  std::swap(render_pass_, other.render_pass_);
  std::swap(pipeline_, other.pipeline_);
}

}  // namespace nephele
