#include "tools/clouds/volume_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "engine/check.h"
#include "engine/parallel.h"
#include "shared/hash.h"
#include "shared/volume_moments.h"
#include "tools/clouds/window_steps.h"

namespace nephele::clouds {
namespace {

constexpr std::size_t kSlabVoxels = std::size_t{1} << 22;
constexpr std::size_t kMaxNodes = 4 * kMaxSetParticles;
constexpr float kNone = std::numeric_limits<float>::infinity();

// Sums over a part of a row, of a plane, of a window, in the reader's order of axes: a the fastest, c the slowest.
struct Seen {
  float low_m = kNone, high_m = -kNone;
  void add(float low, float high) {
    low_m = std::min(low_m, low);
    high_m = std::max(high_m, high);
  }
};
struct RowSum {
  double m = 0, a = 0, aa = 0;
  Seen seen;
};
struct PlaneSum {
  double m = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  Seen seen;
};
struct WindowSum {
  double m = 0, a = 0, b = 0, c = 0, aa = 0, bb = 0, cc = 0, ab = 0, ac = 0, bc = 0;
  Seen seen;
};

// What a plane of voxels adds up to.
struct PlaneResult {
  std::vector<PlaneSum> sums;  // of the plane's nodes, a fastest
  std::size_t occupied = 0, negative = 0;
  double peak = 0.0;
  std::optional<std::size_t> not_finite;  // the first such voxel
};

class Gatherer {
 public:
  Gatherer(VolumeReader& reader, const FitOptions& options, const glm::dvec3& spacing_m)
      : reader_(reader), options_(options), order_(reader.axes()) {
    for (std::size_t i = 0; i < 3; ++i) {
      const int axis = order_[i];
      steps_[i] = axis_steps(reader.grid().bounds_m[static_cast<std::size_t>(axis)], reader.grid().anchor_m[axis],
                             spacing_m[axis], options.soft_edge);
    }
    lattice_.spacing_m = spacing_m;
    lattice_.anchor_m = reader.grid().anchor_m;
  }

  Result<NodeLattice> run(FitStats& stats, const FitProgress& progress) {
    const std::size_t plane = reader_.plane_voxels(), planes = reader_.planes();
    const std::size_t plane_nodes = steps_[0].nodes * steps_[1].nodes;
    if (plane_nodes > kMaxNodes) return too_many();
    const std::size_t at_once = std::clamp<std::size_t>(kSlabVoxels / plane, 1, std::min<std::size_t>(planes, 64));
    std::vector<float> slab(at_once * plane);
    std::vector<PlaneResult> results(at_once);
    for (std::vector<WindowSum>& window : windows_) window.assign(plane_nodes, {});
    for (std::size_t first = 0; first < planes; first += at_once) {
      const std::size_t count = std::min(at_once, planes - first);
      if (auto ok = reader_.read_planes(first, count, std::span(slab).first(count * plane)); !ok) return ok.error();
      parallel_for(
          static_cast<int>(count),
          [&](int i) {
            const auto k = static_cast<std::size_t>(i);
            add_up(std::span<const float>(slab).subspan(k * plane, plane), results[k]);
          },
          options_.threads);
      for (std::size_t k = 0; k < count; ++k) {
        if (results[k].not_finite)
          return not_finite(*results[k].not_finite, first + k, slab[k * plane + *results[k].not_finite]);
        stats.occupied_voxels += results[k].occupied;
        stats.negative_voxels += results[k].negative;
        stats.peak_per_m = std::max(stats.peak_per_m, results[k].peak);
        add_plane(results[k].sums, steps_[2].steps[first + k]);
        if (lattice_.nodes.size() > kMaxNodes) return too_many();
      }
      if (progress) progress(static_cast<double>(first + count) / static_cast<double>(planes));
    }
    flush(steps_[2].nodes);
    stats.voxels = reader_.grid().voxels();
    stats.memory_bytes = slab.size() * sizeof(float) + at_once * plane_nodes * sizeof(PlaneSum) +
                         2 * plane_nodes * sizeof(WindowSum) + lattice_.nodes.capacity() * sizeof(Node);
    // Independent of the order in which a file keeps its axes.
    std::sort(lattice_.nodes.begin(), lattice_.nodes.end(), [](const Node& a, const Node& b) {
      return std::array{a.index.z, a.index.y, a.index.x} < std::array{b.index.z, b.index.y, b.index.x};
    });
    for (const Node& node : lattice_.nodes) stats.mass_m2 += node.mass_m2;
    return std::move(lattice_);
  }

