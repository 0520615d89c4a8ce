// The light that clouds scatter more than once, as a field of place: discrete ordinates on nested lattices.
//
// Around the camera stand windows of flat cells that are kLightLevelRatio times as wide from level to level
// (shared/light_lattice.h). In each the particles' extinction is averaged over the cells; the sun's beam is found by a
// march through it; and light is carried along 20 ordinates from cell to cell, again and again, a fixed number of times
// from the same start. Sun, sky and ground go together, in four channels: sunlight per unit irradiance, red, green and
// blue of what comes from outside. The ground shines by the light that the clouds let through.
//
// Light that is scattered but little from the beam is not carried: with the phase function's second moment as forward
// peak (delta-M scaling, [Wiscombe 1977]) it stays in the beam, and shading adds what the eye sees of it in closed form
// (lut/near_beam.h). The lattice gives the rest, as its spherical harmonics up to degree 2.
//
// A window stands still in the air that drifts with the scene's wind, and steps by kLightWindowStep cells; clouds that
// grow, or drift with another wind, are in it as they are at the nearest whole second. What it holds is a function of
// its place, that second, the sun, the sky and the clouds, so it is kept while these stay the same. The
// finest level's moments are summed for the way to the camera in each frame, a coarser one's when the eye has moved by
// a part of its cells.
//
// A window that the camera is about to fly into, or the next second's, is solved ahead, some units a frame, while the
// one it is in stands; it is the same bit for bit as one that is solved at once.
//
// reads -> writes: particles of each source around each window, air tables -> volume of radiance towards the camera
// cost: windows that are solved (light_solver.h); a frame: one sum of 27 moments a cell with matter (docs/light.md)
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "engine/kernels.h"
#include "engine/result.h"
#include "engine/workshop.h"
#include "passes/kit/air_tables.h"
#include "passes/kit/cloud_source.h"
#include "passes/light/light_solver.h"
#include "shared/light_lattice.h"

namespace nephele {

struct LightGrid {
  std::uint32_t side_cells;    // of a window, a multiple of 16
  std::uint32_t height_cells;  // layers
  double cell_m;               // width of the finest level's cells
  std::uint32_t sweeps;        // along all ordinates, from the start
};

// Whether a device allows the arrays and volumes of such windows; the error names the accepted number of cells.
Result<void> check_light_grid(const Device& device, const LightGrid& grid);

class LightField {
 public:
  // sources must outlive it. reach_m: how far clouds are drawn. wind_m_per_s: of the air in which windows stand still.
  LightField(Workshop& make, const std::vector<std::unique_ptr<CloudSource>>& sources, const LightGrid& grid,
             const CloudExtent& extent, double reach_m, const glm::dvec2& wind_m_per_s);

  // How near to the camera particles are to bring their own depths towards the sun (Occlusion).
  float near_m() const;

  struct Inputs {
    const shared::FrameConstants& constants;
    const Buffer& frame_constants;
    const FrameView& view;        // the camera's
    const AtmosphereTables* air;  // null: none
  };
  struct Outputs {
    const Image* radiance;  // RGBA16F, all levels: radiance towards the camera, depth towards the sun (0: not there)
    const Buffer* lattice;  // LightLattice, from the camera
  };
  // Steps: "light_field", "light_project".
  Outputs add(FrameBuilder& frame, const Inputs& inputs);

  static constexpr std::uint32_t kQueryParts = 8;
  struct Query {
    const Buffer& frame_constants;
    const AtmosphereTables* air;  // null: none
    const Image& near_beam;
    std::uint32_t count;
    const Buffer& places;  // vec3: from the camera of the frame that was added last, in its air; z = altitude
    const Buffer& light;   // LightAt of all places, kQueryParts times: the harmonics are to be added up
  };
  // Light at places, as the frame that was added last and has run left it. Step: "light_query".
  void add_query(FrameBuilder& frame, Kernels& kernels, const Query& query) const;

 private:
  struct Level {
    std::vector<std::unique_ptr<CloudSource>> own_sources;
    std::vector<CloudSource*> sources;
    const Buffer* pairs;                // LightPair
    const Buffer* shown;                // the place of the window whose cells the volume of radiance shows
    const Buffer* from_eye;             // LightLattice from the eye that they are summed for
    std::array<LightCells, 2> windows;  // neighbouring windows in turn
  };
  // Where and when the windows stand: the finest one's steps from the origin of the air, and the time in steps of
  // kTimeStepS, 0 where no cloud moves in that air or grows.
  struct Stand {
    glm::dvec2 steps;
    double time;
  };
  // Where a level's window stands: its centre is so many steps from the origin of the air.
  struct Place {
    glm::dvec2 steps, center_m;
    double time_s;
    std::uint32_t slot;  // of Level::windows
  };
  std::vector<Place> places_at(const Stand& stand) const;  // of all levels
  std::vector<LightWindow> windows_at(const std::vector<Place>& places, const Inputs& inputs) const;
  shared::LightLattice lattice(const Inputs& inputs, const std::vector<Place>& places,
                               const glm::dvec2& reference_m) const;
  void project(FrameBuilder& frame, const Inputs& inputs, const std::vector<Place>& places,
               const std::vector<LightWindow>& windows);
  void solve_ahead(FrameBuilder& frame, const Inputs& inputs, const glm::dvec2& camera_m, const Stand& stand,
                   bool idle);
  double cell_m(std::uint32_t level) const;
  double step_m(std::uint32_t level) const;
  std::uint32_t extinction_plane(std::uint32_t level, std::uint32_t slot) const;

  LightGrid grid_;
  double layer_m_, lowest_m_;
  glm::dvec2 wind_m_per_s_;
  std::optional<glm::dvec2> last_center_m_;  // of the coarsest window where it holds all clouds; else it moves too
  std::vector<Level> levels_;
  std::vector<const LightCells*> shown_;  // of the frame that was added last, by level
  std::unique_ptr<LightSolver> solver_;
  const ComputeKernel &clear_, &project_;
  const Buffer* frame_lattice_ = nullptr;
  const Image *extinction_ = nullptr, *radiance_ = nullptr, *no_air_ = nullptr;
  bool changes_ = false;  // do clouds move in the air of the windows, or grow?
  struct Seen {
    glm::dvec2 camera_m;
    double time_s;
  };
  std::optional<Seen> last_;  // the frame before, which tells what to solve ahead and no more
};

}  // namespace nephele
