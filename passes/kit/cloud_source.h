// What yields clouds: everything that fills a range of the frame's particle buffer stands behind this interface.
//
// A source is a function of scene, camera and time: it keeps no history that a frame could show. What it leaves from
// frame to frame is work that it would do again alike. Particles of all sources lie one after another in one buffer;
// its capacity is the sum of the sources', so each source decides by itself what finds no room.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
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
};
inline constexpr float kNoTopM = 1e30f;

// A rectangle of ground under all clouds of a source, which stands still in the air of a wind.
struct CloudBounds {
  glm::dvec2 low_m, high_m;  // counted from Scene::world_origin_m, at time 0
  glm::dvec2 drift_m_per_s;
};

// Of both together.
CloudExtent united(const CloudExtent& a, const CloudExtent& b);

// From where a source is asked for its particles.
struct FrameView {
  glm::dvec3 camera_m{0.0};  // in the world, counted from Scene::world_origin_m; of a camera that drifts: at time 0
  double time_s = 0.0;
  glm::dvec2 drift_m_per_s{0.0};  // of the camera, with the air of a wind

  // Its place in the air of a wind, exactly camera_m where it drifts with that air.
  glm::dvec3 in_air(const glm::dvec2& wind_m_per_s) const {
    return camera_m + glm::dvec3((drift_m_per_s - wind_m_per_s) * time_s, 0.0);
  }
};

// Where a source's particles go.
struct ParticleSink {
  const Buffer& particles;  // Particle
  const Buffer& counters;   // FrameCounters: particle_count is where the source begins; it adds its own
  const Buffer& records;    // SourceRecord of every source; the source fills its own
  std::uint32_t source;     // its index there and in Particle.flags
  std::string row;          // of the steps in the timings
};

class CloudSource {
 public:
  CloudSource(std::string name, std::uint32_t capacity) : name_(std::move(name)), capacity_(capacity) {}
  virtual ~CloudSource() = default;
  CloudSource(const CloudSource&) = delete;
  CloudSource& operator=(const CloudSource&) = delete;

  const std::string& name() const { return name_; }     // its row in the timings, and in its buffers' names
  std::uint32_t capacity() const { return capacity_; }  // particles at most
  virtual CloudExtent extent() const = 0;               // at any time
  virtual std::optional<CloudBounds> bounds() const { return std::nullopt; }  // none: clouds everywhere
  virtual float extinction_per_m() const = 0;                                 // of its clouds where they are dense
  virtual bool has_soft_particles() const { return false; }                   // kParticleSoft
  virtual InputBytes inputs(const FrameView&) const = 0;  // what its particles depend on besides the scene
  // Appends the steps that put its particles into the sink.
  virtual void add(FrameBuilder& frame, const FrameView& view, const ParticleSink& sink) = 0;

  // The same clouds for the light field: within reach_m of a view, by particles of about the size of a cell, alike all
  // over. Null: the source itself gives them.
  virtual std::unique_ptr<CloudSource> evenly(Workshop&, const std::string& /*name*/, double /*reach_m*/,
                                              double /*cell_m*/) const {
    return nullptr;
  }

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

// How far clouds are drawn: as far as the field that reaches farthest, else a field's default.
double view_distance_m(const Scene& scene);

// Particles that passes can work with on a device: the largest array with an element for each must fit.
std::uint32_t most_particles(const Device& device);

}  // namespace nephele
