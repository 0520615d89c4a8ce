#include "tools/clouds/device_nodes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "engine/check.h"
#include "engine/frame.h"
#include "engine/kernel.h"
#include "engine/resources.h"
#include "nephele_tool_shaders.h"
#include "tools/clouds/window_steps.h"

namespace nephele::clouds {
namespace {

constexpr std::uint32_t kLocalSize = 64;

// As volume_nodes.comp has them.
struct DeviceStep {
  std::uint32_t node;
  glm::vec2 share, from_m, square_m2;
  float thickness_m, low_m, high_m;
};
struct NodeMoments {
  float mass_m2;
  glm::vec3 first, diagonal, off_diagonal;
  float low_m, high_m;
};
struct Push {
  glm::uvec3 node_count;
  glm::uvec2 voxel_count;
  glm::uvec3 first_step, first_node;
  float faintest_per_m;
};

// An axis' steps, and which of them belong to a node: they lie together, because nodes rise with voxels.
struct Axes {
  std::vector<DeviceStep> steps;
  std::vector<std::uint32_t> begins, ends;
  Push push{};
  glm::ivec3 first_index{0};
  std::size_t most_voxels = 1;  // in a window
};

Axes axes_of(const VolumeGrid& grid, const glm::dvec3& spacing_m, double soft_edge) {
  Axes all;
  all.push.faintest_per_m = kFaintestPerM;
  for (int axis = 0; axis < 3; ++axis) {
    const AxisSteps own =
        axis_steps(grid.bounds_m[static_cast<std::size_t>(axis)], grid.anchor_m[axis], spacing_m[axis], soft_edge);
    all.push.first_step[axis] = static_cast<std::uint32_t>(all.steps.size());
    all.push.first_node[axis] = static_cast<std::uint32_t>(all.begins.size());
    all.push.node_count[axis] = static_cast<std::uint32_t>(own.nodes);
    all.first_index[axis] = own.first_node;
    std::size_t longest = 1;
    for (std::size_t node = 0; node < own.nodes; ++node) {
      const auto below = [](const Step& step, std::size_t wanted) { return step.node < wanted; };
      const auto first =
          std::lower_bound(own.steps.begin(), own.steps.end(), node > 0 ? node - 1 : 0, below) - own.steps.begin();
      const auto last = std::lower_bound(own.steps.begin(), own.steps.end(), node + 1, below) - own.steps.begin();
      all.begins.push_back(static_cast<std::uint32_t>(first));
      all.ends.push_back(static_cast<std::uint32_t>(last));
      longest = std::max(longest, static_cast<std::size_t>(last - first));
    }
    all.most_voxels *= longest;
    for (const Step& step : own.steps)
      all.steps.push_back({static_cast<std::uint32_t>(step.node), glm::vec2(step.share[0], step.share[1]),
                           glm::vec2(step.from_m[0], step.from_m[1]), glm::vec2(step.square[0], step.square[1]),
                           static_cast<float>(step.thickness_m), step.low_m, step.high_m});
  }
  all.push.voxel_count = {grid.count(0), grid.count(1)};
  return all;
}

template <class T>
Buffer filled(Device& device, const char* name, const std::vector<T>& values) {
  Buffer buffer(device, name, values.size() * sizeof(T));
  buffer.write_vector(values);
  return buffer;
}

}  // namespace

Result<NodeLattice> gather_nodes_on(Device& device, VolumeReader& reader, const FitOptions& options, FitStats* stats) {
  if (auto ok = check_grid(reader.grid()); !ok) return ok.error();
  const glm::dvec3 spacing_m = spacing_of(reader.grid(), options);
  const Axes axes = axes_of(reader.grid(), spacing_m, options.soft_edge);
  if (axes.most_voxels > kMaxWindowVoxels)
    return Error{concat("a window holds ", axes.most_voxels, " voxels; accepted on a device: at most ",
                        kMaxWindowVoxels, ", by a smaller spacing")};
  const std::size_t voxels = reader.grid().voxels();
  const glm::uvec3 n = axes.push.node_count;
  const std::size_t nodes = std::size_t{n.x} * n.y * n.z;
  if (voxels > device.max_elements(sizeof(float)) || nodes > device.max_elements(sizeof(NodeMoments)))
    return Error{concat("the volume has ", voxels, " voxels and ", nodes, " nodes; accepted on this device: ",
                        device.max_elements(sizeof(float)), " and ", device.max_elements(sizeof(NodeMoments)))};
  const Result<MemoryVolume> volume = load_volume(reader, voxels);
  if (!volume) return volume.error();

  const Buffer in = filled(device, "voxels", volume->values());
  const Buffer steps = filled(device, "axis_steps", axes.steps);
  const Buffer begins = filled(device, "node_begins", axes.begins), ends = filled(device, "node_ends", axes.ends);
  Buffer out(device, "nodes", nodes * sizeof(NodeMoments));
  const ComputeKernel kernel(device, shaders::volume_nodes_comp);
  FrameBuilder frame(device);
  frame.compute({.name = "volume nodes",
                 .kernel = &kernel,
                 .bindings = {{0, in, Access::storage_read},
                              {1, steps, Access::storage_read},
                              {2, begins, Access::storage_read},
                              {3, ends, Access::storage_read},
                              {4, out, Access::storage_write}},
                 .push = as_push(axes.push),
                 .groups = {static_cast<std::uint32_t>((nodes + kLocalSize - 1) / kLocalSize), 1, 1},
                 .indirect = {}});
  FrameExecutor(device).run(frame);

  NodeLattice lattice{spacing_m, reader.grid().anchor_m, {}};
  const std::vector<NodeMoments> moments = out.read_vector<NodeMoments>(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    const NodeMoments& m = moments[i];
    if (!(m.mass_m2 > 0.0f)) continue;
    const glm::ivec3 at(static_cast<int>(i % n.x), static_cast<int>(i / n.x % n.y),
                        static_cast<int>(i / (std::size_t{n.x} * n.y)));
    lattice.nodes.push_back({axes.first_index + at, static_cast<double>(m.mass_m2), glm::dvec3(m.first),
                             glm::dvec3(m.diagonal), glm::dvec3(m.off_diagonal), m.low_m, m.high_m});
  }
  if (stats) {
    stats->voxels = voxels;
    for (const float value : volume->values()) {
      stats->occupied_voxels += value > 0.0f;
      stats->peak_per_m = std::max(stats->peak_per_m, static_cast<double>(value));
    }
    for (const Node& node : lattice.nodes) stats->mass_m2 += node.mass_m2;
    stats->memory_bytes = voxels * sizeof(float) + nodes * sizeof(NodeMoments);
  }
  return lattice;
}

}  // namespace nephele::clouds
