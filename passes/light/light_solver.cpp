#include "passes/light/light_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "nephele_shaders.h"

namespace nephele {

using shared::FrameCounters;
using shared::LightLattice;
using shared::LightPair;

namespace {

constexpr std::uint32_t kLocalSize = 64;
constexpr std::uint32_t kFloorPlaces = 32;  // along a side: where the beam through the floor is looked up
constexpr std::uint32_t kOpennessRings = 24, kLayersASlice = 32;  // light_openness.glsl, light_openness.comp
constexpr const char* kRow = "light_field";
constexpr double kSpread = 0.96;  // of the sweeps' weights: the spectral radius they are made for

std::uint32_t groups_for(std::uint32_t threads) { return (threads + kLocalSize - 1) / kLocalSize; }

// Upward ordinates: half of the vertices of a dodecahedron with its pole up, turned so that none lies along an axis.
std::array<glm::dvec3, shared::kLightPairs> upward_ordinates() {
  const double root5 = std::sqrt(5.0), turn = 0.17;
  std::array<glm::dvec3, shared::kLightPairs> result;
  for (std::size_t i = 0; i < 10; ++i) {
    const double z = std::sqrt((5.0 + (i < 5 ? 2.0 : -2.0) * root5) / 15.0), across = std::sqrt(1.0 - z * z);
    const double azimuth = 2.0 * std::numbers::pi * (static_cast<double>(i % 5) + 0.5) / 5.0 + turn;
    result[i] = {across * std::cos(azimuth), across * std::sin(azimuth), z};
  }
  return result;
}

// Directions all over the sphere, ordered by the ordinate whose light comes from there; and where each begins.
struct Surroundings {
  std::vector<glm::vec3> directions;
  std::array<std::uint32_t, shared::kLightOrdinates + 1> first_of;
};
Surroundings surroundings() {
  constexpr int kDirections = 1600;
  const auto upward = upward_ordinates();
  std::array<std::vector<glm::vec3>, shared::kLightOrdinates> of;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections, r = std::sqrt(1.0 - z * z), a = 2.39996322972865332 * i;
    const glm::dvec3 direction(r * std::cos(a), r * std::sin(a), z);
    std::size_t best = 0;
    double nearest = -2.0;
    for (std::size_t k = 0; k < shared::kLightOrdinates; ++k) {
      const double cosine = glm::dot(k % 2 == 0 ? -upward[k / 2] : upward[k / 2], direction);
      if (cosine > nearest) {
        nearest = cosine;
        best = k;
      }
    }
    of[best].push_back(direction);
  }
  Surroundings result;
  for (std::size_t k = 0; k < of.size(); ++k) {
    result.first_of[k] = static_cast<std::uint32_t>(result.directions.size());
    result.directions.insert(result.directions.end(), of[k].begin(), of[k].end());
  }
  result.first_of.back() = static_cast<std::uint32_t>(result.directions.size());
  return result;
}

// Chebyshev's semi-iterative method for eigenvalues of a sweep within 0 to kSpread [Golub and Varga 1961]: with x the
// source before a sweep, s what the sweep makes of it and y the source before x, the next one is
// `again` (`step` (s - x) + x - y) + y. Unlike one cycle of weights it is stable for any number of sweeps.
struct SweepWeights {
  float step, again;  // again 1: there is no y
};
SweepWeights sweep_weights(std::uint32_t sweep) {
  const double radius = kSpread / (2.0 - kSpread);
  double again = 1.0;
  for (std::uint32_t k = 1; k <= sweep; ++k) again = 1.0 / (1.0 - (k == 1 ? 0.5 : 0.25) * radius * radius * again);
  return {static_cast<float>(2.0 / (2.0 - kSpread)), static_cast<float>(again)};
}

// What a unit has left: the inputs of its window, and its number.
InputBytes after_unit(const InputBytes& inputs, std::uint32_t unit) {
  InputBytes bytes = inputs;
  const InputBytes number = as_inputs(unit);
  bytes.insert(bytes.end(), number.begin(), number.end());
  return bytes;
}

}  // namespace

