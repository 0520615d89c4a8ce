#include "passes/light/light_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "nephele_shaders.h"
#include "shared/phase.h"

namespace nephele {

using shared::kLightWindowStep;
using shared::LightLattice;

namespace {

constexpr std::uint32_t kLocalSize = 64;
constexpr double kLeastLayerM = 25.0;
constexpr double kFinestShare = 0.5;        // of the cells' width, where fewer would hold all clouds
constexpr std::uint32_t kBorderCells = 4;   // around clouds that one window holds
constexpr double kEyeStepsACell = 16.0;     // of the eye that a coarser level is summed for
constexpr std::uint32_t kBorderLayers = 2;  // without matter: look-ups between cells need neighbours
constexpr double kTimeStepS = 1.0;          // of windows whose clouds change
constexpr double kAheadAtLeastM = 1e-3;     // a frame's way along an axis below which none is expected
constexpr double kFramesInHand = 3.0;       // by which a window is to be ready before the camera is there

// To whole numbers; never -0, whose bytes are not 0's.
glm::dvec2 rounded(const glm::dvec2& v) { return glm::round(v) + 0.0; }

// Under all clouds together, if all stand still in the air of that wind.
std::optional<CloudBounds> common_bounds(const std::vector<std::unique_ptr<CloudSource>>& sources,
                                         const glm::dvec2& wind_m_per_s) {
  CloudBounds all{glm::dvec2(INFINITY), glm::dvec2(-INFINITY), wind_m_per_s};
  for (const auto& source : sources) {
    const std::optional<CloudBounds> own = source->bounds();
    if (!own || own->drift_m_per_s != wind_m_per_s) return std::nullopt;
    all.low_m = glm::min(all.low_m, own->low_m);
    all.high_m = glm::max(all.high_m, own->high_m);
  }
  if (sources.empty()) return std::nullopt;
  return all;
}

}  // namespace

Result<void> check_light_grid(const Device& device, const LightGrid& grid) {
  const std::uint64_t cells = std::uint64_t{grid.side_cells} * grid.side_cells * grid.height_cells;
  const std::uint64_t most = LightSolver::most_cells(device);
  if (cells > most)
    return Error{concat("the light field's windows have ", grid.side_cells, "x", grid.side_cells, "x",
                        grid.height_cells, " = ", cells, " cells; ", device.info().name, " allows up to ", most,
                        " (--light-side-cells, --light-height-cells)")};
  const std::uint32_t planes = 2 * shared::kMaxLightLevels * (grid.height_cells + 1) + 1;
  if (planes > device.info().max_volume_side_px)
    return Error{concat("the light field's windows have ", grid.height_cells, " layers; ", device.info().name,
                        " allows up to ", (device.info().max_volume_side_px - 1) / (2 * shared::kMaxLightLevels) - 1,
                        " (--light-height-cells)")};
  return {};
}

double LightField::cell_m(std::uint32_t level) const {
  return grid_.cell_m * std::pow(shared::kLightLevelRatio, level);
}
double LightField::step_m(std::uint32_t level) const { return kLightWindowStep * cell_m(level); }

std::uint32_t LightField::extinction_plane(std::uint32_t level, std::uint32_t slot) const {
  return (2 * level + slot) * (grid_.height_cells + 1) + 1;
}

float LightField::near_m() const { return static_cast<float>(2.0 * shared::kNearCameraCells * cell_m(0)); }

LightField::LightField(Workshop& make, const std::vector<std::unique_ptr<CloudSource>>& sources, const LightGrid& grid,
                       const CloudExtent& extent, double reach_m, const glm::dvec2& wind_m_per_s)
    : grid_(grid),
      layer_m_(std::max(kLeastLayerM, std::ceil((double{extent.highest_m} - double{extent.lowest_m}) /
                                                (grid.height_cells - kBorderLayers)))),
      lowest_m_(std::floor(double{extent.lowest_m} / kLeastLayerM) * kLeastLayerM - layer_m_),
      wind_m_per_s_(wind_m_per_s),
      clear_(make.compute(shaders::light_clear_comp)),
      project_(make.compute(shaders::light_project_comp)) {
  const std::uint32_t side = grid.side_cells, height = grid.height_cells;
  NEPHELE_CHECK(side % 16 == 0 && side > 0 && height > 0, "windows of ", side, "x", side, "x", height, " cells");
  std::uint32_t level_count = 1;
  if (const std::optional<CloudBounds> bounds = common_bounds(sources, wind_m_per_s)) {
    const glm::dvec2 extent_m = bounds->high_m - bounds->low_m;
    const double across_m = std::max(extent_m.x, extent_m.y);
    grid_.cell_m = std::clamp(across_m / (side - kBorderCells), kFinestShare * grid.cell_m, grid.cell_m);
    while (level_count < shared::kMaxLightLevels && (side - kBorderCells) * cell_m(level_count - 1) < across_m)
      ++level_count;
    last_center_m_ = 0.5 * (bounds->low_m + bounds->high_m);
  } else {
    while (level_count < shared::kMaxLightLevels && (side / 2 - kLightWindowStep) * cell_m(level_count - 1) < reach_m)
      ++level_count;
  }

  const VkDeviceSize cells = shared::light_cell_count(side, height);
  std::uint32_t most_particles = 0;
  for (std::uint32_t k = 0; k < level_count; ++k) {
    Level level;
    const std::string own = "light_" + std::to_string(k) + '_';
    std::uint32_t particles = 0;
    for (const auto& source : sources) {
      auto even = source->evenly(make, own + source->name(), 0.71 * side * cell_m(k), cell_m(k));
      level.sources.push_back(even ? even.get() : source.get());
      if (even) level.own_sources.push_back(std::move(even));
      particles += level.sources.back()->capacity();
    }
    most_particles = std::max(most_particles, particles);
    const std::vector<shared::LightPair> pairs = light_pairs(side, height, cell_m(k), layer_m_);
    level.pairs = &make.uploaded(own + "pairs", std::as_bytes(std::span(pairs)));
    level.shown = &make.buffer(own + "shown", sizeof(glm::vec2));
    level.from_eye = &make.buffer(own + "from_eye", sizeof(LightLattice));
    for (std::size_t slot = 0; slot < level.windows.size(); ++slot) {
      const std::string name = own + std::to_string(slot) + '_';
      level.windows[slot] = {&make.buffer(name + "lattice", sizeof(LightLattice)),
                             &make.buffer(name + "count", 4 * sizeof(std::uint32_t)),
                             &make.buffer(name + "listed", cells * sizeof(std::uint32_t)),
                             &make.buffer(name + "index", cells * sizeof(std::uint32_t)),
                             &make.buffer(name + "sigma", cells * sizeof(float)),
                             &make.buffer(name + "depths", cells * sizeof(float)),
                             &make.buffer(name + "moments", cells * 4 * sizeof(glm::uvec4)),
                             &make.buffer(name + "boundary", 2 * shared::kLightOrdinates * sizeof(glm::vec4))};
    }
    levels_.push_back(std::move(level));
  }
  for (const auto& source : sources)
    changes_ = changes_ || source->inputs({glm::dvec3(0.0), 0.0, wind_m_per_s}) !=
                               source->inputs({glm::dvec3(0.0), 1000.0 / 7.0, wind_m_per_s});
  solver_ = std::make_unique<LightSolver>(make, side, height, most_particles, sources.size(), grid.sweeps);
  frame_lattice_ = &make.buffer("light_lattice", sizeof(LightLattice));
  no_air_ = &make.image("light_query_no_air", {});
  extinction_ = &make.image("light_extinction", {VK_FORMAT_R16_SFLOAT, side, side, 2 * level_count * (height + 1) + 1});
  radiance_ =
      &make.image("light_radiance", {VK_FORMAT_R16G16B16A16_SFLOAT, side, side, level_count * (height + 1) + 1});
}

// A coarser window's centre follows from the finer one's, so what a window holds depends on its own place alone. The
// coarsest one, whose clouds end with the view, stays nearer to the camera: it steps with the one before.
std::vector<LightField::Place> LightField::places_at(const Stand& stand) const {
  std::vector<Place> places;
  const double time_s = stand.time * kTimeStepS;
  const auto slot_of = [&](const glm::dvec2& own) {  // another one than its neighbours' in place and time
    return static_cast<std::uint32_t>(std::fmod(std::abs(own.x + own.y + stand.time), 2.0));
  };
  glm::dvec2 own = stand.steps;
  for (std::uint32_t k = 0; k < levels_.size(); ++k) {
    const bool coarsest = k > 0 && k + 1 == levels_.size();
    if (k > 0 && !coarsest) own = rounded(own / double{shared::kLightLevelRatio});
    if (last_center_m_ && k + 1 == levels_.size())
      places.push_back({glm::dvec2(0.0), *last_center_m_, time_s, slot_of(glm::dvec2(0.0))});
    else
      places.push_back({own, own * step_m(coarsest ? k - 1 : k), time_s, slot_of(own)});
  }
  return places;
}

std::vector<LightWindow> LightField::windows_at(const std::vector<Place>& places, const Inputs& inputs) const {
  const shared::FrameConstants& c = inputs.constants;
  InputBytes light = as_inputs(c.sun_direction, c.sun_irradiance, c.ground_albedo, c.atmosphere_enabled,
                               c.ground_enabled, c.phase_g, c.phase_function, grid_.sweeps);
  std::vector<LightWindow> windows(levels_.size());
  for (auto k = static_cast<std::uint32_t>(levels_.size()); k-- > 0;) {
    LightWindow& window = windows[k];
    window.level = k;
    window.view = {glm::dvec3(places[k].center_m, 0.0), places[k].time_s, wind_m_per_s_};
    window.sources = &levels_[k].sources;
    window.pairs = levels_[k].pairs;
    window.cells = &levels_[k].windows[places[k].slot];
    window.lattice = lattice(inputs, places, places[k].center_m);
    const glm::dvec3 cells_per_m = glm::abs(glm::dvec3(c.sun_direction)) / glm::dvec3(cell_m(k), cell_m(k), layer_m_);
    window.lattice.beam_way_m = static_cast<float>(1.0 / std::max({cells_per_m.x, cells_per_m.y, cells_per_m.z}));
    window.matter =
        as_inputs(k, grid_.side_cells, grid_.height_cells, grid_.cell_m, lowest_m_, layer_m_, places[k].center_m);
    for (const CloudSource* source : levels_[k].sources) {
      const InputBytes own = source->inputs(window.view);
      window.matter.insert(window.matter.end(), own.begin(), own.end());
    }
    // The beam passes through coarser windows.
    light.insert(light.end(), window.matter.begin(), window.matter.end());
    window.light = light;
  }
  return windows;
}

LightLattice LightField::lattice(const Inputs& inputs, const std::vector<Place>& places,
                                 const glm::dvec2& reference_m) const {
  LightLattice lattice{};
  for (std::uint32_t k = 0; k < levels_.size(); ++k) {
    const double half_m = 0.5 * grid_.side_cells * cell_m(k);
    shared::LightLevel& level = lattice.levels[k];
    level.corner_m = places[k].center_m - half_m - reference_m;
    level.cell_m = static_cast<float>(cell_m(k));
    // Half a step less, as the camera may be so far from the centre, and as much again for particles that reach out.
    level.reach_m = k + 1 < levels_.size() ? static_cast<float>(half_m - step_m(k)) : 1e30f;
    level.extinction_plane = extinction_plane(k, places[k].slot);
    level.radiance_plane = k * (grid_.height_cells + 1) + 1;
  }
  lattice.level_count = static_cast<std::uint32_t>(levels_.size());
  lattice.side = grid_.side_cells;
  lattice.height = grid_.height_cells;
  lattice.lowest_m = static_cast<float>(lowest_m_);
  lattice.layer_m = static_cast<float>(layer_m_);
  lattice.sun_direction = inputs.constants.sun_direction;
  const auto moment = [&](int l) {
    return shared::phase_moment(inputs.constants.phase_function, l, inputs.constants.phase_g);
  };
  lattice.moment1 = moment(1);
  lattice.moment2 = moment(2);
  lattice.forward = lattice.moment2;
  lattice.scaled_asymmetry = (lattice.moment1 - lattice.forward) / (1.0f - lattice.forward);
  return lattice;
}

// Sums up each level's moments for the way to the camera; for the coarser levels it moves by parts of a cell, so that
// not every frame has them all to do.
void LightField::project(FrameBuilder& frame, const Inputs& inputs, const std::vector<Place>& places,
                         const std::vector<LightWindow>& windows) {
  constexpr const char* kRow = "light_project";
  const glm::dvec3 camera_m = inputs.view.in_air(wind_m_per_s_);
  InputBytes depends;
  for (auto k = static_cast<std::uint32_t>(levels_.size()); k-- > 0;) {
    const double step_m = cell_m(k) / kEyeStepsACell;
    const glm::dvec3 eye_m = k == 0 ? camera_m : glm::round(camera_m / step_m) * step_m + 0.0;
    const InputBytes own = as_inputs(eye_m);
    depends.insert(depends.end(), own.begin(), own.end());
    depends.insert(depends.end(), windows[k].light.begin(), windows[k].light.end());
    const Level& level = levels_[k];
    const LightCells& cells = *windows[k].cells;
    const bool same_cells = frame.stands(level.shown, windows[k].matter);
    if (frame.stands(level.from_eye, depends)) continue;
    frame.update(kRow, *level.from_eye, as_push(lattice(inputs, places, glm::dvec2(eye_m))));
    if (!same_cells) {
      frame.update(kRow, *level.shown, as_push(glm::vec2(places[k].steps)));
      frame.compute({.name = kRow,
                     .kernel = &clear_,
                     .bindings = {{0, *level.from_eye, Access::storage_read}, {1, *radiance_, Access::storage_write}},
                     .push = as_push(k),
                     .groups = {grid_.side_cells / 8, grid_.side_cells / 8, 1}});
    }
    struct Push {
      std::uint32_t level;
      float eye_altitude_m;
    };
    frame.compute({.name = kRow,
                   .kernel = &project_,
                   .bindings = {{0, *level.from_eye, Access::storage_read},
                                {1, *cells.count, Access::storage_read},
                                {2, *cells.listed, Access::words},
                                {3, *cells.moments, Access::texels},
                                {5, *radiance_, Access::sampled},
                                {6, *radiance_, Access::storage_write},
                                {7, *cells.depths, Access::words}},
                   .push = as_push(Push{k, static_cast<float>(eye_m.z)}),
                   .indirect = {cells.count, 0}});
  }
}

// Some units of the windows that the camera, or the next second, is about to enter, if this frame had none of its own
// to do. Nothing of it shows in this frame.
void LightField::solve_ahead(FrameBuilder& frame, const Inputs& inputs, const glm::dvec2& camera_m, const Stand& stand,
                             bool idle) {
  const std::optional<Seen> before = last_;
  last_ = Seen{camera_m, inputs.view.time_s};
  if (!before || !idle || frame.reuse() != Reuse::all) return;
  const glm::dvec2 way_m = camera_m - before->camera_m;
  const double passed_s = inputs.view.time_s - before->time_s;
  if (glm::length(way_m) > step_m(0)) return;
  double frames = std::numeric_limits<double>::infinity();  // to the next border
  Stand next = stand;
  for (int axis = 0; axis < 2; ++axis) {
    if (std::abs(way_m[axis]) < kAheadAtLeastM) continue;
    const double sign = way_m[axis] > 0.0 ? 1.0 : -1.0;
    const double to_border = ((stand.steps[axis] + 0.5 * sign) * step_m(0) - camera_m[axis]) / way_m[axis];
    if (to_border >= frames) continue;
    frames = to_border;
    next = stand;
    next.steps[axis] += sign;
  }
  if (changes_ && std::abs(passed_s) > 0.0 && std::abs(passed_s) < kTimeStepS) {
    const double sign = passed_s > 0.0 ? 1.0 : -1.0;
    const double to_border = ((stand.time + 0.5 * sign) * kTimeStepS - inputs.view.time_s) / passed_s;
    if (to_border < frames) {
      frames = to_border;
      next = {stand.steps, stand.time + sign};
    }
  }
  if (frames == std::numeric_limits<double>::infinity()) return;
  const std::vector<LightWindow> windows = windows_at(places_at(next), inputs);
  std::uint32_t left = 0;
  for (const LightWindow& window : windows) left += solver_->units_left(frame, window);
  auto units = static_cast<std::uint32_t>(std::ceil(left / std::max(frames - kFramesInHand, 1.0)));
  for (std::size_t k = windows.size(); k-- > 0 && units > 0;) {
    const std::uint32_t of_window = std::min(units, solver_->units_left(frame, windows[k]));
    solver_->add(frame, windows[k], of_window, *extinction_, inputs.frame_constants, inputs.air);
    units -= of_window;
  }
}

LightField::Outputs LightField::add(FrameBuilder& frame, const Inputs& inputs) {
  const glm::dvec2 camera_m(inputs.view.in_air(wind_m_per_s_));
  const Stand stand{rounded(camera_m / step_m(0)), changes_ ? std::round(inputs.view.time_s / kTimeStepS) + 0.0 : 0.0};
  const std::vector<Place> places = places_at(stand);
  const std::vector<LightWindow> windows = windows_at(places, inputs);
  const auto level_count = static_cast<std::uint32_t>(levels_.size());
  std::uint32_t units = 0;
  for (std::uint32_t k = level_count; k-- > 0;) {
    units += solver_->units_left(frame, windows[k]);
    solver_->add(frame, windows[k], solver_->unit_count(), *extinction_, inputs.frame_constants, inputs.air);
  }

  shown_.clear();
  for (const LightWindow& window : windows) shown_.push_back(window.cells);
  project(frame, inputs, places, windows);
  frame.update("light_project", *frame_lattice_, as_push(lattice(inputs, places, camera_m)));
  solve_ahead(frame, inputs, camera_m, stand, units == 0);
  return {radiance_, frame_lattice_};
}

void LightField::add_query(FrameBuilder& frame, Kernels& kernels, const Query& query) const {
  const SpecConstant constants[] = {{0, query.air != nullptr}};
  const ComputeKernel& kernel = kernels.compute(shaders::light_query_comp, constants);
  for (std::uint32_t k = 0; k < shown_.size(); ++k)
    frame.compute({.name = "light_query",
                   .kernel = &kernel,
                   .bindings = {{0, *frame_lattice_, Access::storage_read},
                                {1, *levels_[k].pairs, Access::storage_read},
                                {2, query.places, Access::storage_read},
                                {3, query.light, Access::storage_write},
                                {4, *shown_[k]->index_of, Access::words},
                                {5, *shown_[k]->moments, Access::texels},
                                {6, *shown_[k]->depths, Access::words},
                                {7, *shown_[k]->boundary, Access::storage_read},
                                {8, query.frame_constants, Access::uniform},
                                {9, *extinction_, Access::sampled},
                                {10, query.near_beam, Access::sampled},
                                {11, query.air ? query.air->transmittance : *no_air_, Access::sampled}},
                   .push = as_push(glm::uvec2(k, query.count)),
                   .groups = {(query.count + 63) / 64, kQueryParts, 1}});
}

}  // namespace nephele