 private:
  static Error too_many() {
    return Error{concat("the spacing is too small: more than ", kMaxNodes, " nodes hold matter; take a greater one")};
  }

  Error not_finite(std::size_t at, std::size_t plane, float value) const {
    glm::uvec3 voxel(0u);
    voxel[order_[0]] = static_cast<std::uint32_t>(at % reader_.grid().count(order_[0]));
    voxel[order_[1]] = static_cast<std::uint32_t>(at / reader_.grid().count(order_[0]));
    voxel[order_[2]] = static_cast<std::uint32_t>(plane);
    return Error{
        concat("voxel (", voxel.x, ", ", voxel.y, ", ", voxel.z, ") is ", value, "; accepted: finite numbers")};
  }

  // The range along z that a voxel at this step shows; where z is another axis, that it shows at all.
  Seen range(std::size_t axis, const Step& step, const Seen& inner) const {
    if (order_[axis] == 2 && inner.high_m > -kNone) return {step.low_m, step.high_m};
    return inner;
  }

  void add_up(std::span<const float> values, PlaneResult& result) const {
    const std::size_t nodes_a = steps_[0].nodes;
    result = {std::move(result.sums)};
    result.sums.assign(nodes_a * steps_[1].nodes, {});
    std::vector<RowSum> row(nodes_a);
    const std::vector<Step>& along_a = steps_[0].steps;
    const std::size_t length = along_a.size();
    for (std::size_t j = 0; j < steps_[1].steps.size(); ++j) {
      std::size_t low = nodes_a, high = 0;
      for (std::size_t i = 0; i < length; ++i) {
        const float value = values[j * length + i];
        if (!(value > 0.0f)) {
          if (value < 0.0f && std::isfinite(value)) ++result.negative;
          if (!std::isfinite(value) && !result.not_finite) result.not_finite = j * length + i;
          continue;
        }
        if (!std::isfinite(value)) {
          if (!result.not_finite) result.not_finite = j * length + i;
          continue;
        }
        ++result.occupied;
        result.peak = std::max(result.peak, static_cast<double>(value));
        const Step& step = along_a[i];
        low = std::min(low, step.node);
        high = std::max(high, step.node + 2);
        for (std::size_t k = 0; k < 2; ++k) {
          if (step.share[k] == 0.0) continue;
          RowSum& sum = row[step.node + k];
          const double m = step.share[k] * step.thickness_m * static_cast<double>(value);
          sum.m += m;
          sum.a += m * step.from_m[k];
          sum.aa += m * step.square[k];
          if (value > kFaintestPerM) {
            const Seen seen = range(0, step, {0.0f, 0.0f});
            sum.seen.add(seen.low_m, seen.high_m);
          }
        }
      }
      const Step& step = steps_[1].steps[j];
      for (std::size_t k = 0; k < 2; ++k) {
        if (step.share[k] == 0.0) continue;
        for (std::size_t i = low; i < high; ++i) {
          const RowSum& from = row[i];
          if (from.m == 0.0) continue;
          PlaneSum& sum = result.sums[(step.node + k) * nodes_a + i];
          const double w = step.share[k] * step.thickness_m, d = step.from_m[k];
          sum.m += w * from.m;
          sum.a += w * from.a;
          sum.aa += w * from.aa;
          sum.b += w * d * from.m;
          sum.bb += w * step.square[k] * from.m;
          sum.ab += w * d * from.a;
          const Seen seen = range(1, step, from.seen);
          sum.seen.add(seen.low_m, seen.high_m);
        }
      }
      if (low < high)
        std::fill(row.begin() + static_cast<std::ptrdiff_t>(low), row.begin() + static_cast<std::ptrdiff_t>(high),
                  RowSum{});
    }
  }

