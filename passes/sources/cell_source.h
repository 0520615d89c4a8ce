// The particles of a frame ([Yusov14] 5.2): cloud cells of the ring grid, expanded into particles in render space
// after those that the scene lists; and the list of the ones the camera can see.
//
// reads -> writes: frame constants, weather map -> particles, visible list; in counters all but tile_pair_*,
// screen_pair_* and pairs_shaded cost: cells of all rings (four field evaluations each) and the particles of the
// occupied ones, one evaluation of the base each.
//
// The order is fixed: listed particles, then ring by ring, row by row. What stands in the cells is kept while the
// camera stays in one cell of the finest ring, as it would be found again, bit for bit; nothing else is left of earlier
// frames.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "engine/scene.h"
#include "engine/workshop.h"
#include "passes/kit/prefix_sum.h"
#include "shared/types.h"
#include "shared/weather.h"

namespace nephele {

class CloudParticles {
 public:
  struct Outputs {
    const Buffer& particles;  // Particle; slots [0, particle_count) are filled
    const Buffer& visible;    // uint: indices of particles, ascending
    const Buffer& counters;   // FrameCounters
  };
  // The grid behind the particles, for whoever looks for neighbours: cells as numbered by shared/ring_grid.h.
  // Particles of cell c are [listed + cell_first[c], listed + cell_first[c + 1]).
  struct Grid {
    const Buffer& cell_first;     // uint, one more than cells
    const Buffer& particle_cell;  // uint per particle; undefined for listed ones
  };

  // map: the scene's weather map, if it has one.
  // constants: those of any frame of the scene; seed, origin, camera and time may change later, the rest of the cloud
  // field may not. capacity 0 means capacity_for(); past it the farthest cells are left out, their particles counted.
  CloudParticles(Workshop& make, const shared::FrameConstants& constants, std::span<const ListedParticle> listed,
                 std::uint32_t capacity = 0, const WeatherMap* map = nullptr);

  // Room for the particles of these settings: over the cells of all rings, the share that may be covered times what a
  // covered cell holds, with a seventh to spare; at most what the device's storage buffers take.
  static std::uint32_t capacity_for(const Device& device, const shared::FrameConstants& constants);

  // buffer holds `constants` when the steps run. weather: of the map, if there is one. Steps: "grid_cells",
  // "particles", "visibility".
  Outputs add(FrameBuilder& frame, const shared::FrameConstants& constants, const Buffer& buffer,
              const glm::dvec3& camera_world_m, const shared::WeatherPlacement& weather = {});

  std::uint32_t capacity() const { return capacity_; }
  Grid grid() const { return {cell_first_, particle_cell_}; }

 private:
  void add_cells(FrameBuilder& frame, const Buffer& buffer, const PushConstants& push);
  void add_grid(FrameBuilder& frame, const shared::FrameConstants& constants, const Buffer& buffer,
                const shared::WeatherPlacement& weather);
  void add_listed(FrameBuilder& frame, const glm::dvec3& camera_world_m);
  void add_visible(FrameBuilder& frame, const Buffer& buffer);

  ComputeKernel features_kernel_, near_, list_, cells_, show_, fit_, thin_, expand_, particles_kernel_, listed_kernel_,
      visibility_, visible_list_;
  glm::ivec2 map_size_;  // texels; 0: no map
  float most_coverage_;  // anywhere
  std::uint32_t listed_count_, capacity_, cell_count_, feature_count_, near_count_;
  PrefixSum scan_;
  Buffer weather_map_, features_, features_near_, cell_list_, cell_clouds_, cell_counts_, cell_first_, distance_counts_,
      particle_cell_, listed_, particles_, places_, visible_, counters_;
};

}  // namespace nephele
