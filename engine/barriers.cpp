#include "engine/barriers.h"

#include <sstream>

#include "engine/check.h"

namespace nephele {
namespace {

constexpr VkPipelineStageFlags2 kShaders = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT |
                                           VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |
                                           VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;

struct Scope {
  VkPipelineStageFlags2 stages;
  VkAccessFlags2 access;
};

// What has happened to a resource since its last write.
struct ResourceState {
  Scope write{0, 0};                  // the last write; stages = 0: none in this frame
  VkPipelineStageFlags2 readers = 0;  // stages that have read it since
  std::vector<Scope> visible_to;      // scopes that barriers have already made that write visible to
};

bool covers(const Scope& outer, const Scope& inner) {
  return (inner.stages & ~outer.stages) == 0 && (inner.access & ~outer.access) == 0;
}

bool visible(const ResourceState& state, const Scope& reader) {
  for (const Scope& scope : state.visible_to)
    if (covers(scope, reader)) return true;
  return false;
}

void require(PlannedBarrier& barrier, const Scope& from, const Scope& to) {
  barrier.src_stages |= from.stages;
  barrier.src_access |= from.access;
  barrier.dst_stages |= to.stages;
  barrier.dst_access |= to.access;
}

}  // namespace

AccessMasks access_masks(Access access) {
  switch (access) {
    case Access::uniform:
      return {kShaders, VK_ACCESS_2_UNIFORM_READ_BIT, 0};
    case Access::sampled:
    case Access::texels:
    case Access::words:
      return {kShaders, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, 0};
    case Access::storage_read:
      return {kShaders, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, 0};
    case Access::storage_write:
      return {kShaders, 0, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT};
    case Access::storage_read_write:
      return {kShaders, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT};
    case Access::color:
      return {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT,
              VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT};
    case Access::color_ordered:
      return {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
              VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_INPUT_ATTACHMENT_READ_BIT,
              VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT};
    case Access::indirect:
      return {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, 0};
    case Access::transfer_read:
      return {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT, 0};
    case Access::transfer_write:
      return {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, 0, VK_ACCESS_2_TRANSFER_WRITE_BIT};
    case Access::host_read:
      return {VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT, 0};
  }
  return {};
}

const char* access_name(Access access) {
  switch (access) {
    case Access::uniform:
      return "uniform";
    case Access::sampled:
      return "sampled";
    case Access::texels:
      return "texels";
    case Access::words:
      return "words";
    case Access::storage_read:
      return "storage_read";
    case Access::storage_write:
      return "storage_write";
    case Access::storage_read_write:
      return "storage_read_write";
    case Access::color:
      return "color";
    case Access::color_ordered:
      return "color_ordered";
    case Access::indirect:
      return "indirect";
    case Access::transfer_read:
      return "transfer_read";
    case Access::transfer_write:
      return "transfer_write";
    case Access::host_read:
      return "host_read";
  }
  return "?";
}

std::vector<PlannedBarrier> plan_barriers(std::span<const StepDeclaration> steps, std::size_t resource_count) {
  std::vector<ResourceState> states(resource_count);
  std::vector<PlannedBarrier> barriers;
  for (const StepDeclaration& step : steps) {
    PlannedBarrier barrier;
    for (const ResourceUse& use : step.uses) {
      NEPHELE_CHECK(use.resource < resource_count, step.name);
      const ResourceState& state = states[use.resource];
      const AccessMasks masks = access_masks(use.access);
      const Scope reading{masks.stages, masks.reads};
      const Scope touching{masks.stages, masks.reads | masks.writes};
      if (masks.writes) {
        if (state.write.stages) require(barrier, state.write, touching);
        if (state.readers) require(barrier, {state.readers, 0}, touching);  // write after read: execution only
      } else if (state.write.stages && !visible(state, reading)) {
        require(barrier, state.write, reading);
      }
    }
    if (!barrier.empty()) {
      const Scope source{barrier.src_stages, barrier.src_access};
      for (ResourceState& state : states)
        if (state.write.stages && covers(source, state.write))
          state.visible_to.push_back({barrier.dst_stages, barrier.dst_access});
    }
    for (const ResourceUse& use : step.uses) {
      ResourceState& state = states[use.resource];
      const AccessMasks masks = access_masks(use.access);
      if (masks.writes) state = {{masks.stages, masks.writes}, 0, {}};
    }
    for (const ResourceUse& use : step.uses) {
      const AccessMasks masks = access_masks(use.access);
      if (!masks.writes) states[use.resource].readers |= masks.stages;
    }
    barriers.push_back(barrier);
  }
  return barriers;
}

std::string describe_plan(std::span<const StepDeclaration> steps, std::span<const PlannedBarrier> barriers,
                          std::span<const std::string> resource_names) {
  std::ostringstream text;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (!barriers[i].empty())
      text << "    barrier  stages " << std::hex << barriers[i].src_stages << " -> " << barriers[i].dst_stages
           << "  access " << barriers[i].src_access << " -> " << barriers[i].dst_access << std::dec << "\n";
    text << steps[i].name << ":";
    for (const ResourceUse& use : steps[i].uses)
      text << " " << resource_names[use.resource] << "=" << access_name(use.access);
    text << "\n";
  }
  return text.str();
}

}  // namespace nephele
