// A volume as soft particles: every node of a lattice takes mass, centroid and covariance of what its window holds
// (shaders/shared/volume_moments.h), and becomes the particle that has the same three.
//
// Guarantees: mass is kept to rounding (particles hold what the volume holds, whatever is dropped); one pass over the
// volume; the same bits for any number of threads; no choice that could flip, so that particles move smoothly with the
// matter. The lattice stands in the world: a volume that is moved by whole spacings, or cropped, keeps its nodes and
// their seeds. Memory: a slab of planes, two planes of nodes, and about 110 bytes for every node that holds anything.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "engine/particle_set.h"
#include "engine/result.h"
#include "tools/clouds/volume_reader.h"

namespace nephele::clouds {

struct FitOptions {
  double spacing_voxels = 4.0;           // between nodes, horizontally
  double vertical_spacing_voxels = 3.0;  // in voxels of the usual height
  std::optional<glm::dvec3> spacing_m;   // in place of both
  double soft_edge = 0.7;                // of a window, 0 (a box) to 1 (a hat)
  // Nodes of less than this part of the mean mass of a node (the mean over the matter) are left out, those of less than
  // twice as much in part; their mass goes to the others.
  double drop = 0.004;
  std::size_t coarser_levels = 4;  // at most; a level of fewer than 8 particles is not made
  float detail = 0.5f;             // of the set
  int threads = 0;                 // 0: one a core
};

// A node's window. Moments are relative to the node; doubles, because sums of many voxels are differences of squares.
struct Node {
  glm::ivec3 index{0};  // of the world's lattice
  double mass_m2 = 0.0;
  glm::dvec3 first{0.0}, diagonal{0.0}, off_diagonal{0.0};
  float low_m = 0.0f, high_m = -1.0f;  // of the voxels in it that can be seen; high below low: there are none
};

// Nodes that hold matter, sorted by z, then y, then x of their indices.
struct NodeLattice {
  glm::dvec3 spacing_m{0.0}, anchor_m{0.0};
  std::vector<Node> nodes;

  glm::dvec3 place_m(const glm::ivec3& index) const { return glm::dvec3(index) * spacing_m - anchor_m; }
};

struct FitStats {
  std::size_t voxels = 0, occupied_voxels = 0, negative_voxels = 0;
  double mass_m2 = 0.0;  // extinction times volume
  double peak_per_m = 0.0;
  std::size_t memory_bytes = 0;  // what the pass held at most
};

struct VolumeFit {
  ParticleSet set;
  NodeLattice lattice;  // the finest
  FitStats stats;
};

using FitProgress = std::function<void(double fraction)>;

glm::dvec3 spacing_of(const VolumeGrid& grid, const FitOptions& options);

// The one pass. A value that is not finite is an error, and so is a spacing that makes too many nodes.
Result<NodeLattice> gather_nodes(VolumeReader& reader, const FitOptions& options, FitStats* stats = nullptr,
                                 const FitProgress& progress = {});

// Twice the spacing: moments add, so these are the very moments of wider windows, which sum to one again.
NodeLattice coarser_nodes(const NodeLattice& fine);

// Particles with base, top and seed, of shape `soft`; without coarser levels. An empty lattice is an error.
Result<ParticleSet> particles_of_nodes(const NodeLattice& lattice, const FitOptions& options);

// What follows the gathering, wherever that was done: particles and coarser levels.
Result<VolumeFit> fit_of_nodes(NodeLattice lattice, const FitStats& stats, const FitOptions& options);

// All of it, with coarser levels.
Result<VolumeFit> fit_volume(VolumeReader& reader, const FitOptions& options, const FitProgress& progress = {});

// Extinction times volume, of all particles together.
double particle_mass_m2(const ParticleSet& set);

}  // namespace nephele::clouds
