#include "engine/frame.h"

#include <algorithm>

#include "engine/check.h"

namespace nephele {
namespace {

// Each step has one descriptor set at most, and sets have at most so many bindings of a type on average.
constexpr std::uint32_t kLeastSets = 512, kBindingsASet = 8, kMaxRasterSteps = 16;

const std::string& resource_name(const ResourceRef& resource) {
  return std::visit([](const auto* object) -> const std::string& { return object->name(); }, resource);
}

bool is_image(const ResourceRef& resource) { return std::holds_alternative<const Image*>(resource); }

bool is_texels(Access access) { return access == Access::texels || access == Access::words; }

// What the step declares must be what the shader does: same set of bindings, same kind, same direction.
void check_bindings(const std::string& step, const PipelineLayout& layout, const std::vector<Binding>& bindings) {
  for (const ReflectedBinding& reflected : layout.reflection().bindings) {
    const auto at = std::find_if(bindings.begin(), bindings.end(),
                                 [&](const Binding& b) { return b.binding == reflected.binding; });
    NEPHELE_CHECK(at != bindings.end(), step, " / ", layout.name(), ": binding ", reflected.binding, " (",
                  reflected.name, ") is not declared");
    const std::string& resource = resource_name(at->resource);
    const bool storage =
        reflected.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER || reflected.type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    const bool texels = reflected.type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    const bool buffer = texels || reflected.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER ||
                        reflected.type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    NEPHELE_CHECK(buffer != is_image(at->resource), step, " / ", layout.name(), ": ", resource, " at binding ",
                  reflected.binding, " is of the wrong kind");
    Access wanted = Access::uniform;
    if (storage)
      wanted = reflected.writes ? (reflected.reads ? Access::storage_read_write : Access::storage_write)
                                : Access::storage_read;
    if (reflected.type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER) wanted = Access::sampled;
    if (reflected.type == VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT) wanted = Access::color_ordered;
    // How many words a texel has, the shader doesn't say; its storage module reads a storage buffer instead.
    if (texels || (wanted == Access::storage_read && buffer && is_texels(at->access)))
      wanted = at->access == Access::words ? Access::words : Access::texels;
    NEPHELE_CHECK(at->access == wanted, step, " / ", layout.name(), ": ", resource, " at binding ", reflected.binding,
                  " is declared ", access_name(at->access), ", the shader's ", reflected.name, " is ",
                  access_name(wanted));
  }
  NEPHELE_CHECK(bindings.size() == layout.reflection().bindings.size(), step, " / ", layout.name(), ": declares ",
                bindings.size(), " bindings, the shader has ", layout.reflection().bindings.size());
}

// What a binding does in this layout: a buffer declared as texels that the shader reads as storage is a storage read.
Access access_in(const PipelineLayout& layout, const Binding& binding) {
  for (const ReflectedBinding& reflected : layout.reflection().bindings)
    if (reflected.binding == binding.binding && reflected.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER &&
        is_texels(binding.access))
      return Access::storage_read;
  return binding.access;
}

std::vector<std::pair<ResourceRef, Access>> uses_of(const PipelineLayout& layout, const std::vector<Binding>& bindings,
                                                    const Indirect& indirect) {
  std::vector<std::pair<ResourceRef, Access>> uses;
  for (const Binding& binding : bindings) uses.emplace_back(binding.resource, access_in(layout, binding));
  if (indirect.buffer) uses.emplace_back(indirect.buffer, Access::indirect);
  return uses;
}

void push_constants(VkCommandBuffer commands, const PipelineLayout& layout, const PushConstants& push,
                    const std::string& step) {
  NEPHELE_CHECK(push.size() == layout.reflection().push_constant_bytes, step, ": pushes ", push.size(),
                " bytes, the shader has ", layout.reflection().push_constant_bytes);
  if (!push.empty())
    vkCmdPushConstants(commands, layout.vk(), layout.stages(), 0, static_cast<std::uint32_t>(push.size()), push.data());
}

void memory_barrier(VkCommandBuffer commands, const PlannedBarrier& planned) {
  VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  barrier.srcStageMask = planned.src_stages;
  barrier.srcAccessMask = planned.src_access;
  barrier.dstStageMask = planned.dst_stages;
  barrier.dstAccessMask = planned.dst_access;
  VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &dependency);
}

constexpr VkAccessFlags2 kAnyAccess = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
// Before a frame: whatever earlier frames did is done and visible. After it: results are visible to the host too.
constexpr PlannedBarrier kFrameStart{VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                     VK_ACCESS_2_MEMORY_WRITE_BIT, kAnyAccess};
constexpr PlannedBarrier kFrameEnd{VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                   VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
                                   VK_ACCESS_2_MEMORY_WRITE_BIT, kAnyAccess | VK_ACCESS_2_HOST_READ_BIT};

}  // namespace

