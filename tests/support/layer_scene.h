// The cloud layer without a renderer: homogeneous ellipsoids with given radiance, drawn by any backend and compared
// with the integral of their chords.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "engine/camera.h"
#include "passes/layer/cloud_layer.h"
#include "passes/layer/shading_volumes.h"
#include "shared/ellipsoid.h"
#include "shared/flat_base.h"
#include "shared/light_lattice.h"
#include "shared/screen_bounds.h"
#include "tests/support/blend_oracle.h"
#include "tests/support/test_device.h"

namespace nephele::test {

// One-texel tables: homogeneous emissive particles never look into them.
inline Tables blank_tables() {
  Tables tables;
  tables.optical_depth.name = "optical_depth";
  tables.optical_depth.array = {ElementType::float16, {16, 4, 4, 2}, std::vector<std::byte>(4 * 256)};
  tables.multiple_scattering.name = "multiple_scattering";
  tables.multiple_scattering.array = {ElementType::float16, {1, 1, 1, 4}, std::vector<std::byte>(8)};
  tables.near_beam.name = "near_beam";
  tables.near_beam.array = {ElementType::float16, {1, 1, 1, 1}, std::vector<std::byte>(2)};
  tables.mean_fill = 0.43f;
  return tables;
}

inline shared::Particle emissive(glm::vec3 center_m, glm::vec3 radius_m, float extinction_per_m, glm::vec3 radiance) {
  shared::Particle p{};
  p.center_m = center_m;
  p.extinction_per_m = extinction_per_m;
  p.radiance_per_sr = radiance;
  p.shape = shared::upright_shape(radius_m, 0.3f);
  p.orientation = shared::pack_orientation({0, 0, 0, 1});
  p.flags = shared::kParticleHomogeneous | shared::kParticleEmissive;
  p.base_m = shared::kNoBaseM;
  return p;
}

struct LayerSize {
  std::uint32_t width = 96, height = 64;
};

struct Layer {
  std::vector<glm::vec4> color;
  std::vector<float> depth;
  std::uint64_t pairs_shaded = 0, pairs_lost = 0, rays_cut_short = 0;
  double shade_ms = 0;  // shading and blending, lists and resolve included
};

inline shared::FrameConstants layer_constants(const CameraState& camera, LayerSize size) {
  shared::FrameConstants constants{};
  const CameraMatrices matrices = camera_matrices(camera, double(size.width) / size.height);
  constants.clip_from_render = matrices.clip_from_render;
  constants.render_from_clip = matrices.render_from_clip;
  constants.camera_grid_m = {0, 0, 1000};
  constants.sun_direction = {0, 0, 1};
  constants.image_size_px = constants.layer_size_px = {size.width, size.height};
  constants.scale = 1;
  constants.detail_enabled = 1;
  return constants;
}

// Farthest first, as ViewSort does it.
inline std::vector<std::uint32_t> draw_order(const std::vector<shared::Particle>& particles, BlendMode blend) {
  std::vector<float> distance_m;
  for (const shared::Particle& p : particles) {
    const float center_m = glm::length(p.center_m);
    const glm::vec3 towards = p.center_m / std::max(center_m, 1e-6f);
    distance_m.push_back(blend == BlendMode::exact
                             ? shared::near_bound_m(p.center_m, shared::ellipsoid_extent(p.shape, towards))
                             : center_m);
  }
  std::vector<std::uint32_t> order(particles.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return distance_m[a] > distance_m[b]; });
  return order;
}

