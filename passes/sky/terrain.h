// Terrain as a host's scene would be: radiance and distance of every pixel, between which and the camera the clouds
// stand. What a host has drawn itself is taken in; the nearer of both shows.
//
// reads -> writes: frame constants, heights, host's distance -> distance image; before the clouds are drawn
//   heights -> horizon towards the sun (anew when the sun has moved), openness to the sky (once)
//   distance, clouds' shadow, atmosphere tables, host's radiance -> radiance image
// cost: a walk of some dozen nodes a pixel through a pyramid of maxima; some thirty look-ups and the ground's pattern
//   for each pixel of land.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "engine/terrain_grid.h"
#include "engine/workshop.h"
#include "passes/kit/air_tables.h"
#include "shared/heightfield.h"
#include "shared/types.h"

namespace nephele {

class TerrainPass {
 public:
  // For images of this size.
  TerrainPass(Workshop& make, const Terrain& terrain, std::uint32_t width, std::uint32_t height);

  struct HostImages {
    const Image& distance;  // of a dummy where there is no host
    const Image& radiance;
    bool drawn;
  };
  // Distances, +inf where neither terrain nor host is. camera_m: in the world; camera_pattern_m: there, but counted
  // from where the ground's pattern begins.
  const Image& add_distance(FrameBuilder& frame, const Buffer& frame_constants, const glm::dvec3& camera_m,
                            const glm::dvec3& camera_pattern_m, const HostImages& host);

  // air, cloud_shadow: null where the frame has none. After add_distance.
  const Image& add_radiance(FrameBuilder& frame, const Buffer& frame_constants, const glm::vec3& sun_direction,
                            const AtmosphereTables* air, const Image* cloud_shadow, const HostImages& host);

 private:
  TerrainPass(Workshop& make, const TerrainGrid& grid, std::uint32_t width, std::uint32_t height);
  void add_horizon(FrameBuilder& frame, const glm::vec3& sun_direction);
  void add_openness(FrameBuilder& frame);
  const ComputeKernel& radiance_kernel(bool air, bool cloud_shadow) const;

  Workshop& make_;
  glm::dvec2 corner_m_, spacing_m_;
  shared::TerrainConstants constants_;  // what does not change from frame to frame
  const ComputeKernel& begin_kernel_;
  const ComputeKernel& distance_kernel_;
  const ComputeKernel& horizon_kernel_;
  const ComputeKernel& openness_kernel_;
  const Buffer& view_;
  const Buffer& heights_;
  const Buffer& highest_;
  const Buffer& nodes_;
  const Buffer& horizon_;
  const Buffer& openness_;
  const Buffer& begins_;
  const Image& distance_;
  const Image& radiance_;
  const Image& no_image_;
};

}  // namespace nephele
