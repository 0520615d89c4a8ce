#include "passes/sky/terrain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <span>
#include <vector>

#include "nephele_shaders.h"

namespace nephele {
namespace {

using shared::TerrainConstants;

constexpr std::uint32_t kTileColumns = 8, kTileRows = 4;        // terrain_begin.comp
constexpr int kMostShadowSide = 1200, kMostOpennessSide = 160;  // samples

constexpr SpecConstant kRows[] = {{0, kTileRows}};  // constant_id in terrain_begin.comp and terrain_distance.comp

// constant_id in terrain_radiance.comp.
enum Constant : std::uint32_t { kAir, kShadow };

std::uint32_t stride_for(const glm::ivec2& vertices, int most) {
  std::uint32_t stride = 1;
  while (std::max(vertices.x, vertices.y) / static_cast<int>(stride) > most) stride *= 2;
  return stride;
}

TerrainConstants fixed_constants(const TerrainGrid& grid) {
  TerrainConstants c{};
  c.per_m = glm::vec2(1.0 / grid.spacing_m);
  c.vertices = grid.vertices;
  c.highest_m = grid.highest_m;
  c.levels = 1;
  while (shared::terrain_nodes(grid.vertices - 1, c.levels - 1) != glm::ivec2(1)) ++c.levels;
  c.shadow_stride = stride_for(grid.vertices, kMostShadowSide);
  c.openness_stride = stride_for(grid.vertices, kMostOpennessSide);
  return c;
}

// Level after level of maxima over patches, rows from the south.
std::vector<float> pyramid_of_maxima(const TerrainGrid& grid, std::uint32_t levels) {
  glm::ivec2 size = grid.vertices - 1;
  std::vector<float> maxima;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x)
      maxima.push_back(std::max({grid.at({x, y}), grid.at({x + 1, y}), grid.at({x, y + 1}), grid.at({x + 1, y + 1})}));
  std::size_t first = 0;
  for (std::uint32_t level = 1; level < levels; ++level) {
    const glm::ivec2 below = size;
    size = (size + 1) / 2;
    const auto at = [&](int x, int y) {
      const glm::ivec2 inside = glm::min(glm::ivec2(x, y), below - 1);
      return maxima[first + std::size_t(inside.y) * std::size_t(below.x) + std::size_t(inside.x)];
    };
    std::vector<float> next;
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        next.push_back(
            std::max({at(2 * x, 2 * y), at(2 * x + 1, 2 * y), at(2 * x, 2 * y + 1), at(2 * x + 1, 2 * y + 1)}));
    first = maxima.size();
    maxima.insert(maxima.end(), next.begin(), next.end());
  }
  return maxima;
}

// Slopes and steepness at vertices, and level after level of their means: two words a node, halves of the mean slope
// east and north, and of the mean steepness.
std::vector<glm::uvec2> pyramid_of_slopes(const TerrainGrid& grid) {
  glm::ivec2 size = grid.vertices;
  const std::vector<float> steepness = terrain_steepness(grid);
  std::vector<glm::vec3> nodes;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x)
      nodes.emplace_back(glm::vec2(terrain_slope(grid, {x, y})), steepness[nodes.size()]);
  std::vector<glm::uvec2> packed;
  for (;;) {
    for (const glm::vec3& node : nodes)
      packed.emplace_back(glm::packHalf2x16(glm::vec2(node)),
                          glm::packHalf2x16(glm::vec2(std::min(node.z, 60000.0f), 0)));
    if (size == glm::ivec2(1)) return packed;
    const glm::ivec2 below = size;
    size = (size + 1) / 2;
    std::vector<glm::vec3> next;
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        glm::vec3 sum(0.0f);
        float count = 0.0f;
        for (int i = 0; i < 4; ++i) {
          const int from_x = 2 * x + i % 2, from_y = 2 * y + i / 2;
          if (from_x >= below.x || from_y >= below.y) continue;
          sum += nodes[std::size_t(from_y) * std::size_t(below.x) + std::size_t(from_x)];
          count += 1.0f;
        }
        next.push_back(sum / count);
      }
    nodes = std::move(next);
  }
}