std::vector<LightPair> light_pairs(std::uint32_t side_cells, std::uint32_t height_cells, double cell_m,
                                   double layer_m) {
  const glm::dvec3 size_m(cell_m, cell_m, layer_m);
  const glm::ivec3 cells(static_cast<int>(side_cells), static_cast<int>(side_cells), static_cast<int>(height_cells));
  const glm::ivec3 strides(1, cells.x, cells.x * cells.y);
  std::vector<LightPair> pairs;
  for (const glm::dvec3& direction : upward_ordinates()) {
    const glm::dvec3 per_m = direction / size_m;
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(per_m[k]) > std::abs(per_m[axis])) axis = k;
    const int b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
    LightPair pair{};
    pair.direction = direction;
    pair.length_m = static_cast<float>(1.0 / std::abs(per_m[axis]));
    pair.count = {cells[axis], cells[b], cells[c]};
    pair.stride = {strides[axis], strides[b], strides[c]};
    pair.slope = {static_cast<int>(std::lround(65536.0 * per_m[b] / std::abs(per_m[axis]))),
                  static_cast<int>(std::lround(65536.0 * per_m[c] / std::abs(per_m[axis])))};
    pair.reversed = per_m[axis] < 0.0;
    pair.axis = static_cast<std::uint32_t>(axis);
    pairs.push_back(pair);
  }
  return pairs;
}

struct LightSolver::Kernels {
  explicit Kernels(Workshop& make)
      : splat(make.compute(shaders::light_splat_comp)),
        occupied(make.compute(shaders::light_occupied_comp)),
        list(make.compute(shaders::light_list_comp)),
        depth(make.compute(shaders::light_depth_comp)),
        floor(make.compute(shaders::light_floor_comp)),
        openness(make.compute(shaders::light_openness_comp)),
        lines(make.compute(shaders::light_lines_comp)),
        begin(make.compute(shaders::light_begin_comp)),
        sweep(make.compute(shaders::light_sweep_comp)),
        sum(make.compute(shaders::light_sum_comp)),
        exits(make.compute(shaders::light_exits_comp)) {
    for (const bool air : {false, true}) {
      const SpecConstant constants[] = {{0, air}};
      surroundings[air] = &make.compute(shaders::light_surroundings_comp, constants);
      boundary[air] = &make.compute(shaders::light_boundary_comp, constants);
      moments[air] = &make.compute(shaders::light_moments_comp, constants);
    }
  }
  const ComputeKernel *surroundings[2], *boundary[2], *moments[2];  // without and with air
  const ComputeKernel &splat, &occupied, &list, &depth, &floor, &openness, &lines, &begin, &sweep, &sum, &exits;
};

LightSolver::LightSolver(Workshop& make, std::uint32_t side_cells, std::uint32_t height_cells, std::uint32_t particles,
                         std::size_t sources, std::uint32_t sweeps)
    : kernels_(std::make_shared<Kernels>(make)),
      side_(side_cells),
      height_(height_cells),
      cells_(shared::light_cell_count(side_cells, height_cells)),
      sweeps_(sweeps),
      source_count_(std::max<std::size_t>(sources, 1)),
      scan_(make, "light_cells", cells_) {
  NEPHELE_CHECK(sweeps > 0, "no sweeps");
  const auto cell_buffer = [&](const std::string& name, VkDeviceSize bytes_each) -> const Buffer* {
    return &make.buffer("light_" + name, cells_ * bytes_each);
  };
  particles_ = &make.buffer("light_particles", VkDeviceSize{std::max(particles, 1u)} * sizeof(shared::Particle));
  counters_ = &make.buffer("light_counters", sizeof(FrameCounters));
  records_ = &make.buffer("light_records", source_count_ * sizeof(shared::SourceRecord));
  fixed_point_ = cell_buffer("fixed_point", sizeof(std::uint32_t));
  places_ = cell_buffer("places", sizeof(std::uint32_t));
  spread_ = cell_buffer("spread", sizeof(std::uint32_t));
  lines_ = cell_buffer("lines", shared::kLightPairs * sizeof(std::uint32_t));
  mean_ = cell_buffer("mean", shared::kLightOrdinates * sizeof(glm::uvec2));
  beam_ = cell_buffer("beam", sizeof(float));
  sources_[0] = cell_buffer("source_0", 2 * sizeof(glm::uvec4));
  sources_[1] = cell_buffer("source_1", 2 * sizeof(glm::uvec4));
  const VkDeviceSize lines = VkDeviceSize{shared::kLightPairs} * lines_at_most();
  lengths_ = &make.buffer("light_lengths", lines * sizeof(std::uint32_t));
  exits_ = &make.buffer("light_exits", lines * sizeof(glm::vec4));
  exit_sums_ = &make.buffer("light_exit_sums", 64 * (shared::kLightPairs + 2) * sizeof(glm::vec4));
  floor_ = &make.buffer("light_floor", VkDeviceSize{kFloorPlaces} * kFloorPlaces * sizeof(float));
  openness_ = &make.buffer("light_openness",
                           VkDeviceSize{kOpennessRings} * openness_groups() * openness_slices() * sizeof(glm::vec2));
  const Surroundings around = surroundings();
  direction_count_ = static_cast<std::uint32_t>(around.directions.size());
  directions_ = &make.uploaded("light_directions", std::as_bytes(std::span(around.directions)));
  direction_ranges_ = &make.uploaded("light_direction_ranges", std::as_bytes(std::span(around.first_of)));
  surroundings_ = &make.buffer("light_surroundings", VkDeviceSize{direction_count_} * 7 * sizeof(float));
  none_ = &make.image("light_no_air", {});
}

