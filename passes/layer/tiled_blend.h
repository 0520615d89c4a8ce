// The tiled backend: shading and blending of the visible particles in compute, a thread a pixel (on a CPU a column),
// over lists of the particles that each tile of 8 x 8 pixels may show. Runs on every device.
//
// reads -> writes: draw particles (farthest first), tables, counters -> layer colour and depth; in counters
//   screen_pair_*, pairs_shaded
// cost: (pixel, particle) pairs up to where a pixel turns opaque; one sort of the (tile, particle) pairs. A tile
// without particles costs one store a pixel.
#pragma once

#include <cstdint>

#include "lut/gpu_tables.h"
#include "passes/layer/screen_lists.h"
#include "passes/layer/shading_inputs.h"
#include "passes/settings.h"

namespace nephele {

class TiledBlend {
 public:
  TiledBlend(Workshop& make, const GpuTables& tables, BlendMode mode, std::uint32_t layer_width,
             std::uint32_t layer_height, std::uint32_t visible_capacity, const ShadingVariant& variant);

  struct Inputs {
    const Buffer& frame_constants;
    const Buffer& draw_particles;
    const Buffer& counters;  // FrameCounters: visible_count and visible_groups are filled
    const ShadingInputs& shading;
    const Image& layer_scene;  // metres to what stands behind, at the layer's size
  };
  void add(FrameBuilder& frame, const Inputs& inputs, const Image& layer_color, const Image& layer_depth);

 private:
  const ComputeKernel& masks_kernel_;
  const ComputeKernel& begins_kernel_;
  const ComputeKernel& shade_short_;
  const ComputeKernel& shade_long_;
  const ComputeKernel* shade_page_ = nullptr;  // none where no list is longer than a page
  ScreenLists lists_;
  std::uint32_t short_list_, pages_;
  Buffer& masks_;
  Buffer& begins_m_;
  Buffer& long_tiles_;
  Buffer& paged_tiles_;
  const Buffer* paged_pixels_ = nullptr;
};

}  // namespace nephele