  void add_plane(const std::vector<PlaneSum>& sums, const Step& step) {
    flush(step.node);
    for (std::size_t k = 0; k < 2; ++k) {
      if (step.share[k] == 0.0) continue;
      std::vector<WindowSum>& windows = windows_[(step.node + k) % 2];
      const double w = step.share[k] * step.thickness_m, d = step.from_m[k];
      for (std::size_t i = 0; i < sums.size(); ++i) {
        const PlaneSum& from = sums[i];
        if (from.m == 0.0) continue;
        WindowSum& sum = windows[i];
        sum.m += w * from.m;
        sum.a += w * from.a;
        sum.b += w * from.b;
        sum.aa += w * from.aa;
        sum.bb += w * from.bb;
        sum.ab += w * from.ab;
        sum.c += w * d * from.m;
        sum.cc += w * step.square[k] * from.m;
        sum.ac += w * d * from.a;
        sum.bc += w * d * from.b;
        const Seen seen = range(2, step, from.seen);
        sum.seen.add(seen.low_m, seen.high_m);
      }
    }
  }

  // Planes of nodes below `node` are complete. Only two are ever at work.
  void flush(std::size_t node) {
    for (; flushed_ < node; ++flushed_) {
      std::vector<WindowSum>& windows = windows_[flushed_ % 2];
      for (std::size_t i = 0; i < windows.size(); ++i) {
        if (windows[i].m <= 0.0) continue;
        lattice_.nodes.push_back(node_of(windows[i], i % steps_[0].nodes, i / steps_[0].nodes, flushed_));
        windows[i] = {};
      }
    }
  }

  Node node_of(const WindowSum& sum, std::size_t a, std::size_t b, std::size_t c) const {
    Node node;
    const std::array<std::size_t, 3> at{a, b, c};
    const std::array<double, 3> first{sum.a, sum.b, sum.c}, square{sum.aa, sum.bb, sum.cc};
    const std::array<double, 3> mixed{sum.ab, sum.ac, sum.bc};  // of the axes without c, without b, without a
    for (std::size_t i = 0; i < 3; ++i) {
      node.index[order_[i]] = steps_[i].first_node + static_cast<int>(at[i]);
      node.first[order_[i]] = first[i];
      node.diagonal[order_[i]] = square[i];
      // xy is without z, xz without y, yz without x.
      node.off_diagonal[2 - order_[2 - i]] = mixed[i];
    }
    node.mass_m2 = sum.m;
    if (sum.seen.high_m > -kNone) {
      node.low_m = sum.seen.low_m;
      node.high_m = sum.seen.high_m;
    }
    return node;
  }