template <class T>
const Buffer& upload(Workshop& make, const char* name, const std::vector<T>& values) {
  return make.uploaded(name, std::as_bytes(std::span(values)));
}

VkDeviceSize sample_bytes(const TerrainConstants& c, std::uint32_t stride) {
  const glm::ivec2 samples = shared::terrain_samples(c.vertices, stride);
  return VkDeviceSize(samples.x) * VkDeviceSize(samples.y) * sizeof(float);
}

std::uint32_t tile_count(std::uint32_t width, std::uint32_t height) {
  return ((width + kTileColumns - 1) / kTileColumns) * ((height + kTileRows - 1) / kTileRows);
}

std::array<std::uint32_t, 3> groups_of_8(const glm::uvec2& size) { return {(size.x + 7) / 8, (size.y + 7) / 8, 1}; }
std::array<std::uint32_t, 3> groups_of_8(const Image& image) {
  return groups_of_8({image.desc().width, image.desc().height});
}

}  // namespace

TerrainPass::TerrainPass(Workshop& make, const Terrain& terrain, std::uint32_t width, std::uint32_t height)
    : TerrainPass(make, terrain_grid(terrain), width, height) {}

TerrainPass::TerrainPass(Workshop& make, const TerrainGrid& grid, std::uint32_t width, std::uint32_t height)
    : make_(make),
      corner_m_(grid.corner_m),
      spacing_m_(grid.spacing_m),
      constants_(fixed_constants(grid)),
      begin_kernel_(make.compute(shaders::terrain_begin_comp, kRows)),
      distance_kernel_(make.compute(shaders::terrain_distance_comp, kRows)),
      horizon_kernel_(make.compute(shaders::terrain_horizon_comp)),
      openness_kernel_(make.compute(shaders::terrain_openness_comp)),
      view_(make.buffer("terrain_view", sizeof(TerrainConstants))),
      heights_(upload(make, "terrain_heights", grid.height_m)),
      highest_(upload(make, "terrain_highest", pyramid_of_maxima(grid, constants_.levels))),
      nodes_(upload(make, "terrain_slopes", pyramid_of_slopes(grid))),
      horizon_(make.buffer("terrain_horizon", sample_bytes(constants_, constants_.shadow_stride))),
      openness_(make.buffer("terrain_openness", sample_bytes(constants_, constants_.openness_stride))),
      begins_(make.buffer("terrain_begins", VkDeviceSize{tile_count(width, height)} * sizeof(float))),
      distance_(make.image("terrain_distance", {VK_FORMAT_R32_SFLOAT, width, height})),
      radiance_(make.image("terrain_radiance", {VK_FORMAT_R32G32B32A32_SFLOAT, width, height})),
      no_image_(make.image("terrain_no_image", {})) {
  // Whichever a frame needs is ready.
  for (const bool air : {false, true})
    for (const bool cloud_shadow : {false, true}) radiance_kernel(air, cloud_shadow);
}

const ComputeKernel& TerrainPass::radiance_kernel(bool air, bool cloud_shadow) const {
  const SpecConstant constants[] = {{kAir, air}, {kShadow, cloud_shadow}};
  return make_.compute(shaders::terrain_radiance_comp, constants);
}

