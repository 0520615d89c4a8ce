// Nephele, the public surface: a renderer of large cumulus skies.
//
//   auto device = nephele::Device::create(nephele::DeviceOptions::from_environment());
//   auto tables = nephele::load_or_bake(parameters, nephele::default_cache_dir());
//   auto renderer = nephele::Renderer::create(**device, *tables, scene, settings);
//   (*renderer)->render(camera, time_s);
//   auto pixels = (*renderer)->read_display();
//
// A host that has a VkDevice lends it through Device::adopt and records frames into its own command buffers.
//
// A frame depends on scene, camera and time alone. Work whose inputs stayed the same since the frame before is not done
// again; what it left is what it would leave again, bit for bit. One thread at a time.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/device.h"
#include "engine/frame.h"
#include "engine/result.h"
#include "engine/scene.h"
#include "lut/tables.h"
#include "passes/layer/cloud_layer.h"
#include "shared/types.h"

namespace nephele {

// [Yusov14] Table 1: cells along a ring's side, rings, layers (here: above the base particle).
enum class Quality : std::uint8_t { low, medium, high };

// Particles shaded whole and blended, or rays marched through the same particles' density: the baseline.
enum class Method : std::uint8_t { particles, raymarch };

struct RenderSettings {
  std::uint32_t width = 1280, height = 720;  // 1 .. kMaxImageSide
  Quality quality = Quality::medium;
  std::uint32_t scale = 1;  // the cloud layer has 1 / scale of the resolution: 1, 2 or 4
  bool full_layer =
      true;           // off: at a scale above 1 the cloud layer alone is not kept at full size, which saves its writing
  bool reuse = true;  // off: every frame does all its work again, which changes no pixel
  Backend backend = Backend::automatic;
  BlendMode blend = BlendMode::volume;  // exact needs the tiled backend
  bool culling = true;                  // off: particles out of view are lit and sorted too, which changes no pixel
  Method method = Method::particles;    // raymarch has no use for backend and blend
  std::uint32_t march_steps =
      64;  // that take a marched ray through eight particles in a row, kMinMarchSteps .. kMaxMarchSteps
  std::uint32_t ring_size_cells = 0;  // cells along a ring's side; 0: the quality's
  std::uint32_t layer_count = 0;      // particles stacked in a cell, base included; 0: the quality's
};
inline constexpr std::uint32_t kMaxImageSide = 16384;
inline constexpr std::uint32_t kMinRingSizeCells = 40, kMaxRingSizeCells = 256;  // a multiple of 8
inline constexpr std::uint32_t kMaxLayers = 15;
inline constexpr std::uint32_t kMinMarchSteps = 4, kMaxMarchSteps = 4096;

const char* method_name(Method method);

// What a host has drawn and the clouds stand in front of or behind: full-size images of the renderer's device, in
// layout GENERAL. Where it has drawn nothing the scene's own sky and ground show.
struct HostScene {
  const Image* radiance = nullptr;    // a float format: linear R G B, before haze and exposure
  const Image* distance_m = nullptr;  // R32F: from the camera along the pixel's ray; +inf where nothing is drawn
};

struct FrameStats {
  std::uint32_t particles_generated = 0;
  std::uint32_t particles_visible = 0;
  std::map<std::string, std::uint64_t> overflow;  // buffer -> items that found no room; all 0 in a good frame
  std::vector<PassTime> passes;                   // GPU time by pass, in frame order; none when nothing had changed
  double frame_ms = 0;                            // wall time of the whole frame, recording included
  double cpu_ms = 0;                              // of that: building and recording on the CPU
  std::uint64_t gpu_memory_bytes = 0;
  std::uint64_t fragments_shaded = 0;  // cloud fragments; 0 where the device can't count them
  std::uint64_t pairs_shaded = 0;      // (pixel, particle) pairs, where the tiled backend is in use
  std::string backend;                 // the one in use
};

class Renderer {
 public:
  // One clear line when the device lacks the backend or the settings are out of range; create fails with it, and with
  // that of check_weather_map.
  static Result<void> check(const Device& device, const RenderSettings& settings);
  static Result<std::unique_ptr<Renderer>> create(Device& device, const Tables& tables, const Scene& scene,
                                                  const RenderSettings& settings);
  ~Renderer();

  // Renders one frame and waits for it. The camera is in world space; time moves the clouds with the wind.
  void render(const CameraState& camera, double time_s, const HostScene& host = {});

  // The same for a host with its own command buffer (of a device lent through Device::adopt): records the frame, the
  // host submits it, as the next one builds on it. Before the next frame is recorded the host must have waited for this
  // one; then collect() reads its times and counts. The images below are in layout GENERAL, made visible to everything
  // that follows.
  void record(const CameraState& camera, double time_s, VkCommandBuffer commands, const HostScene& host = {});
  void collect();
  const Image& hdr() const;      // RGBA32F, linear radiance before exposure
  const Image& display() const;  // RGBA8, tone-mapped sRGB
  const Image* cloud_color()
      const;  // RGBA32F, premultiplied radiance and transmittance; null: a scene without clouds, or not kept
  const Image* cloud_depth() const;  // R32F, metres to the first matter, +inf without

  // Of the last frame, row by row from the top left.
  std::vector<float> read_hdr();             // linear R G B A, before exposure and tone mapping; A = 1
  std::vector<std::uint8_t> read_display();  // tone-mapped sRGB R G B A
  std::vector<float> read_layers();          // R G B T Z: the cloud layer alone, if it is kept; Z = +inf without matter

  // The clouds of the last frame, whether or not the camera sees them: render space, weighted by level of detail.
  std::vector<shared::Particle> read_particles();

  const FrameStats& stats() const;
  std::string describe_frame() const;  // the last frame's steps and barriers in words

 private:
  struct Implementation;
  explicit Renderer(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace nephele