std::uint32_t FrameBuilder::resource_index(const ResourceRef& resource) {
  const auto at = std::find(resources_.begin(), resources_.end(), resource);
  if (at != resources_.end()) return static_cast<std::uint32_t>(at - resources_.begin());
  resources_.push_back(resource);
  resource_names_.push_back(resource_name(resource));
  return static_cast<std::uint32_t>(resources_.size() - 1);
}

void FrameBuilder::add(std::string name, const std::vector<std::pair<ResourceRef, Access>>& uses,
                       RecordFunction record) {
  StepDeclaration declaration{std::move(name), {}};
  for (const auto& [resource, access] : uses) declaration.uses.push_back({resource_index(resource), access});
  declarations_.push_back(std::move(declaration));
  steps_.push_back({std::move(record)});
}

void FrameBuilder::compute(ComputeStep step) {
  NEPHELE_CHECK(step.kernel && *step.kernel, step.name, ": no kernel");
  check_bindings(step.name, step.kernel->layout(), step.bindings);
  const auto uses = uses_of(step.kernel->layout(), step.bindings, step.indirect);
  std::string name = step.name;
  add(std::move(name), uses, [step = std::move(step)](VkCommandBuffer commands, FrameExecutor& executor) {
    const PipelineLayout& layout = step.kernel->layout();
    const VkDescriptorSet set = executor.allocate_set(layout, step.bindings);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, step.kernel->vk());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout.vk(), 0, 1, &set, 0, nullptr);
    push_constants(commands, layout, step.push, step.name);
    if (step.indirect.buffer)
      vkCmdDispatchIndirect(commands, step.indirect.buffer->vk(), step.indirect.offset);
    else
      vkCmdDispatch(commands, step.groups[0], step.groups[1], step.groups[2]);
  });
}