VkDeviceSize LightSolver::most_cells(const Device& device) {
  return device.max_elements(sizeof(std::uint32_t)) / (shared::kLightOrdinates * 2);  // mean_, as words
}

// The steps of a window's units.
struct LightSolver::Steps {
  FrameBuilder& frame;
  LightSolver& solver;
  const LightWindow& window;
  const Image& extinction;
  const Buffer& frame_constants;
  const AtmosphereTables* air;

  const Kernels& kernels = *solver.kernels_;
  const LightCells& cells = *window.cells;
  const Indirect each_cell{cells.count, 0};

  void add(std::uint32_t unit) {
    if (unit == 0)
      particles();
    else if (unit == 1)
      list_cells();
    else if (unit == 2)
      surround();
    else if (unit == 3)
      begin();
    else if (unit + 2 == solver.unit_count())
      lines(true);
    else
      sweep(std::min(unit - kUnitsBefore, solver.sweeps_ - 1));
  }

  void particles() {
    FrameCounters start{};
    start.particle_groups = {0, solver.threads_a_particle(), 1};
    frame.update(kRow, *solver.counters_, as_push(start));
    const std::vector<shared::SourceRecord> records(solver.source_count_);
    const auto bytes = std::as_bytes(std::span(records));
    frame.update(kRow, *solver.records_, {bytes.begin(), bytes.end()});
    std::uint32_t index = 0;
    for (CloudSource* source : *window.sources)
      source->add(frame, window.view, {*solver.particles_, *solver.counters_, *solver.records_, index++, kRow});
  }

  void list_cells() {
    const std::uint32_t groups = groups_for(solver.cells_);
    frame.fill(kRow, *solver.fixed_point_, 0);
    frame.compute({.name = kRow,
                   .kernel = &kernels.splat,
                   .bindings = {{0, *cells.lattice, Access::storage_read},
                                {1, *solver.particles_, Access::texels},
                                {2, *solver.counters_, Access::storage_read},
                                {3, *solver.fixed_point_, Access::storage_read_write}},
                   .push = as_push(glm::uvec2(window.level, solver.threads_a_particle())),
                   .indirect = {solver.counters_, offsetof(FrameCounters, particle_groups)}});
    const Buffer* spread[] = {solver.fixed_point_, solver.places_, solver.spread_, solver.places_};
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      frame.compute({.name = kRow,
                     .kernel = &kernels.occupied,
                     .bindings = {{0, *cells.lattice, Access::storage_read},
                                  {1, *spread[axis], Access::words},
                                  {2, *spread[axis + 1], Access::storage_write}},
                     .push = as_push(axis),
                     .groups = {groups, 1, 1}});
    solver.scan_.add(frame, kRow, *solver.places_, solver.cells_, *cells.count, 3 * sizeof(std::uint32_t));
    frame.compute({.name = kRow,
                   .kernel = &kernels.list,
                   .bindings = {{0, *cells.lattice, Access::storage_read},
                                {1, *solver.fixed_point_, Access::words},
                                {2, *solver.places_, Access::words},
                                {3, *cells.listed, Access::storage_write},
                                {4, *cells.index_of, Access::storage_write},
                                {5, *cells.sigma, Access::storage_write},
                                {6, *cells.count, Access::storage_read_write},
                                {7, extinction, Access::storage_write}},
                   .push = as_push(window.level),
                   .groups = {groups, 1, 1}});
  }

