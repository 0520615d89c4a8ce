// Pipelines by shader and constants, each made once and kept: everything that draws with one device shares them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "engine/kernel.h"

namespace nephele {

class Kernels {
 public:
  explicit Kernels(Device& device) : device_(device) {}

  Device& device() const { return device_; }

  // The same object for the same shader and constants; it lives as long as this.
  const ComputeKernel& compute(const ShaderCode& code, std::span<const SpecConstant> constants = {});
  const RasterPipeline& raster(const RasterDesc& desc);

  // Pipelines made so far.
  std::size_t count() const { return compute_.size() + raster_.size(); }

 private:
  using Key = std::vector<std::uint64_t>;

  Device& device_;
  std::map<Key, std::unique_ptr<ComputeKernel>> compute_;
  std::map<Key, std::unique_ptr<RasterPipeline>> raster_;
};

}  // namespace nephele
