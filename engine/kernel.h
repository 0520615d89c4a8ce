// Pipelines made from embedded SPIR-V. Descriptor set layouts come from shader reflection, so a shader's
// bindings are written once, in the shader; what a step declares is checked against them (frame.h). Where the device's
// tuning reads no texel buffers, a shader's storage module is taken.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/device.h"
#include "engine/shader_code.h"

namespace nephele {

struct ReflectedBinding {
  std::uint32_t binding = 0;
  VkDescriptorType type{};
  bool reads = false, writes = false;  // an unqualified storage resource does both
  std::string name;
};

struct ReflectedMember {
  std::string name;
  std::uint32_t offset = 0, bytes = 0;
};

struct Reflection {
  std::vector<ReflectedBinding> bindings;  // set 0 only, ordered by binding
  std::uint32_t push_constant_bytes = 0;
  std::uint32_t local_size[3] = {1, 1, 1};
};

Reflection reflect(const ShaderCode& code);
// The members of a struct type used anywhere in the module, by its GLSL name; empty when it is not there.
std::vector<ReflectedMember> reflect_struct(const ShaderCode& code, const std::string& struct_name);

// Specialisation constants by constant_id, 32 bits each.
struct SpecConstant {
  std::uint32_t id;
  std::uint32_t value;
};

// What compute and raster pipelines share: set layout, pipeline layout, reflection.
class PipelineLayout {
 public:
  PipelineLayout() = default;
  PipelineLayout(Device& device, std::string name, std::span<const ShaderCode* const> stages,
                 VkShaderStageFlags stage_flags);
  PipelineLayout(PipelineLayout&& other) noexcept { swap(other); }
  PipelineLayout& operator=(PipelineLayout&& other) noexcept {
    swap(other);
    return *this;
  }
  ~PipelineLayout();
  const std::string& name() const { return name_; }
  const Reflection& reflection() const { return reflection_; }
  VkDescriptorSetLayout set_layout() const { return set_layout_; }
  VkPipelineLayout vk() const { return layout_; }
  VkShaderStageFlags stages() const { return stage_flags_; }

 private:
  void swap(PipelineLayout& other) noexcept;
  Device* device_ = nullptr;
  std::string name_;
  Reflection reflection_;
  VkShaderStageFlags stage_flags_ = 0;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
};

class ComputeKernel {
 public:
  ComputeKernel() = default;
  ComputeKernel(Device& device, const ShaderCode& shader, std::span<const SpecConstant> constants = {});
  ComputeKernel(ComputeKernel&& other) noexcept { swap(other); }
  ComputeKernel& operator=(ComputeKernel&& other) noexcept {
    swap(other);
    return *this;
  }
  ~ComputeKernel();
  explicit operator bool() const { return pipeline_ != VK_NULL_HANDLE; }
  const PipelineLayout& layout() const { return layout_; }
  VkPipeline vk() const { return pipeline_; }

 private:
  void swap(ComputeKernel& other) noexcept;
  Device* device_ = nullptr;
  PipelineLayout layout_;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
};

enum class Blend : std::uint8_t {
  none,     // overwrite
  over,     // premultiplied source over destination; destination alpha is multiplied by (1 - source alpha)
  minimum,  // component-wise minimum
};

struct RasterDesc {
  const ShaderCode* vertex = nullptr;
  const ShaderCode* fragment = nullptr;
  std::vector<VkFormat> color_formats;  // at most 4
  std::vector<Blend> blends;            // one per attachment; ignored when ordered
  bool ordered = false;                 // rasterization-order attachment access: attachments are inputs too
  std::vector<SpecConstant> constants;
};

// A pipeline with its own render pass: all attachments are cleared at the start and stored at the end, layout
// GENERAL throughout; triangle lists, no depth test, no culling, viewport and scissor from the step.
class RasterPipeline {
 public:
  RasterPipeline() = default;
  RasterPipeline(Device& device, const RasterDesc& desc);
  RasterPipeline(RasterPipeline&& other) noexcept { swap(other); }
  RasterPipeline& operator=(RasterPipeline&& other) noexcept {
    swap(other);
    return *this;
  }
  ~RasterPipeline();
  explicit operator bool() const { return pipeline_ != VK_NULL_HANDLE; }
  const PipelineLayout& layout() const { return layout_; }
  VkPipeline vk() const { return pipeline_; }
  VkRenderPass render_pass() const { return render_pass_; }
  const RasterDesc& desc() const { return desc_; }

 private:
  void swap(RasterPipeline& other) noexcept;
  Device* device_ = nullptr;
  RasterDesc desc_;
  PipelineLayout layout_;
  VkRenderPass render_pass_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
};

}  // namespace nephele
