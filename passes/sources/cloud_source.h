// What yields clouds: everything that fills a range of the frame's particle buffer stands behind this interface.
//
// A source is a function of scene, camera and time: it keeps no history that a frame could show. What it leaves from
// frame to frame is work that it would do again alike. Particles of all sources lie one after another in one buffer;
// its capacity is the sum of the sources', so each source decides by itself what finds no room.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/scene.h"
#include "engine/workshop.h"
#include "shared/types.h"

namespace nephele {

struct RenderSettings;

// What other passes may assume about clouds.
struct CloudExtent {
  float lowest_m, highest_m;  // altitudes between which all of their matter lies; highest_m at most kNoTopM
  float ground_cover;         // share of the ground in their shadow under an overhead sun
};
inline constexpr float kNoTopM = 1e30f;

// Of both together. Clouds of different sources stand where they like: independently.
CloudExtent united(const CloudExtent& a, const CloudExtent& b);

struct FrameView {
  glm::dvec3 camera_m{0.0};  // in the world, counted from Scene::world_origin_m
  double time_s = 0.0;
};

// Where a source's particles go.
struct ParticleSink {
  const Buffer& particles;  // Particle
  const Buffer& counters;   // FrameCounters: particle_count is where the source begins; it adds its own
  const Buffer& records;    // SourceRecord of every source; the source fills its own
  std::uint32_t source;     // its index there and in Particle.flags
};

class CloudSource {
 public:
  CloudSource(std::string name, std::uint32_t capacity) : name_(std::move(name)), capacity_(capacity) {}
  virtual ~CloudSource() = default;
  CloudSource(const CloudSource&) = delete;
  CloudSource& operator=(const CloudSource&) = delete;

  const std::string& name() const { return name_; }       // its row in the timings, and in its buffers' names
  std::uint32_t capacity() const { return capacity_; }    // particles at most
  virtual CloudExtent extent() const = 0;                 // at any time
  virtual float extinction_per_m() const = 0;             // of its clouds where they are dense
  virtual InputBytes inputs(const FrameView&) const = 0;  // what its particles depend on besides the scene
  // Appends the steps, all of them under its name, that put its particles into the sink.
  virtual void add(FrameBuilder& frame, const FrameView& view, const ParticleSink& sink) = 0;

 protected:
  std::string name_;
  std::uint32_t capacity_;
};

// The sources of a scene, in the order of their particles: "particles", "clouds", "sources". Those that can have no
// particle are left out.
std::vector<std::unique_ptr<CloudSource>> make_sources(Workshop& make, const Scene& scene,
                                                       const RenderSettings& settings);

// The wind that carries the scene's air and whatever drifts with it: the first field's, or none.
glm::dvec2 scene_wind_m_per_s(const Scene& scene);

// Particles that passes can work with on a device: the largest array with an element for each must fit.
std::uint32_t most_particles(const Device& device);

}  // namespace nephele