// scene_m: distance of a host's scene in every pixel, if there is one. march_steps > 0: by the ray marcher. baked:
// needed by particles that are not homogeneous, unless they are marched.
inline Layer draw_layer(const std::vector<shared::Particle>& particles, const CameraState& camera, Backend backend,
                        BlendMode blend = BlendMode::volume, LayerSize size = {}, int runs = 1,
                        const std::vector<float>* scene_m = nullptr, std::uint32_t march_steps = 0,
                        const Tables* baked = nullptr) {
  Device& device = test_device();
  const GpuTables tables(device, baked ? *baked : blank_tables());
  const std::uint32_t count = static_cast<std::uint32_t>(particles.size());
  const std::uint32_t room = std::max(1u, count);
  Buffer constants(device, "constants", sizeof(shared::FrameConstants)),
      particle_buffer(device, "particles", VkDeviceSize{room} * sizeof(shared::Particle)),
      visible(device, "visible", VkDeviceSize{room} * 4), order(device, "order", VkDeviceSize{room} * 4),
      lights(device, "lights", VkDeviceSize{room} * sizeof(shared::ParticleLight)),
      counters(device, "counters", sizeof(shared::FrameCounters)),
      records(device, "source_records", sizeof(shared::SourceRecord));
  Image sky(device, "sky", {VK_FORMAT_R32G32B32A32_SFLOAT, 1, 1});
  const Image no_radiance(device, "no_radiance", {.force_3d = true});
  const Buffer no_lattice(device, "no_lattice", sizeof(shared::LightLattice));
  shared::FrameConstants values = layer_constants(camera, size);
  values.host_scene = scene_m != nullptr;
  constants.write_vector(std::vector{values});
  Image host(device, "host", {VK_FORMAT_R32_SFLOAT, scene_m ? size.width : 1, scene_m ? size.height : 1});
  if (scene_m) host.write(std::as_bytes(std::span(*scene_m)));
  if (count > 0) {
    std::vector<std::uint32_t> slots(count);
    std::iota(slots.begin(), slots.end(), 0u);
    particle_buffer.write_vector(particles);
    visible.write_vector(slots);
    order.write_vector(draw_order(particles, march_steps > 0 ? BlendMode::exact : blend));
  }
  shared::FrameCounters counts{};
  counts.visible_count = count;
  counts.visible_groups = {(count + 63) / 64, 1, 1};
  counts.draw = {6 * count, 1, 0, 0};

  Workshop make(test_kernels());
  const ShadingVolumes volumes(test_kernels(), TableParameters{}.particle_seed);
  CloudLayer layer(make, tables, {size.width, size.height, 1}, backend, blend, room, {.light_field = false},
                   march_steps);
  FrameExecutor executor(device);
  Layer result{std::vector<glm::vec4>(size.width * size.height), std::vector<float>(size.width * size.height)};
  result.shade_ms = 1e30;
  for (int run = 0; run < runs; ++run) {
    counters.write_vector(std::vector{counts});
    FrameBuilder frame(device);
    layer.add(frame, {constants,
                      particle_buffer,
                      visible,
                      order,
                      lights,
                      counters,
                      records,
                      sky,
                      {tables, volumes, no_radiance},
                      no_lattice,
                      host});
    executor.run(frame);
    double ms = 0;
    for (const PassTime& pass : executor.pass_times())
      if (pass.name == "shade_blend" || pass.name == "screen_tiles" || pass.name == "resolve") ms += pass.gpu_ms;
    result.shade_ms = std::min(result.shade_ms, ms);
  }
  layer.color()->read(std::as_writable_bytes(std::span(result.color)));
  layer.depth()->read(std::as_writable_bytes(std::span(result.depth)));
  const shared::FrameCounters after = counters.read_vector<shared::FrameCounters>(1)[0];
  result.pairs_shaded = after.pairs_shaded;
  result.pairs_lost = after.screen_pair_demand - after.screen_pair_count;
  result.rays_cut_short = after.rays_cut_short;
  return result;
}

inline glm::dvec3 pixel_ray(const CameraState& camera, LayerSize size, std::uint32_t x, std::uint32_t y) {
  const CameraMatrices matrices = camera_matrices(camera, double(size.width) / size.height);
  const glm::dvec4 ndc((x + 0.5) / size.width * 2 - 1, (y + 0.5) / size.height * 2 - 1, 1, 1);
  return glm::normalize(glm::dvec3(glm::dmat4(matrices.render_from_clip) * ndc));
}

inline Layer oracle_layer(const std::vector<shared::Particle>& particles, const CameraState& camera,
                          LayerSize size = {}, const std::vector<float>* scene_m = nullptr) {
  Layer truth;
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x) {
      std::vector<OracleSegment> segments = chords(particles, pixel_ray(camera, size, x, y));
      if (scene_m)
        for (OracleSegment& segment : segments)
          segment.far_m = std::min(segment.far_m, double((*scene_m)[y * size.width + x]));
      const OracleRay ray = integrate(segments);
      truth.color.push_back(glm::vec4(ray.color));
      truth.depth.push_back(static_cast<float>(ray.first_m));
    }
  return truth;
}

struct LayerError {
  double failing = 0;  // fraction of pixels off by more than the tolerance in any channel
  double worst = 0;
  double rmse = 0;  // over all channels
};

inline LayerError layer_error(const Layer& a, const Layer& b, double tolerance) {
  LayerError error;
  for (std::size_t i = 0; i < a.color.size(); ++i) {
    const glm::dvec4 off = glm::abs(glm::dvec4(a.color[i]) - glm::dvec4(b.color[i]));
    const double most = std::max({off.x, off.y, off.z, off.w});
    error.failing += !(most <= tolerance);
    error.worst = std::isnan(most) ? most : std::max(error.worst, most);
    error.rmse += glm::dot(off, off) / 4;
  }
  error.failing /= double(a.color.size());
  error.rmse = std::sqrt(error.rmse / double(a.color.size()));
  return error;
}

// The largest change between two pictures in any channel that the truth does not make as well. (An opaque silhouette
// moves as the square root of the distance: the truth itself has no bound.)
inline double step_error(const Layer& before, const Layer& after, const Layer& truth_before, const Layer& truth_after) {
  double most = 0;
  for (std::size_t i = 0; i < before.color.size(); ++i) {
    const glm::vec4 off = glm::abs((after.color[i] - before.color[i]) - (truth_after.color[i] - truth_before.color[i]));
    most = std::max(most, double(std::max({off.x, off.y, off.z, off.w})));
  }
  return most;
}

inline const CameraState kLevelCamera{.position_m = {0, 0, 1000}, .yaw_rad = 0, .pitch_rad = 0};

}  // namespace nephele::test
