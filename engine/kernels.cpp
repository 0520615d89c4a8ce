#include "engine/kernels.h"

namespace nephele {
namespace {

std::uint64_t address(const ShaderCode* code) { return reinterpret_cast<std::uintptr_t>(code); }

void append(std::vector<std::uint64_t>& key, std::span<const SpecConstant> constants) {
  for (const SpecConstant& constant : constants) key.push_back(std::uint64_t{constant.id} << 32 | constant.value);
}

}  // namespace

const ComputeKernel& Kernels::compute(const ShaderCode& code, std::span<const SpecConstant> constants) {
  Key key{address(&code)};
  append(key, constants);
  std::unique_ptr<ComputeKernel>& kernel = compute_[key];
  if (!kernel) kernel = std::make_unique<ComputeKernel>(device_, code, constants);
  return *kernel;
}

const RasterPipeline& Kernels::raster(const RasterDesc& desc) {
  Key key{address(desc.vertex), address(desc.fragment), desc.ordered, desc.color_formats.size(), desc.blends.size()};
  for (const VkFormat format : desc.color_formats) key.push_back(static_cast<std::uint64_t>(format));
  for (const Blend blend : desc.blends) key.push_back(static_cast<std::uint64_t>(blend));
  append(key, desc.constants);
  std::unique_ptr<RasterPipeline>& pipeline = raster_[key];
  if (!pipeline) pipeline = std::make_unique<RasterPipeline>(device_, desc);
  return *pipeline;
}

}  // namespace nephele