  VolumeReader& reader_;
  const FitOptions& options_;
  std::array<int, 3> order_;
  std::array<AxisSteps, 3> steps_;
  std::array<std::vector<WindowSum>, 2> windows_;
  std::size_t flushed_ = 0;
  NodeLattice lattice_;
};

bool is_seen(const Node& node) { return node.high_m >= node.low_m; }

// Base and top of every node's own cloud: nodes that touch, be it at a corner, belong to one.
std::vector<Seen> clouds_of(const std::vector<const Node*>& nodes, const std::vector<Seen>& own) {
  std::vector<std::size_t> parent(nodes.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto before = [](const Node* node, const glm::ivec3& index) {
    return std::array{node->index.z, node->index.y, node->index.x} < std::array{index.z, index.y, index.x};
  };
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (int row = 0; row < 5; ++row) {  // of the neighbours, those earlier in the order
      const int dz = row < 3 ? -1 : 0, dy = row < 3 ? row - 1 : row - 4;
      const glm::ivec3 from = nodes[i]->index + glm::ivec3(-1, dy, dz);
      auto at = std::lower_bound(nodes.begin(), nodes.end(), from, before);
      for (; at != nodes.end() && (*at)->index.z == from.z && (*at)->index.y == from.y; ++at) {
        const auto k = static_cast<std::size_t>(at - nodes.begin());
        if ((*at)->index.x > from.x + 2 || k >= i) break;
        const std::size_t a = root(i), b = root(k);
        parent[std::max(a, b)] = std::min(a, b);
      }
    }
  std::vector<Seen> clouds(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) clouds[root(i)].add(own[i].low_m, own[i].high_m);
  for (std::size_t i = 0; i < nodes.size(); ++i) clouds[i] = clouds[root(i)];
  return clouds;
}

double median_step(std::vector<double> bounds_m) {
  std::adjacent_difference(bounds_m.begin(), bounds_m.end(), bounds_m.begin());
  const auto middle = bounds_m.begin() + 1 + static_cast<std::ptrdiff_t>((bounds_m.size() - 1) / 2);
  const auto at = std::min(middle, bounds_m.end() - 1);
  std::nth_element(bounds_m.begin() + 1, at, bounds_m.end());
  return *at;
}

}  // namespace

AxisSteps axis_steps(const std::vector<double>& bounds_m, double anchor_m, double spacing_m, double soft_edge) {
  AxisSteps axis;
  axis.steps.resize(bounds_m.size() - 1);
  const auto center_m = [&](std::size_t i) { return 0.5 * (bounds_m[i] + bounds_m[i + 1]); };
  const double first = std::floor((center_m(0) + anchor_m) / spacing_m);
  for (std::size_t i = 0; i < axis.steps.size(); ++i) {
    Step& step = axis.steps[i];
    const double t = (center_m(i) + anchor_m) / spacing_m, node = std::floor(t);
    step.node = static_cast<std::size_t>(node - first);
    step.thickness_m = bounds_m[i + 1] - bounds_m[i];
    step.low_m = static_cast<float>(bounds_m[i]);
    step.high_m = static_cast<float>(bounds_m[i + 1]);
    const double upper =
        soft_edge > 0.0 ? std::clamp((t - node - 0.5) / soft_edge + 0.5, 0.0, 1.0) : (t - node < 0.5 ? 0.0 : 1.0);
    step.share = {1.0 - upper, upper};
    for (std::size_t k = 0; k < 2; ++k) {
      step.from_m[k] = center_m(i) + anchor_m - (node + static_cast<double>(k)) * spacing_m;
      step.square[k] = step.from_m[k] * step.from_m[k] + step.thickness_m * step.thickness_m / 12.0;
    }
  }
  axis.first_node = static_cast<int>(first);
  axis.nodes = axis.steps.back().node + 2;
  return axis;
}

glm::dvec3 spacing_of(const VolumeGrid& grid, const FitOptions& options) {
  if (options.spacing_m) return *options.spacing_m;
  return {options.spacing_voxels * median_step(grid.bounds_m[0]),
          options.spacing_voxels * median_step(grid.bounds_m[1]),
          options.vertical_spacing_voxels * median_step(grid.bounds_m[2])};
}

Result<NodeLattice> gather_nodes(VolumeReader& reader, const FitOptions& options, FitStats* stats,
                                 const FitProgress& progress) {
  if (auto ok = check_grid(reader.grid()); !ok) return ok.error();
  const glm::dvec3 spacing_m = spacing_of(reader.grid(), options);
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& bounds = reader.grid().bounds_m[static_cast<std::size_t>(axis)];
    const double nodes = (bounds.back() - bounds.front()) / spacing_m[axis];
    const double farthest = std::abs(reader.grid().anchor_m[axis]) + std::max(-bounds.front(), bounds.back());
    if (!(spacing_m[axis] > 0.0 && nodes < static_cast<double>(kMaxNodes) && farthest / spacing_m[axis] < 1e9))
      return Error{concat("a spacing of ", spacing_m[axis], " m is too small for this volume; take a greater one")};
  }
  FitStats unused;
  return Gatherer(reader, options, spacing_m).run(stats ? *stats : unused, progress);
}

NodeLattice coarser_nodes(const NodeLattice& fine) {
  NodeLattice coarse{2.0 * fine.spacing_m, fine.anchor_m, {}};
  // A node stands on a coarser one, or halfway between two, which share it alike. So a coarser window is one fine
  // window and half of each neighbour: these sum to one again.
  coarse.nodes.reserve(4 * fine.nodes.size());
  for (const Node& node : fine.nodes)
    for (int corner = 0; corner < 8; ++corner) {
      double share = 1.0;
      glm::ivec3 index;
      bool twice = false;
      for (int axis = 0; axis < 3; ++axis) {
        const int upper = corner >> axis & 1;
        const bool between = (node.index[axis] & 1) != 0;
        twice = twice || (upper == 1 && !between);
        if (between) share *= 0.5;
        index[axis] = (node.index[axis] - (between ? 1 : 0)) / 2 + upper;
      }
      if (twice) continue;
      const glm::dvec3 d = glm::dvec3(node.index - 2 * index) * fine.spacing_m;
      const double m = node.mass_m2;
      const glm::dvec3 f = node.first;
      Node moved = node;
      moved.index = index;
      moved.mass_m2 = share * m;
      moved.first = share * (f + m * d);
      moved.diagonal = share * (node.diagonal + 2.0 * f * d + m * d * d);
      moved.off_diagonal = share * (node.off_diagonal + glm::dvec3(f.x * d.y + f.y * d.x + m * d.x * d.y,
                                                                   f.x * d.z + f.z * d.x + m * d.x * d.z,
                                                                   f.y * d.z + f.z * d.y + m * d.y * d.z));
      coarse.nodes.push_back(moved);
    }
  const auto key = [](const Node& node) { return std::array{node.index.z, node.index.y, node.index.x}; };
  std::stable_sort(coarse.nodes.begin(), coarse.nodes.end(),
                   [&](const Node& a, const Node& b) { return key(a) < key(b); });
  std::size_t kept = 0;
  for (std::size_t i = 1; i < coarse.nodes.size(); ++i) {
    Node& sum = coarse.nodes[kept];
    const Node& next = coarse.nodes[i];
    if (sum.index != next.index) {
      coarse.nodes[++kept] = next;
      continue;
    }
    sum.mass_m2 += next.mass_m2;
    sum.first += next.first;
    sum.diagonal += next.diagonal;
    sum.off_diagonal += next.off_diagonal;
    if (!is_seen(next)) continue;
    sum.low_m = is_seen(sum) ? std::min(sum.low_m, next.low_m) : next.low_m;
    sum.high_m = is_seen(sum) ? std::max(sum.high_m, next.high_m) : next.high_m;
  }
  if (!coarse.nodes.empty()) coarse.nodes.resize(kept + 1);
  return coarse;
}

Result<ParticleSet> particles_of_nodes(const NodeLattice& lattice, const FitOptions& options) {
  double mass = 0.0, squares = 0.0;
  for (const Node& node : lattice.nodes) {
    mass += node.mass_m2;
    squares += node.mass_m2 * node.mass_m2;
  }
  if (!(mass > 0.0)) return Error{"there is no cloud in it: no voxel is above 0"};
  const double least = options.drop * squares / mass;
  std::vector<const Node*> nodes;
  std::vector<double> masses;
  double kept = 0.0;
  for (const Node& node : lattice.nodes) {
    const double t = least > 0.0 ? std::clamp(node.mass_m2 / least - 1.0, 0.0, 1.0) : 1.0;
    const double part = node.mass_m2 * (t * t * (3.0 - 2.0 * t));
    if (part <= 1e-9 * squares / mass) continue;
    nodes.push_back(&node);
    masses.push_back(part);
    kept += part;
  }
  if (nodes.size() > kMaxSetParticles)
    return Error{
        concat("the spacing is too small: ", nodes.size(), " particles; accepted: at most ", kMaxSetParticles)};

  // A particle thinner than this would be a flake that no ray meets.
  const double least_radius_m = 0.2 * std::min({lattice.spacing_m.x, lattice.spacing_m.y, lattice.spacing_m.z});
  ParticleSet set;
  set.shape = ParticleShape::soft;
  set.detail = options.detail;
  set.particles.resize(nodes.size());
  std::vector<Seen> seen(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Node& node = *nodes[i];
    const double part = masses[i] / kept * mass / node.mass_m2;
    // About the centroid, in doubles: a difference of squares is where floats would lose digits.
    const glm::dvec3 c = node.first / node.mass_m2;
    const glm::dvec3 own = node.diagonal - node.mass_m2 * c * c;
    const glm::dvec3 mixed = node.off_diagonal - node.mass_m2 * glm::dvec3(c.x * c.y, c.x * c.z, c.y * c.z);
    const shared::MomentParticle made = shared::particle_of_moments(
        {static_cast<float>(node.mass_m2 * part), glm::vec3(0.0f), glm::vec3(own * part), glm::vec3(mixed * part)},
        static_cast<float>(least_radius_m));
    SetParticle& p = set.particles[i];
    p.center_m = glm::vec3(lattice.place_m(node.index) + c);
    p.diagonal_m = made.diagonal_m;
    p.off_diagonal_m = made.off_diagonal_m;
    p.extinction_per_m = made.extinction_per_m;
    p.seed = static_cast<float>(shared::hash_ivec3(node.index, 0u) >> 8u);
    seen[i] = is_seen(node) ? Seen{node.low_m, node.high_m}
                            : Seen{p.center_m.z - p.diagonal_m.z, p.center_m.z + p.diagonal_m.z};
  }
  const std::vector<Seen> clouds = clouds_of(nodes, seen);
  set.base_m = kNone;
  set.top_m = -kNone;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    set.particles[i].base_m = clouds[i].low_m;
    set.particles[i].top_m = clouds[i].high_m;
    set.base_m = std::min(set.base_m, clouds[i].low_m);
    set.top_m = std::max(set.top_m, clouds[i].high_m);
  }
  set.source = "volume";
  return set;
}

