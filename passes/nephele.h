// Nephele, the public surface: a renderer of large cumulus skies.
//
//   auto device = nephele::Device::create(nephele::DeviceOptions::from_environment());
//   auto tables = nephele::load_or_bake(parameters, nephele::default_cache_dir());
//   auto sky = nephele::Sky::create(**device, *tables);
//   auto renderer = nephele::Renderer::create(**sky, scene, settings);
//   (*renderer)->render(camera, time_s);
//   auto pixels = (*renderer)->read_display();
//   (*renderer)->set(scene_at_noon, settings);  // from the next frame on
//
// A host that has a VkDevice lends it through Device::adopt (engine/device.h) and records frames into its own command
// buffers. The device must be one of Vulkan 1.3 with a queue for graphics and compute that has timestamps, created with
// the features scalarBlockLayout, synchronization2, maintenance4, fragmentStoresAndAtomics, independentBlend and
// shaderStorageImageExtendedFormats; docs/devices.md has the limits, which few devices fall short of.
// Optional, and named to adopt when enabled: VK_EXT_fragment_shader_interlock (fragmentShaderPixelInterlock),
// VK_EXT_rasterization_order_attachment_access (rasterizationOrderColorAttachmentAccess), pipelineStatisticsQuery.
//
// A frame depends on scene, settings, camera and time alone. Work whose inputs stayed the same since the frame before
// is not done again; what it left is what it would leave again, bit for bit. Sky and its renderers: one thread at a
// time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/device.h"
#include "engine/pass_time.h"
#include "engine/result.h"
#include "engine/scene.h"
#include "lut/tables.h"
#include "passes/light/light_at.h"
#include "passes/settings.h"

namespace nephele {

class Image;
namespace shared {
struct Particle;  // shared/types.h
}

// What a host has drawn and the clouds stand in front of or behind: full-size images of the renderer's device, in
// layout GENERAL. Where it has drawn nothing the scene's own sky and ground show.
struct HostScene {
  const Image* radiance = nullptr;    // a float format: linear R G B, before haze and exposure
  const Image* distance_m = nullptr;  // R32F: from the camera along the pixel's ray; +inf where nothing is drawn
};

struct SourceStats {
  std::string name;  // of its row in the times
  std::uint32_t particles_generated = 0;
  std::uint64_t overflow = 0;  // particles that found no room
};

struct FrameStats {
  std::uint32_t particles_generated = 0;
  std::uint32_t particles_visible = 0;
  std::vector<SourceStats> sources;               // in the order of their particles
  std::map<std::string, std::uint64_t> overflow;  // buffer -> items that found no room; all 0 in a good frame
  std::vector<PassTime> passes;                   // GPU time by pass, in frame order; none when nothing had changed
  double frame_ms = 0;                            // wall time of the whole frame, recording included; 0 from collect()
  double cpu_ms = 0;                              // of that: building and recording on the CPU
  std::uint64_t gpu_memory_bytes = 0;
  std::uint64_t fragments_shaded = 0;  // cloud fragments; 0 where the device can't count them
  std::uint64_t pairs_shaded = 0;      // (pixel, particle) pairs, where the tiled backend is in use
  std::string backend;                 // the one in use
};

// What all renderers of a device share: pipelines, the tables on the device, noise. Outlives its renderers.
class Sky {
 public:
  // The device must outlive it. One clear line when the device lacks something that every frame needs.
  static Result<std::unique_ptr<Sky>> create(Device& device, const Tables& tables);
  ~Sky();

  Device& device() const;
  std::size_t pipeline_count() const;  // pipelines made so far

 private:
  friend class Renderer;
  struct Implementation;
  explicit Sky(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

class Renderer {
 public:
  // One clear line when the device lacks the backend or the settings are out of range; create and set fail with it,
  // with that of check_weather_map, and when the scene's phase function is not the one that the sky's tables are baked
  // for.
  static Result<void> check(const Device& device, const RenderSettings& settings);
  static Result<std::unique_ptr<Renderer>> create(Sky& sky, const Scene& scene, const RenderSettings& settings);
  // Frames recorded so far must have finished.
  ~Renderer();

  // Another scene or other settings, from the next frame on, which is bit for bit a new renderer's. Compiles nothing
  // for another sun, sky, exposure, cloud or blend, and allocates only what must be larger than it was or of another
  // size. On an error all stays as it was. Frames that are still under way are not disturbed; images of another size
  // than before are other images.
  Result<void> set(const Scene& scene, const RenderSettings& settings);

  // Renders one frame and waits for it. The camera is in world space; time moves the clouds with the wind.
  void render(const CameraState& camera, double time_s, const HostScene& host = {});

  // The same for a host with its own command buffer (of a device lent through Device::adopt): records the frame, and
  // the host submits it, in the order of recording. Two frames may be under way: before a frame is recorded the host
  // must have waited for the last but one. The images below are in layout GENERAL, made visible to everything that
  // follows.
  void record(const CameraState& camera, double time_s, VkCommandBuffer commands, const HostScene& host = {});
  // Reads times and counts of the oldest recorded frame that has not been collected into stats(); the host must have
  // waited for that frame. Of two frames at most: those of older ones are gone.
  void collect();
  // For a host that recorded frames and did not submit them: the next frame relies on no earlier one.
  void forget();
  const Image& hdr() const;      // RGBA32F, linear radiance before exposure
  const Image& display() const;  // RGBA8, tone-mapped sRGB
  const Image* cloud_color()
      const;  // RGBA32F, premultiplied radiance and transmittance; null: a scene without clouds, or not kept
  const Image* cloud_depth() const;  // R32F, metres to the first matter, +inf without

  // Of the last frame, which must have finished; row by row from the top left.
  std::vector<float> read_hdr();             // linear R G B A, before exposure and tone mapping; A = 1
  std::vector<std::uint8_t> read_display();  // tone-mapped sRGB R G B A
  std::vector<float> read_layers();          // R G B T Z: the cloud layer alone, if it is kept; Z = +inf without matter

  // The clouds of the last frame, whether or not the camera sees them: render space, weighted by level of detail.
  std::vector<shared::Particle> read_particles();

  // Light at places of the world (east, north, altitude in metres) among the clouds of the last frame, which must have
  // finished: what a host needs to light things of its own as the clouds are lit. Among them it is as good as
  // theirs, cell by cell; clouds that change are those of the nearest second; farther off than the light field's widest
  // window it is what comes in at that window's border. An error where light is from tables, where the scene has no
  // clouds, or before the first frame.
  Result<std::vector<LightAt>> light_at(const std::vector<glm::dvec3>& places_m);

  const FrameStats& stats() const;
  std::string describe_frame() const;  // the last frame's steps and barriers in words

 private:
  struct Implementation;
  explicit Renderer(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace nephele