void FrameBuilder::raster(RasterStep step) {
  NEPHELE_CHECK(step.pipeline && *step.pipeline, step.name, ": no pipeline");
  const RasterDesc& desc = step.pipeline->desc();
  NEPHELE_CHECK(step.color.size() == desc.color_formats.size() && step.clear.size() == step.color.size(), step.name);
  check_bindings(step.name, step.pipeline->layout(), step.bindings);
  auto uses = uses_of(step.pipeline->layout(), step.bindings, step.indirect);
  for (const Image* image : step.color) {
    if (desc.ordered)
      NEPHELE_CHECK(
          std::any_of(uses.begin(), uses.end(), [&](const auto& use) { return use.first == ResourceRef(image); }),
          step.name, ": attachment ", image->name(), " is not bound as an input");
    else
      uses.emplace_back(image, Access::color);
  }
  std::string name = step.name;
  add(std::move(name), uses, [step = std::move(step)](VkCommandBuffer commands, FrameExecutor& executor) {
    const PipelineLayout& layout = step.pipeline->layout();
    const VkExtent3D extent = step.color[0]->extent();
    std::vector<VkClearValue> clear(step.clear.size());
    for (std::size_t i = 0; i < clear.size(); ++i)
      std::copy(step.clear[i].begin(), step.clear[i].end(), clear[i].color.float32);
    VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    begin.renderPass = step.pipeline->render_pass();
    begin.framebuffer = executor.framebuffer(*step.pipeline, step.color);
    begin.renderArea.extent = {extent.width, extent.height};
    begin.clearValueCount = static_cast<std::uint32_t>(clear.size());
    begin.pClearValues = clear.data();
    const VkViewport viewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1};
    const VkDescriptorSet set = executor.allocate_set(layout, step.bindings);
    executor.begin_fragment_count(commands);
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, step.pipeline->vk());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout.vk(), 0, 1, &set, 0, nullptr);
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &begin.renderArea);
    push_constants(commands, layout, step.push, step.name);
    if (step.indirect.buffer)
      vkCmdDrawIndirect(commands, step.indirect.buffer->vk(), step.indirect.offset, 1, 16);
    else
      vkCmdDraw(commands, step.vertex_count, 1, 0, 0);
    vkCmdEndRenderPass(commands);
    executor.end_fragment_count(commands);
  });
}

void FrameBuilder::fill(std::string name, const Buffer& buffer, std::uint32_t value) {
  add(std::move(name), {{&buffer, Access::transfer_write}}, [&buffer, value](VkCommandBuffer commands, FrameExecutor&) {
    vkCmdFillBuffer(commands, buffer.vk(), 0, VK_WHOLE_SIZE, value);
  });
}

void FrameBuilder::update(std::string name, const Buffer& buffer, std::vector<std::byte> data) {
  NEPHELE_CHECK(data.size() <= 65536 && data.size() % 4 == 0 && data.size() <= buffer.bytes(), name, ": ", data.size(),
                " bytes");
  add(std::move(name), {{&buffer, Access::transfer_write}},
      [&buffer, data = std::move(data)](VkCommandBuffer commands, FrameExecutor&) {
        vkCmdUpdateBuffer(commands, buffer.vk(), 0, data.size(), data.data());
      });
}

void FrameBuilder::read_back(std::string name, const Image& image, const Buffer& to) {
  NEPHELE_CHECK(to.bytes() >= image.tight_bytes(), name);
  add(std::move(name), {{&image, Access::transfer_read}, {&to, Access::transfer_write}},
      [&image, &to](VkCommandBuffer commands, FrameExecutor&) {
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageExtent = image.extent();
        vkCmdCopyImageToBuffer(commands, image.vk(), VK_IMAGE_LAYOUT_GENERAL, to.vk(), 1, &copy);
      });
}

void FrameBuilder::read_back(std::string name, const Buffer& buffer, const Buffer& to, VkDeviceSize bytes) {
  NEPHELE_CHECK(bytes <= buffer.bytes() && bytes <= to.bytes(), name);
  add(std::move(name), {{&buffer, Access::transfer_read}, {&to, Access::transfer_write}},
      [&buffer, &to, bytes](VkCommandBuffer commands, FrameExecutor&) {
        const VkBufferCopy copy{0, 0, bytes};
        vkCmdCopyBuffer(commands, buffer.vk(), to.vk(), 1, &copy);
      });
}

std::vector<PlannedBarrier> FrameBuilder::plan() const { return plan_barriers(declarations_, resources_.size()); }

std::string FrameBuilder::describe() const { return describe_plan(declarations_, plan(), resource_names_); }

FrameBuilder::FrameBuilder(FrameExecutor& executor, Reuse reuse) : memory_(&executor.memory_), reuse_(reuse) {}

bool FrameBuilder::stands(const ResourceRef& resource, InputBytes inputs, Keep keep) {
  const std::uint64_t id = std::visit([](const auto* object) { return object->id(); }, resource);
  const bool may = memory_ && (reuse_ == Reuse::all || keep == Keep::lasting);
  if (may && held(id, inputs)) return true;
  claims_.push_back({id, std::move(inputs)});
  return false;
}

