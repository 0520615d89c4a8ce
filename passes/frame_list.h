// The frame: every pass of the renderer and, in frame_list.cpp alone, their order.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "engine/result.h"
#include "lut/gpu_tables.h"
#include "passes/kit/cloud_source.h"
#include "passes/layer/cloud_layer.h"
#include "passes/layer/shading_volumes.h"
#include "passes/nephele.h"
#include "shared/types.h"

namespace nephele {

struct CompositeInputs;

class FramePasses {
 public:
  // Tables and volumes must outlive it.
  FramePasses(Workshop& make, const GpuTables& tables, const ShadingVolumes& volumes, const Scene& scene,
              const RenderSettings& settings);
  ~FramePasses();

  // Appends all steps that this frame's scene needs and no earlier frame has done alike. constants.host_scene: a host
  // has drawn something, or the scene has terrain. slot: of the read-back buffers, below kFramesInFlight.
  void add(FrameBuilder& frame, const shared::FrameConstants& constants, const FrameView& view, const HostScene& host,
           std::uint32_t slot);

  // What the frame's clouds depend on besides the scene: equal bytes, equal clouds.
  InputBytes cloud_inputs(const FrameView& view) const;

  // Of all clouds of the scene.
  CloudExtent cloud_extent() const;

  // An error names the settings whose arrays the device does not allow.
  static Result<void> check(const Device& device, const RenderSettings& settings);

  // Counts of the last frame that was added with this slot, once it has run.
  void count(FrameStats& stats, std::uint32_t slot) const;

  const Image& hdr() const { return hdr_; }
  const Image& display() const { return display_; }
  std::vector<shared::Particle> read_particles(std::uint32_t slot) const;
  // Light at places, counted from the last frame's camera (z = altitude), as that frame, which has run, left it. None
  // where the scene has no clouds or its light is from tables.
  std::optional<std::vector<LightAt>> light_at(Kernels& kernels, const std::vector<glm::vec3>& places_m) const;
  const CloudLayer* cloud_layer() const;  // null when the scene has no clouds at all

 private:
  struct Clouds;  // the passes that only a scene with clouds needs
  struct Passes;  // all of them
  void add_clouds(FrameBuilder& frame, const shared::FrameConstants& constants, const FrameView& view,
                  CompositeInputs& composite, std::uint32_t slot);

  const GpuTables& tables_;
  const ShadingVolumes& volumes_;
  const Image& hdr_;
  const Image& display_;
  glm::dvec2 origin_m_;  // Scene::world_origin_m
  std::unique_ptr<Passes> passes_;
};

}  // namespace nephele
