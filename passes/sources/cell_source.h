// A procedural cloud field as particles ([Yusov14] 5.2): cells of a ring grid around the camera, found once and
// expanded every frame.
//
// reads -> writes: the field's constants, weather map -> particles, the source's record; particle_* of the counters
// cost: cells of all rings (four field evaluations each) and the particles of the occupied ones, one evaluation of the
// base each.
//
// The order of particles is fixed: ring by ring, row by row. What stands in the cells is kept while CloudField stays
// the same, byte for byte: as long as the camera is in one cell of the finest ring and nothing grows. Past the capacity
// the farthest cells are left out and their particles counted.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "passes/kit/cloud_source.h"
#include "passes/kit/prefix_sum.h"
#include "shared/field_constants.h"

namespace nephele {

// How finely a field is resolved.
struct FieldGrid {
  std::uint32_t ring_size_cells;  // along a ring's side, a multiple of 8
  std::uint32_t layer_count;      // particles stacked in a cell, base included
  float crown_per_cell;           // CloudField
};

class CellSource final : public CloudSource {
 public:
  // Cells as numbered by shared/ring_grid.h. Particles of cell c are the field's particles
  // [cell_first[c], cell_first[c + 1]).
  struct Grid {
    const Buffer& cell_first;     // uint, one more than cells
    const Buffer& particle_cell;  // uint per particle of the field
    const Buffer& counters;       // FieldCounters
  };

  CellSource(Workshop& make, std::string name, const CloudSettings& clouds, const FieldGrid& grid,
             const glm::dvec2& world_origin_m, std::uint32_t most);

  // For a field that is given whole: all of it may change from frame to frame but rings, cells and view distance.
  // capacity 0: capacity_for().
  CellSource(Workshop& make, std::string name, const shared::CloudField& field, const WeatherMap* map = nullptr,
             std::uint32_t capacity = 0);

  // Room for the particles of a field of this coverage: over the cells of all rings, the share that may be covered
  // times what a covered cell holds, with a seventh to spare.
  static std::uint32_t capacity_for(const shared::CloudField& field, float most_coverage);

  CloudExtent extent() const override;
  float extinction_per_m() const override { return field_.extinction_per_m; }
  InputBytes inputs(const FrameView& view) const override;
  void add(FrameBuilder& frame, const FrameView& view, const ParticleSink& sink) override;
  std::unique_ptr<CloudSource> evenly(Workshop& make, const std::string& name, double reach_m,
                                      double cell_m) const override;
  // The same of a field that is given whole.
  void add_field(FrameBuilder& frame, const shared::FieldFrame& field, const ParticleSink& sink);

  Grid grid() const { return {cell_first_, particle_cell_, counters_}; }

 private:
  struct Motion {
    glm::dvec2 world_origin_m{0.0}, wind_m_per_s{0.0};
    double growth_period_s = 0.0;
    glm::dvec2 map_origin_m{0.0}, map_extent_m{0.0};
  };
  CellSource(Workshop& make, std::string name, const shared::CloudField& field, const Buffer& weather_map,
             float most_coverage, std::uint32_t capacity, const Motion& motion);
  shared::FieldFrame field_frame(const FrameView& view) const;
  void add_cells(FrameBuilder& frame, const ParticleSink& sink);

  const ComputeKernel& features_kernel_;
  const ComputeKernel& near_;
  const ComputeKernel& list_cells_;
  const ComputeKernel& cells_;
  const ComputeKernel& count_cell_particles_;
  const ComputeKernel& fit_capacity_;
  const ComputeKernel& drop_far_cells_;
  const ComputeKernel& assign_slots_;
  const ComputeKernel& particles_kernel_;
  shared::CloudField field_;  // what stays the same from frame to frame; the rest 0
  Motion motion_;
  float most_coverage_;  // anywhere
  std::uint32_t cell_count_, feature_count_, near_count_;
  PrefixSum scan_;
  const Buffer& constants_;
  const Buffer& counters_;
  const Buffer& weather_map_;
  const Buffer& features_;
  const Buffer& features_near_;
  const Buffer& cell_list_;
  const Buffer& cell_clouds_;
  const Buffer& cell_counts_;
  const Buffer& cell_first_;
  const Buffer& distance_counts_;
  const Buffer& particle_cell_;
};

}  // namespace nephele