  // What comes from outside, and the beam.
  void surround() {
    frame.compute({.name = kRow,
                   .kernel = &kernels.openness,
                   .bindings = {{0, *cells.lattice, Access::storage_read},
                                {1, *cells.index_of, Access::words},
                                {2, extinction, Access::sampled},
                                {3, *solver.openness_, Access::storage_write}},
                   .push = as_push(window.level),
                   .groups = {solver.openness_groups(), kOpennessRings, solver.openness_slices()}});
    frame.compute(
        {.name = kRow,
         .kernel = kernels.surroundings[air != nullptr],
         .bindings = {{0, *cells.lattice, Access::storage_read},
                      {1, frame_constants, Access::uniform},
                      {2, air ? air->transmittance : *solver.none_, Access::sampled},
                      {3, air ? air->multi_scattering : *solver.none_, Access::sampled},
                      {4, *solver.directions_, Access::storage_read},
                      {5, *solver.surroundings_, Access::storage_write},
                      {6, *solver.direction_ranges_, Access::storage_read},
                      {7, *window.pairs, Access::storage_read},
                      {8, *solver.openness_, Access::storage_read}},
         .push = as_push(glm::uvec2(solver.direction_count_, solver.openness_groups() * solver.openness_slices())),
         .groups = {groups_for(solver.direction_count_), 1, 1}});
    frame.compute({.name = kRow,
                   .kernel = &kernels.floor,
                   .bindings = {{0, *cells.lattice, Access::storage_read},
                                {1, extinction, Access::sampled},
                                {2, *solver.floor_, Access::storage_write}},
                   .push = as_push(glm::uvec2(window.level, kFloorPlaces)),
                   .groups = {groups_for(kFloorPlaces * kFloorPlaces), 1, 1}});
    frame.compute({.name = kRow,
                   .kernel = &kernels.depth,
                   .bindings = {{0, *cells.lattice, Access::storage_read},
                                {1, *cells.listed, Access::words},
                                {2, *cells.count, Access::storage_read},
                                {3, extinction, Access::sampled},
                                {4, *cells.depths, Access::storage_write}},
                   .push = as_push(window.level),
                   .indirect = each_cell});
  }

  void begin() {
    lines(false);
    boundary(false);
    frame.compute({.name = kRow,
                   .kernel = &kernels.begin,
                   .bindings = {{0, *cells.lattice, Access::storage_read},
                                {1, *cells.count, Access::storage_read},
                                {2, *cells.depths, Access::words},
                                {3, *cells.boundary, Access::storage_read},
                                {4, *solver.sources_[0], Access::storage_write},
                                {5, *cells.sigma, Access::words},
                                {6, *solver.beam_, Access::storage_write}},
                   .indirect = each_cell});
  }

  // with_skin: cells without matter, which the last sweep alone visits.
  void lines(bool with_skin) {
    frame.compute({.name = kRow,
                   .kernel = &kernels.lines,
                   .bindings = {{0, *cells.lattice, Access::storage_read},
                                {1, *window.pairs, Access::storage_read},
                                {2, *cells.index_of, Access::words},
                                {3, *solver.lines_, Access::storage_write},
                                {4, *solver.lengths_, Access::storage_write}},
                   .push = as_push(glm::uvec2(solver.cells_, with_skin)),
                   .groups = {groups_for(solver.lines_at_most()), shared::kLightPairs, 1}});
  }

  // swept: the ground is lit by what the last sweep let through.
  void boundary(bool swept) {
    frame.compute({.name = kRow,
                   .kernel = kernels.boundary[air != nullptr],
                   .bindings = {{0, *cells.lattice, Access::storage_read},
                                {1, frame_constants, Access::uniform},
                                {2, air ? air->transmittance : *solver.none_, Access::sampled},
                                {3, air ? air->sky_irradiance : *solver.none_, Access::sampled},
                                {4, *solver.surroundings_, Access::storage_read},
                                {5, *solver.direction_ranges_, Access::storage_read},
                                {6, *window.pairs, Access::storage_read},
                                {7, *solver.exit_sums_, Access::storage_read},
                                {8, *solver.floor_, Access::storage_read},
                                {9, *cells.boundary, Access::storage_write}},
                   .push = as_push(glm::uvec2(kFloorPlaces * kFloorPlaces, swept))});
  }

  struct SweepPush {
    std::uint32_t cell_count, lines_at_most;
    float scale, scaled_asymmetry;
    glm::vec3 travel;
  };

