// The grid and particle kernels against the shared headers on the CPU, which evaluate every feature where it is asked
// for instead of looking it up.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "shared/cell_particles.h"
#include "tests/support/field_run.h"

using namespace nephele;
using nephele::shared::FieldFrame;
using nephele::shared::FrameCounters;
using nephele::shared::Particle;
using nephele::test::cloud_frame;
using nephele::test::FieldRun;

namespace {

struct Generated {
  FrameCounters counters;
  shared::FieldCounters field;
  std::vector<std::uint32_t> cell_first;
  std::vector<Particle> particles;
};

Generated generate(const FieldFrame& frame) {
  FieldRun field(frame);
  const test::ParticleRun run = field.run(frame);
  return {run.counters, field.counters(),
          field.grid().cell_first.read_vector<std::uint32_t>(shared::grid_cell_count(frame.field) + 1), run.particles};
}

void compare(const FieldFrame& frame) {
  const Generated gpu = generate(frame);
  REQUIRE(gpu.counters.particle_demand == gpu.counters.particle_count);
  const shared::CloudParams params = shared::cloud_params(frame.field);
  std::uint32_t cells = 0, differing_cells = 0, particles = 0, differing_particles = 0;
  for (std::uint32_t i = 0; i < shared::grid_cell_count(frame.field); ++i) {
    const shared::GridCell cell = shared::grid_cell(frame.field, i);
    const std::uint32_t count = gpu.cell_first[i + 1] - gpu.cell_first[i];
    shared::CellCloud cloud{};
    if (shared::cell_weight(frame, cell) > 0.0f) cloud = shared::cell_cloud(frame.field, params, cell);
    cells += cloud.slots != 0 || count > 0;
    if (shared::particle_count(cloud) != count) {
      ++differing_cells;
      continue;
    }
    for (std::uint32_t slot = 0; slot < count; slot += 3) {
      const Particle& a = gpu.particles[gpu.cell_first[i] + slot];
      const Particle b =
          shared::render_particle(frame, cell, shared::cell_particle(frame.field, params, cell, cloud, slot), 0u);
      ++particles;
      CHECK(a.id == b.id);
      // How torn it is is rounded to steps, of which rounding may leave the two one apart.
      const std::uint32_t torn = shared::kMostTorn << shared::kParticleTornShift;
      CHECK((a.flags & ~torn) == (b.flags & ~torn));
      CHECK(std::abs(static_cast<int>(a.flags & torn) - static_cast<int>(b.flags & torn)) <=
            1 << shared::kParticleTornShift);
      const float scale = shared::longest_axis_at_most_m(b.shape);
      const bool near = glm::length(a.center_m - b.center_m) < 0.02f * scale + 1.0f &&
                        glm::length(a.shape.diagonal_m - b.shape.diagonal_m) < 0.02f * scale &&
                        glm::length(a.shape.off_diagonal_m - b.shape.off_diagonal_m) < 0.02f * scale &&
                        std::fabs(a.extinction_per_m - b.extinction_per_m) < 0.02f * frame.field.extinction_per_m &&
                        std::fabs(a.base_m - b.base_m) < 0.5f &&
                        std::fabs(a.top_m - b.top_m) < 0.02f * frame.field.thickness_m;
      differing_particles += !near;
    }
  }
  MESSAGE(cells, " cells, ", differing_cells, " differ; ", particles, " particles compared, ", differing_particles,
          " differ");
  CHECK(cells > 500);
  CHECK(gpu.field.cell_count <= cells);
  CHECK(gpu.field.cell_count >= cells - differing_cells);
  // Rounding decides where a count's threshold is met, and on steep walls it moves the height.
  CHECK(differing_cells <= cells / 100);
  CHECK(differing_particles <= particles / 100);
}

}  // namespace

TEST_CASE("particles on the device are those of the shared headers") { compare(cloud_frame()); }

TEST_CASE("also under a deck, far out and with another grid") {
  CameraState camera;
  camera.position_m = {1e7 + 33.0, -4.2e6, 800.0};
  FieldFrame frame = cloud_frame(camera);
  frame.field.coverage = 0.9f;
  frame.field.ring_count = 2;
  frame.field.ring_size_cells = 56;
  frame.field.layer_count = 3;
  frame.field.crown_per_cell = 1.2f;
  frame.field.thickness_m = 700.0f;
  compare(frame);
}