bool FrameBuilder::holds(const ResourceRef& resource, const InputBytes& inputs) const {
  const std::uint64_t id = std::visit([](const auto* object) { return object->id(); }, resource);
  return memory_ && reuse_ == Reuse::all && held(id, inputs);
}

bool FrameBuilder::held(std::uint64_t id, const InputBytes& inputs) const {
  const auto latest = std::find_if(claims_.rbegin(), claims_.rend(), [&](const auto& c) { return c.resource == id; });
  return latest != claims_.rend() ? latest->inputs == inputs : memory_->holds(id, inputs);
}

FrameExecutor::FrameExecutor(Device& device) : device_(device) {
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = device.queue_family();
  NEPHELE_VK(vkCreateCommandPool(device.vk(), &pool, nullptr, &pool_));
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.commandBufferCount = 1;
  NEPHELE_VK(vkAllocateCommandBuffers(device.vk(), &allocate, &commands_));
  const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
  NEPHELE_VK(vkCreateFence(device.vk(), &fence, nullptr, &fence_));
  for (Slot& slot : slots_) make_slot(slot);
}

void FrameExecutor::make_descriptors(Slot& slot, std::uint32_t sets) {
  vkDestroyDescriptorPool(device_.vk(), slot.descriptors, nullptr);
  slot.set_capacity = sets;
  std::vector<VkDescriptorPoolSize> sizes;
  for (VkDescriptorType type : {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER})
    sizes.push_back({type, sets * kBindingsASet});
  VkDescriptorPoolCreateInfo descriptors{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  descriptors.maxSets = sets;
  descriptors.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
  descriptors.pPoolSizes = sizes.data();
  NEPHELE_VK(vkCreateDescriptorPool(device_.vk(), &descriptors, nullptr, &slot.descriptors));
}

void FrameExecutor::make_slot(Slot& slot) {
  make_descriptors(slot, kLeastSets);
  if (device_.info().fragment_count_query) {
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_PIPELINE_STATISTICS;
    info.queryCount = kMaxRasterSteps;
    info.pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_FRAGMENT_SHADER_INVOCATIONS_BIT;
    NEPHELE_VK(vkCreateQueryPool(device_.vk(), &info, nullptr, &slot.fragment_queries));
  }
}

FrameExecutor::~FrameExecutor() {
  for (const Slot& slot : slots_) {
    for (VkFramebuffer framebuffer : slot.framebuffers) vkDestroyFramebuffer(device_.vk(), framebuffer, nullptr);
    vkDestroyQueryPool(device_.vk(), slot.queries, nullptr);
    vkDestroyQueryPool(device_.vk(), slot.fragment_queries, nullptr);
    vkDestroyDescriptorPool(device_.vk(), slot.descriptors, nullptr);
  }
  vkDestroyFence(device_.vk(), fence_, nullptr);
  vkDestroyCommandPool(device_.vk(), pool_, nullptr);
}

FrameExecutor::Slot& FrameExecutor::begin_frame(std::size_t step_count) {
  Slot& slot = slots_[frames_recorded_ % kFramesInFlight];
  for (VkFramebuffer framebuffer : slot.framebuffers) vkDestroyFramebuffer(device_.vk(), framebuffer, nullptr);
  slot.framebuffers.clear();
  slot.raster_steps = 0;
  slot.step_names.clear();
  const std::uint32_t needed = static_cast<std::uint32_t>(step_count + 1);
  if (needed > slot.set_capacity)
    make_descriptors(slot, 2 * needed);
  else
    NEPHELE_VK(vkResetDescriptorPool(device_.vk(), slot.descriptors, 0));
  if (needed > slot.query_capacity) {
    vkDestroyQueryPool(device_.vk(), slot.queries, nullptr);
    slot.query_capacity = std::max(64u, 2 * needed);
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = slot.query_capacity;
    NEPHELE_VK(vkCreateQueryPool(device_.vk(), &info, nullptr, &slot.queries));
  }
  return slot;
}

void FrameExecutor::record(const FrameBuilder& frame, VkCommandBuffer commands) {
  Slot& slot = begin_frame(frame.steps_.size());
  recording_ = &slot;
  const std::vector<PlannedBarrier> barriers = frame.plan();
  vkCmdResetQueryPool(commands, slot.queries, 0, static_cast<std::uint32_t>(frame.steps_.size() + 1));
  if (slot.fragment_queries) vkCmdResetQueryPool(commands, slot.fragment_queries, 0, kMaxRasterSteps);
  memory_barrier(commands, kFrameStart);
  for (std::uint32_t i = 0; i < frame.steps_.size(); ++i) {
    // The stamp precedes the barrier: a stamp that no barrier follows reads early on lavapipe.
    vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, slot.queries, i);
    if (!barriers[i].empty()) memory_barrier(commands, barriers[i]);
    frame.steps_[i].record(commands, *this);
    slot.step_names.push_back(frame.declarations_[i].name);
  }
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, slot.queries,
                       static_cast<std::uint32_t>(frame.steps_.size()));
  memory_barrier(commands, kFrameEnd);
  recording_ = nullptr;
  memory_.commit(frame.claims_);
  ++frames_recorded_;
}

