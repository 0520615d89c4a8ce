// SPIR-V reflection through SPIRV-Cross: what a shader binds and how it touches it.
#include <spirv_cross/spirv_cross_c.h>

#include <algorithm>
#include <map>

#include "engine/check.h"
#include "engine/kernel.h"

namespace nephele {
namespace {

// A parsed module; everything it hands out lives as long as it does.
class Module {
 public:
  explicit Module(const ShaderCode& code) : name_(code.name) {
    check(spvc_context_create(&context_));
    spvc_parsed_ir ir = nullptr;
    check(spvc_context_parse_spirv(context_, code.words, code.bytes / sizeof(std::uint32_t), &ir));
    check(spvc_context_create_compiler(context_, SPVC_BACKEND_NONE, ir, SPVC_CAPTURE_MODE_TAKE_OWNERSHIP, &compiler));
    check(spvc_compiler_create_shader_resources(compiler, &resources));
  }
  ~Module() { spvc_context_destroy(context_); }
  Module(const Module&) = delete;
  Module& operator=(const Module&) = delete;

  void check(spvc_result result) const {
    NEPHELE_CHECK(result == SPVC_SUCCESS, name_, ": ",
                  context_ ? spvc_context_get_last_error_string(context_) : "no context");
  }
  std::span<const spvc_reflected_resource> list(spvc_resource_type type) const {
    const spvc_reflected_resource* first = nullptr;
    std::size_t count = 0;
    check(spvc_resources_get_resource_list_for_type(resources, type, &first, &count));
    return {first, count};
  }

  spvc_compiler compiler = nullptr;
  spvc_resources resources = nullptr;

 private:
  std::string name_;
  spvc_context context_ = nullptr;
};

bool block_has(const Module& module, const spvc_reflected_resource& resource, SpvDecoration decoration) {
  const SpvDecoration* decorations = nullptr;
  std::size_t count = 0;
  module.check(spvc_compiler_get_buffer_block_decorations(module.compiler, resource.id, &decorations, &count));
  return std::find(decorations, decorations + count, decoration) != decorations + count;
}

}  // namespace

Reflection reflect(const ShaderCode& code) {
  const Module module(code);
  Reflection reflection;
  const auto add = [&](spvc_resource_type type, VkDescriptorType descriptor) {
    for (const spvc_reflected_resource& resource : module.list(type)) {
      const auto decoration = [&](SpvDecoration which) {
        return spvc_compiler_get_decoration(module.compiler, resource.id, which);
      };
      NEPHELE_CHECK(decoration(SpvDecorationDescriptorSet) == 0, code.name, ": ", resource.name, " is not in set 0");
      ReflectedBinding binding{decoration(SpvDecorationBinding), descriptor, true, false, resource.name};
      if (type == SPVC_RESOURCE_TYPE_STORAGE_BUFFER) {
        binding.reads = !block_has(module, resource, SpvDecorationNonReadable);
        binding.writes = !block_has(module, resource, SpvDecorationNonWritable);
      } else if (type == SPVC_RESOURCE_TYPE_STORAGE_IMAGE) {
        binding.reads = !spvc_compiler_has_decoration(module.compiler, resource.id, SpvDecorationNonReadable);
        binding.writes = !spvc_compiler_has_decoration(module.compiler, resource.id, SpvDecorationNonWritable);
      }
      reflection.bindings.push_back(binding);
    }
  };
  add(SPVC_RESOURCE_TYPE_UNIFORM_BUFFER, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER);
  add(SPVC_RESOURCE_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
  add(SPVC_RESOURCE_TYPE_STORAGE_IMAGE, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE);
  add(SPVC_RESOURCE_TYPE_SAMPLED_IMAGE, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER);
  add(SPVC_RESOURCE_TYPE_SEPARATE_IMAGE,
      VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER);  // no shader has images without samplers
  add(SPVC_RESOURCE_TYPE_SUBPASS_INPUT, VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT);
  std::sort(reflection.bindings.begin(), reflection.bindings.end(),
            [](const auto& a, const auto& b) { return a.binding < b.binding; });

  for (const spvc_reflected_resource& push : module.list(SPVC_RESOURCE_TYPE_PUSH_CONSTANT)) {
    std::size_t bytes = 0;
    module.check(spvc_compiler_get_declared_struct_size(
        module.compiler, spvc_compiler_get_type_handle(module.compiler, push.base_type_id), &bytes));
    reflection.push_constant_bytes = static_cast<std::uint32_t>(bytes);
  }
  for (unsigned axis = 0; axis < 3; ++axis)
    reflection.local_size[axis] = std::max(
        1u, spvc_compiler_get_execution_mode_argument_by_index(module.compiler, SpvExecutionModeLocalSize, axis));
  return reflection;
}

std::vector<ReflectedMember> reflect_struct(const ShaderCode& code, const std::string& struct_name) {
  const Module module(code);
  // A struct is reached through the blocks that hold it: as the block itself, a member, or an array's element.
  std::vector<ReflectedMember> members;
  const auto search = [&](auto&& self, spvc_type_id id) -> bool {
    const spvc_type type = spvc_compiler_get_type_handle(module.compiler, id);
    if (spvc_type_get_basetype(type) != SPVC_BASETYPE_STRUCT) return false;
    const spvc_type_id base = spvc_type_get_base_type_id(type);
    const unsigned count = spvc_type_get_num_member_types(type);
    if (struct_name == spvc_compiler_get_name(module.compiler, base)) {
      for (unsigned i = 0; i < count; ++i) {
        ReflectedMember member{spvc_compiler_get_member_name(module.compiler, base, i), 0, 0};
        module.check(spvc_compiler_type_struct_member_offset(module.compiler, type, i, &member.offset));
        std::size_t bytes = 0;
        module.check(spvc_compiler_get_declared_struct_member_size(module.compiler, type, i, &bytes));
        member.bytes = static_cast<std::uint32_t>(bytes);
        members.push_back(member);
      }
      return true;
    }
    for (unsigned i = 0; i < count; ++i)
      if (self(self, spvc_type_get_member_type(type, i))) return true;
    return false;
  };
  for (const spvc_resource_type kind :
       {SPVC_RESOURCE_TYPE_UNIFORM_BUFFER, SPVC_RESOURCE_TYPE_STORAGE_BUFFER, SPVC_RESOURCE_TYPE_PUSH_CONSTANT})
    for (const spvc_reflected_resource& resource : module.list(kind))
      if (search(search, resource.base_type_id)) return members;
  return members;
}

}  // namespace nephele
