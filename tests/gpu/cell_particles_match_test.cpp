// The grid and particle kernels against the shared headers on the CPU, which evaluate every feature where it is asked
// for instead of looking it up.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "passes/sources/cell_source.h"
#include "shared/cell_particles.h"
#include "tests/support/cloud_frame.h"
#include "tests/support/test_device.h"

using namespace nephele;
using nephele::shared::FrameConstants;
using nephele::shared::FrameCounters;
using nephele::shared::Particle;
using nephele::test::cloud_frame;
using nephele::test::test_device;
using nephele::test::test_kernels;

namespace {

struct Generated {
  FrameCounters counters;
  std::vector<std::uint32_t> cell_first;
  std::vector<Particle> particles;
};

Generated generate(const FrameConstants& constants) {
  Workshop make_pass(test_kernels());
  CloudParticles pass(make_pass, constants, {});
  Buffer buffer(test_device(), "frame_constants", sizeof(FrameConstants));
  FrameBuilder frame(test_device());
  frame.update("frame_constants", buffer, as_push(constants));
  const CloudParticles::Outputs outputs = pass.add(frame, constants, buffer, glm::dvec3(0));
  FrameExecutor(test_device()).run(frame);
  Generated result;
  result.counters = outputs.counters.read_vector<FrameCounters>(1)[0];
  result.cell_first = pass.grid().cell_first.read_vector<std::uint32_t>(shared::grid_cell_count(constants) + 1);
  result.particles = outputs.particles.read_vector<Particle>(result.counters.particle_count);
  return result;
}

void compare(const FrameConstants& constants) {
  const Generated gpu = generate(constants);
  REQUIRE(gpu.counters.particle_demand == gpu.counters.particle_count);
  const shared::CloudParams params = shared::cloud_params(constants);
  std::uint32_t cells = 0, differing_cells = 0, particles = 0, differing_particles = 0;
  for (std::uint32_t i = 0; i < shared::grid_cell_count(constants); ++i) {
    const shared::GridCell cell = shared::grid_cell(constants, i);
    const std::uint32_t count = gpu.cell_first[i + 1] - gpu.cell_first[i];
    shared::CellCloud cloud{};
    if (shared::cell_weight(constants, cell) > 0.0f) cloud = shared::cell_cloud(constants, params, cell);
    cells += cloud.parts.levels > 0 || count > 0;
    if (shared::particle_count(cloud.parts) != count) {
      ++differing_cells;
      continue;
    }
    for (std::uint32_t slot = 0; slot < count; slot += 3) {
      const Particle& a = gpu.particles[gpu.cell_first[i] + slot];
      const Particle b =
          shared::render_particle(constants, cell, shared::cell_particle(constants, params, cell, cloud, slot));
      ++particles;
      CHECK(a.id == b.id);
      CHECK(a.flags == b.flags);
      const float scale = glm::max(b.radius_m.x, b.radius_m.z);
      const bool near = glm::length(a.center_m - b.center_m) < 0.02f * scale + 1.0f &&
                        glm::length(a.radius_m - b.radius_m) < 0.02f * scale &&
                        std::fabs(a.extinction_per_m - b.extinction_per_m) < 0.02f * constants.extinction_per_m &&
                        std::fabs(a.base_m - b.base_m) < 0.5f &&
                        std::fabs(a.top_m - b.top_m) < 0.02f * constants.thickness_m;
      differing_particles += !near;
    }
  }
  MESSAGE(cells, " cells, ", differing_cells, " differ; ", particles, " particles compared, ", differing_particles,
          " differ");
  CHECK(cells > 500);
  CHECK(gpu.counters.cell_count <= cells);
  CHECK(gpu.counters.cell_count >= cells - differing_cells);
  // Rounding decides where a count's threshold is met, and on steep walls it moves the height.
  CHECK(differing_cells <= cells / 100);
  CHECK(differing_particles <= particles / 100);
}

}  // namespace

TEST_CASE("particles on the device are those of the shared headers") { compare(cloud_frame()); }

TEST_CASE("also under a deck, far out and with another grid") {
  CameraState camera;
  camera.position_m = {1e7 + 33.0, -4.2e6, 800.0};
  FrameConstants constants = cloud_frame(camera);
  constants.coverage = 0.9f;
  constants.ring_count = 2;
  constants.ring_size_cells = 56;
  constants.layer_count = 3;
  constants.crown_per_cell = 1.2f;
  constants.thickness_m = 700.0f;
  compare(constants);
}