const Image& TerrainPass::add_distance(FrameBuilder& frame, const Buffer& frame_constants, const glm::dvec3& camera_m,
                                       const glm::dvec3& camera_pattern_m, const HostImages& host) {
  TerrainConstants values = constants_;
  const shared::GridPlace place = shared::grid_place(camera_pattern_m);
  // From so far away nothing of it shows, whatever the float's rounding.
  values.camera = glm::vec2((glm::dvec2(camera_m) - corner_m_) / spacing_m_);
  values.camera_ground_m = glm::vec2(place.grid_m);
  values.ground_origin_index = place.origin_index;
  values.camera_altitude_m = static_cast<float>(camera_m.z);
  values.has_host = host.drawn;
  frame.update("terrain_distance", view_, as_push(values));
  frame.compute({.name = "terrain_distance",
                 .kernel = &begin_kernel_,
                 .bindings = {{0, frame_constants, Access::uniform},
                              {1, view_, Access::storage_read},
                              {2, heights_, Access::words},
                              {3, highest_, Access::words},
                              {4, begins_, Access::storage_write}},
                 .groups = {(tile_count(distance_.desc().width, distance_.desc().height) + 63) / 64, 1, 1}});
  frame.compute({.name = "terrain_distance",
                 .kernel = &distance_kernel_,
                 .bindings = {{0, frame_constants, Access::uniform},
                              {1, view_, Access::storage_read},
                              {2, heights_, Access::words},
                              {3, highest_, Access::words},
                              {4, host.distance, Access::sampled, Sampler::nearest_clamp},
                              {5, distance_, Access::storage_write},
                              {6, begins_, Access::words}},
                 .groups = groups_of_8(distance_)});
  return distance_;
}

void TerrainPass::add_horizon(FrameBuilder& frame, const glm::vec3& sun_direction) {
  struct Push {
    glm::vec2 towards_sun;
    float least;
  };
  // From elsewhere in the world the sun stands lower, by a degree in 111 km; three are kept.
  constexpr float kSlackRad = 0.052f;
  const float across = glm::length(glm::vec2(sun_direction));
  const Push push{across > 1e-6f ? glm::vec2(sun_direction) / across : glm::vec2(1.0f, 0.0f),
                  std::tan(std::atan2(sun_direction.z, across) - kSlackRad)};
  if (frame.stands(&horizon_, as_inputs(push, heights_.id()))) return;
  frame.compute(
      {.name = "terrain_horizon",
       .kernel = &horizon_kernel_,
       .bindings = {{1, view_, Access::storage_read},
                    {2, heights_, Access::words},
                    {3, highest_, Access::words},
                    {4, horizon_, Access::storage_write}},
       .push = as_push(push),
       .groups = groups_of_8(glm::uvec2(shared::terrain_samples(constants_.vertices, constants_.shadow_stride)))});
}

void TerrainPass::add_openness(FrameBuilder& frame) {
  if (frame.stands(&openness_, as_inputs(heights_.id()), Keep::lasting)) return;
  frame.compute(
      {.name = "terrain_openness",
       .kernel = &openness_kernel_,
       .bindings = {{1, view_, Access::storage_read},
                    {2, heights_, Access::words},
                    {3, highest_, Access::words},
                    {4, openness_, Access::storage_write}},
       .groups = groups_of_8(glm::uvec2(shared::terrain_samples(constants_.vertices, constants_.openness_stride)))});
}

const Image& TerrainPass::add_radiance(FrameBuilder& frame, const Buffer& frame_constants,
                                       const glm::vec3& sun_direction, const AtmosphereTables* air,
                                       const Image* cloud_shadow, const HostImages& host) {
  add_horizon(frame, sun_direction);
  add_openness(frame);
  frame.compute({.name = "terrain_radiance",
                 .kernel = &radiance_kernel(air != nullptr, cloud_shadow != nullptr),
                 .bindings = {{0, frame_constants, Access::uniform},
                              {1, view_, Access::storage_read},
                              {2, heights_, Access::words},
                              {3, highest_, Access::words},
                              {4, nodes_, Access::words},
                              {5, horizon_, Access::words},
                              {6, openness_, Access::words},
                              {7, distance_, Access::sampled, Sampler::nearest_clamp},
                              {8, host.distance, Access::sampled, Sampler::nearest_clamp},
                              {9, host.radiance, Access::sampled, Sampler::nearest_clamp},
                              {10, air ? air->transmittance : no_image_, Access::sampled},
                              {11, air ? air->sky_irradiance : no_image_, Access::sampled},
                              {12, cloud_shadow ? *cloud_shadow : no_image_, Access::sampled},
                              {13, radiance_, Access::storage_write}},
                 .groups = groups_of_8(radiance_)});
  return radiance_;
}

}  // namespace nephele
