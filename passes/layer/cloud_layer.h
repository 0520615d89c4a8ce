// The cloud layer: visible particles, back to front, shaded from the tables and blended volume-aware into colour,
// transmittance and distance ([Yusov14] 5.4, 5.5); composing brings them to the image's resolution (composite.h).
//
// reads -> writes: particles, visible list, draw order, lights, tables -> draw particles -> blend state -> layer
// cost: fragments (particles times their area in pixels of the layer), each two table fetches and two noise fetches.
#pragma once

#include <cstdint>
#include <memory>

#include "engine/workshop.h"
#include "lut/gpu_tables.h"
#include "passes/layer/raster_blend.h"
#include "passes/layer/ray_march.h"
#include "passes/layer/tiled_blend.h"
#include "passes/settings.h"

namespace nephele {

// What a device blends with when asked for `automatic`, and why.
struct BackendChoice {
  Backend backend;
  const char* reason;
};
BackendChoice automatic_backend(const DeviceInfo& device);
Backend resolve_backend(const DeviceInfo& device, Backend wanted);
bool backend_available(const DeviceInfo& device, Backend backend);

class CloudLayer {
 public:
  struct Size {
    std::uint32_t width, height;  // of the image, pixels
    std::uint32_t scale;          // the layer has ceil(size / scale) pixels
    bool full_layer = true;       // kept at the image's resolution too
  };
  // backend is not `automatic`; only `tiled` blends exactly.
  // march_steps > 0: rays are marched (ray_march.h) and no backend blends; the draw order is by nearest points then.
  // The tables must outlive it.
  CloudLayer(Workshop& make, const GpuTables& tables, Size size, Backend backend, BlendMode blend,
             std::uint32_t visible_capacity, const ShadingVariant& variant, std::uint32_t march_steps = 0);

  struct Inputs {
    const Buffer& frame_constants;
    const Buffer& particles;
    const Buffer& visible;
    const Buffer& draw_order;
    const Buffer& lights;
    const Buffer& counters;  // FrameCounters: visible_groups and draw are filled
    const Buffer& records;   // SourceRecord of every source of clouds
    const Image& sky_irradiance;
    const ShadingInputs& shading;
    const Buffer& light_lattice;  // of the light field; a dummy for Light::tables
    const Image& host_distance;   // metres along the ray, at the image's size; read if FrameConstants::host_scene
  };
  void add(FrameBuilder& frame, const Inputs& inputs);

  // What add leaves: premultiplied radiance and transmittance; metres to the first matter, +inf without; to what stands
  // behind.
  const Image& layer_color() const { return layer_color_; }
  const Image& layer_depth() const { return layer_depth_; }
  const Image& layer_scene() const { return layer_scene_; }

  // The same at the image's resolution, once the frame is composed: premultiplied radiance and transmittance; metres to
  // the first matter, +inf without. Null where it is not kept.
  const Image* color() const { return scale_ == 1 ? &layer_color_ : full_color_; }
  const Image* depth() const { return scale_ == 1 ? &layer_depth_ : full_depth_; }

 private:
  std::uint32_t scale_;
  const ComputeKernel& prepare_;
  const ComputeKernel& scene_distance_;
  const Buffer& draw_particles_;
  const Image& layer_scene_;  // metres to what stands behind the clouds
  const Image& layer_color_;
  const Image& layer_depth_;
  const Image* full_color_ = nullptr;
  const Image* full_depth_ = nullptr;
  // One of them: how the layer is made of the particles.
  std::unique_ptr<RayMarch> march_;
  std::unique_ptr<TiledBlend> tiled_;
  std::unique_ptr<RasterBlend> raster_;
};

}  // namespace nephele