Result<VolumeFit> fit_volume(VolumeReader& reader, const FitOptions& options, const FitProgress& progress) {
  FitStats stats;
  Result<NodeLattice> lattice = gather_nodes(reader, options, &stats, progress);
  if (!lattice) return lattice.error();
  return fit_of_nodes(std::move(*lattice), stats, options);
}

Result<VolumeFit> fit_of_nodes(NodeLattice lattice, const FitStats& stats, const FitOptions& options) {
  VolumeFit fit{{}, std::move(lattice), stats};
  Result<ParticleSet> set = particles_of_nodes(fit.lattice, options);
  if (!set) return set.error();
  fit.set = std::move(*set);
  NodeLattice coarse = fit.lattice;
  for (std::size_t level = 0; level < std::min(options.coarser_levels, kMaxCoarserLevels); ++level) {
    coarse = coarser_nodes(coarse);
    Result<ParticleSet> made = particles_of_nodes(coarse, options);
    if (!made) return made.error();
    if (made->particles.size() < 8) break;
    fit.set.coarser.push_back(std::move(*made));
  }
  return fit;
}

double particle_mass_m2(const ParticleSet& set) {
  double mass = 0.0;
  for (const SetParticle& p : set.particles) {
    const glm::dvec3 d(p.diagonal_m), o(p.off_diagonal_m);
    const double determinant =
        d.z * (d.x * d.y - o.x * o.x) - o.z * (o.z * d.x - o.x * o.y) + o.y * (o.x * o.z - d.y * o.y);
    mass += static_cast<double>(p.extinction_per_m) * determinant;
  }
  return mass * static_cast<double>(shared::kProfileFill) * 4.0 / 3.0 * 3.14159265358979323846;
}

}  // namespace nephele::clouds