void FrameExecutor::run(const FrameBuilder& frame) {
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  NEPHELE_VK(vkBeginCommandBuffer(commands_, &begin));
  record(frame, commands_);
  NEPHELE_VK(vkEndCommandBuffer(commands_));
  VkCommandBufferSubmitInfo command_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
  command_info.commandBuffer = commands_;
  VkSubmitInfo2 submit{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &command_info;
  device_.submit(submit, fence_);
  NEPHELE_VK(vkWaitForFences(device_.vk(), 1, &fence_, VK_TRUE, UINT64_MAX));
  NEPHELE_VK(vkResetFences(device_.vk(), 1, &fence_));
}

FrameExecutor::Slot& FrameExecutor::slot_of(std::uint32_t frames_ago) {
  NEPHELE_CHECK(frames_ago < kFramesInFlight, frames_ago, " frames ago");
  return slots_[(frames_recorded_ + kFramesInFlight - 1 - frames_ago) % kFramesInFlight];
}

std::vector<PassTime> FrameExecutor::pass_times(std::uint32_t frames_ago) {
  const Slot& slot = slot_of(frames_ago);
  if (slot.step_names.empty()) return {};
  std::vector<std::uint64_t> stamps(slot.step_names.size() + 1);
  NEPHELE_VK(vkGetQueryPoolResults(device_.vk(), slot.queries, 0, static_cast<std::uint32_t>(stamps.size()),
                                   stamps.size() * sizeof(stamps[0]), stamps.data(), sizeof(stamps[0]),
                                   VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
  std::vector<PassTime> times;
  for (std::size_t i = 0; i < slot.step_names.size(); ++i) {
    const std::string& name = slot.step_names[i];
    auto row = std::find_if(times.begin(), times.end(), [&](const PassTime& time) { return time.name == name; });
    if (row == times.end()) row = times.insert(times.end(), {name, 0.0});
    row->gpu_ms += static_cast<double>(stamps[i + 1] - stamps[i]) * device_.info().timestamp_period_ns * 1e-6;
  }
  return times;
}

void FrameExecutor::begin_fragment_count(VkCommandBuffer commands) {
  NEPHELE_CHECK(recording_->raster_steps < kMaxRasterSteps);
  if (recording_->fragment_queries)
    vkCmdBeginQuery(commands, recording_->fragment_queries, recording_->raster_steps, 0);
}

void FrameExecutor::end_fragment_count(VkCommandBuffer commands) {
  if (recording_->fragment_queries) vkCmdEndQuery(commands, recording_->fragment_queries, recording_->raster_steps);
  ++recording_->raster_steps;
}

std::uint64_t FrameExecutor::fragments_shaded(std::uint32_t frames_ago) {
  const Slot& slot = slot_of(frames_ago);
  if (!slot.fragment_queries || slot.raster_steps == 0) return 0;
  std::vector<std::uint64_t> counts(slot.raster_steps);
  NEPHELE_VK(vkGetQueryPoolResults(device_.vk(), slot.fragment_queries, 0, slot.raster_steps,
                                   counts.size() * sizeof(counts[0]), counts.data(), sizeof(counts[0]),
                                   VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
  std::uint64_t sum = 0;
  for (const std::uint64_t count : counts) sum += count;
  return sum;
}

VkDescriptorSet FrameExecutor::allocate_set(const PipelineLayout& layout, const std::vector<Binding>& bindings) {
  const VkDescriptorSetLayout set_layout = layout.set_layout();
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = recording_->descriptors;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &set_layout;
  VkDescriptorSet set = VK_NULL_HANDLE;
  NEPHELE_VK(vkAllocateDescriptorSets(device_.vk(), &allocate, &set));

  std::vector<VkDescriptorBufferInfo> buffers(bindings.size());
  std::vector<VkDescriptorImageInfo> images(bindings.size());
  std::vector<VkBufferView> views(bindings.size());
  std::vector<VkWriteDescriptorSet> writes;
  for (std::size_t i = 0; i < bindings.size(); ++i) {
    const Binding& binding = bindings[i];
    const auto& reflected = layout.reflection().bindings;
    const auto at =
        std::find_if(reflected.begin(), reflected.end(), [&](const auto& r) { return r.binding == binding.binding; });
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = set;
    write.dstBinding = binding.binding;
    write.descriptorCount = 1;
    write.descriptorType = at->type;
    if (is_image(binding.resource)) {
      const VkSampler samplers[] = {device_.linear_clamp(), device_.linear_repeat(), device_.nearest_clamp()};
      const bool sampled = at->type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
      images[i] = {sampled ? samplers[static_cast<int>(binding.sampler)] : VK_NULL_HANDLE,
                   std::get<const Image*>(binding.resource)->view(), VK_IMAGE_LAYOUT_GENERAL};
      write.pImageInfo = &images[i];
    } else if (at->type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER) {
      const VkFormat format = binding.access == Access::words ? VK_FORMAT_R32_UINT : VK_FORMAT_R32G32B32A32_UINT;
      views[i] = std::get<const Buffer*>(binding.resource)->texel_view(format);
      write.pTexelBufferView = &views[i];
    } else {
      buffers[i] = {std::get<const Buffer*>(binding.resource)->vk(), 0, VK_WHOLE_SIZE};
      write.pBufferInfo = &buffers[i];
    }
    writes.push_back(write);
  }
  vkUpdateDescriptorSets(device_.vk(), static_cast<std::uint32_t>(writes.size()), writes.data(), 0, nullptr);
  return set;
}

VkFramebuffer FrameExecutor::framebuffer(const RasterPipeline& pipeline, const std::vector<const Image*>& color) {
  std::vector<VkImageView> views;
  for (const Image* image : color) views.push_back(image->view());
  VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
  info.renderPass = pipeline.render_pass();
  info.attachmentCount = static_cast<std::uint32_t>(views.size());
  info.pAttachments = views.data();
  info.width = color[0]->desc().width;
  info.height = color[0]->desc().height;
  info.layers = 1;
  VkFramebuffer framebuffer = VK_NULL_HANDLE;
  NEPHELE_VK(vkCreateFramebuffer(device_.vk(), &info, nullptr, &framebuffer));
  recording_->framebuffers.push_back(framebuffer);
  return framebuffer;
}

}  // namespace nephele
