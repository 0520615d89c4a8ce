// Solves one window of the light field: from the particles around it to the moments of the light in its cells.
//
// The work comes in units, each of a few milliseconds to a few tens on a CPU, so that a window that is wanted soon can
// be solved ahead over several frames. What units have left is known by what they were made from (StepMemory): another
// window that is solved in between makes them start again, and whoever asks for all units at once gets the same bits.
//
// reads -> writes: particles of the sources, air tables -> the window's cells, extinction, depths and moments
// cost: cells with matter x ordinates x sweeps; some 3 to 5 ns of one core each
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/workshop.h"
#include "passes/kit/air_tables.h"
#include "passes/kit/cloud_source.h"
#include "passes/kit/prefix_sum.h"
#include "shared/light_lattice.h"

namespace nephele {

// A window's own results.
struct LightCells {
  const Buffer* lattice;   // LightLattice, from the window's centre
  const Buffer* count;     // uvec3 groups of an indirect dispatch, listed cells
  const Buffer* listed;    // uint: cells with matter and their neighbours
  const Buffer* index_of;  // uint of every cell (shaders/light/light_line.glsl)
  const Buffer* sigma;     // float of every listed cell: extinction, 1/m
  const Buffer* depths;    // float: optical depth towards the sun
  const Buffer* moments;   // four uvec4 (shaders/light/light_moments.comp)
  const Buffer* boundary;  // vec4 of every ordinate: what comes in along it (shaders/light/light_boundary.comp); then
                           // what would without any cloud
};

struct LightWindow {
  std::uint32_t level;
  FrameView view;                            // from its centre
  const std::vector<CloudSource*>* sources;  // of the level's particles
  const Buffer* pairs;                       // LightPair of the level's cells
  const LightCells* cells;
  shared::LightLattice lattice;  // from its centre; coarser windows, which the beam passes through, are listed
  InputBytes matter;             // what its cells depend on
  InputBytes light;              // what its moments depend on
};

class LightSolver {
 public:
  // particles: room for those around one window. sweeps: along all ordinates, from the start.
  LightSolver(Workshop& make, std::uint32_t side_cells, std::uint32_t height_cells, std::uint32_t particles,
              std::size_t sources, std::uint32_t sweeps);

  // Cells of a window for which a device allows arrays.
  static VkDeviceSize most_cells(const Device& device);

  std::uint32_t unit_count() const { return kUnitsBefore + sweeps_ + 1; }
  // Units that are still to be done.
  std::uint32_t units_left(const FrameBuilder& frame, const LightWindow& window) const;

  // Appends the next units, at most so many. Windows that the beam passes through have their extinction by then.
  // extinction: R16F volume of all windows. air: null: none.
  void add(FrameBuilder& frame, const LightWindow& window, std::uint32_t units, const Image& extinction,
           const Buffer& frame_constants, const AtmosphereTables* air);

 private:
  // Units before the sweeps: particles, cells, surroundings and beam, lines. One more, before the last sweep, makes the
  // lines anew, with cells beside matter.
  static constexpr std::uint32_t kUnitsBefore = 4;
  struct Kernels;
  struct Steps;  // of one window in one frame

  std::uint32_t threads_a_particle() const;
  std::uint32_t openness_groups() const;
  std::uint32_t openness_slices() const;
  std::uint32_t lines_at_most() const { return side_ * (side_ > height_ ? side_ : height_); }  // of a pair

  std::shared_ptr<const Kernels> kernels_;
  std::uint32_t side_, height_, cells_, sweeps_;
  std::size_t source_count_;
  PrefixSum scan_;
  const Buffer *particles_, *counters_, *records_;
  const Buffer *fixed_point_, *places_, *spread_, *lines_, *lengths_, *mean_, *beam_, *openness_, *exits_, *exit_sums_,
      *sources_[2], *floor_, *surroundings_, *directions_, *direction_ranges_;
  const Image* none_;
  std::uint32_t direction_count_ = 0;
};

// The pairs of ordinates on cells of this shape, for LightWindow::pairs.
std::vector<shared::LightPair> light_pairs(std::uint32_t side_cells, std::uint32_t height_cells, double cell_m,
                                           double layer_m);

}  // namespace nephele