  void sweep(std::uint32_t sweep) {
    const bool last = sweep + 1 == solver.sweeps_;
    const Buffer &from = *solver.sources_[sweep % 2], &to = *solver.sources_[1 - sweep % 2];
    frame.compute({.name = kRow,
                   .kernel = &kernels.sweep,
                   .bindings = {{0, *window.pairs, Access::storage_read},
                                {1, *solver.lines_, Access::words},
                                {2, *solver.lengths_, Access::words},
                                {3, *cells.sigma, Access::words},
                                {4, from, Access::texels},
                                {5, *cells.boundary, Access::uniform},
                                {6, *solver.mean_, Access::storage_write},
                                {7, *solver.exits_, Access::storage_write},
                                {8, *solver.beam_, Access::words}},
                   .push = as_push(SweepPush{solver.cells_, solver.lines_at_most(), 1.0f - window.lattice.forward,
                                             window.lattice.scaled_asymmetry, -window.lattice.sun_direction}),
                   .groups = {groups_for(solver.lines_at_most()), shared::kLightPairs, 1}});
    if (last) {
      frame.compute({.name = kRow,
                     .kernel = kernels.moments[air != nullptr],
                     .bindings = {{0, *cells.lattice, Access::storage_read},
                                  {1, *cells.count, Access::storage_read},
                                  {2, *window.pairs, Access::storage_read},
                                  {3, *cells.listed, Access::words},
                                  {4, *solver.mean_, Access::words},
                                  {5, frame_constants, Access::uniform},
                                  {6, air ? air->transmittance : *solver.none_, Access::sampled},
                                  {7, *cells.moments, Access::storage_write}},
                     .push = as_push(glm::uvec2(solver.cells_, window.level)),
                     .indirect = each_cell});
      return;
    }
    struct Sum {
      std::uint32_t cell_count;
      SweepWeights weights;
    };
    frame.compute({.name = kRow,
                   .kernel = &kernels.sum,
                   .bindings = {{0, *cells.lattice, Access::storage_read},
                                {1, *cells.count, Access::storage_read},
                                {2, *window.pairs, Access::storage_read},
                                {3, *solver.mean_, Access::words},
                                {4, from, Access::texels},
                                {5, to, Access::storage_read_write}},
                   .push = as_push(Sum{solver.cells_, sweep_weights(sweep)}),
                   .indirect = each_cell});
    frame.compute({.name = kRow,
                   .kernel = &kernels.exits,
                   .bindings = {{0, *cells.lattice, Access::storage_read},
                                {1, *window.pairs, Access::storage_read},
                                {2, *solver.exits_, Access::texels},
                                {3, *solver.exit_sums_, Access::storage_write},
                                {4, to, Access::texels},
                                {5, *cells.count, Access::storage_read},
                                {6, *cells.sigma, Access::words}},
                   .groups = {1, shared::kLightPairs + 1, 1}});
    boundary(true);
  }
};

// So many that each has at most kChordPieces of the largest particle there can be, one that fills the window.
std::uint32_t LightSolver::threads_a_particle() const {
  constexpr std::uint32_t kChordPieces = 40000;
  return (cells_ + kChordPieces - 1) / kChordPieces;
}

std::uint32_t LightSolver::openness_groups() const {
  const std::uint32_t across = side_ / shared::kLightWindowStep;
  return groups_for(across * across);
}

std::uint32_t LightSolver::openness_slices() const { return (height_ + kLayersASlice - 1) / kLayersASlice; }

std::uint32_t LightSolver::units_left(const FrameBuilder& frame, const LightWindow& window) const {
  const std::uint32_t all = unit_count();
  if (!frame.holds(window.cells->listed, window.matter)) return frame.holds(particles_, window.matter) ? all - 1 : all;
  if (frame.holds(window.cells->moments, window.light)) return 0;
  // What the scratch buffers hold in between is remembered at one of them.
  for (std::uint32_t unit = all - 1; unit-- > 2;)
    if (frame.holds(mean_, after_unit(window.light, unit))) return all - 1 - unit;
  return all - 2;
}

void LightSolver::add(FrameBuilder& frame, const LightWindow& window, std::uint32_t units, const Image& extinction,
                      const Buffer& frame_constants, const AtmosphereTables* air) {
  const std::uint32_t left = units_left(frame, window);
  if (left == 0 || units == 0) return;
  frame.update(kRow, *window.cells->lattice, as_push(window.lattice));
  Steps steps{frame, *this, window, extinction, frame_constants, air};
  const std::uint32_t first = unit_count() - left;
  for (std::uint32_t unit = first; unit < unit_count() && unit - first < units; ++unit) {
    steps.add(unit);
    if (unit == 0)
      frame.stands(particles_, window.matter);
    else if (unit == 1)
      frame.stands(window.cells->listed, window.matter);
    else {
      // From unit 2 on a window's cells are changed, and its moments go with their other results.
      const bool last = unit + 1 == unit_count();
      const InputBytes after = after_unit(window.light, unit);
      if (!last) frame.stands(mean_, after);
      frame.stands(window.cells->moments, last ? window.light : after);
    }
  }
}

}  // namespace nephele
