// Particle generation as the frame sees it: the same every time, safe past its capacity, and a visible list that
// leaves out nothing that shows.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "shared/cell_particles.h"
#include "shared/ellipsoid.h"
#include "shared/in_view.h"
#include "tests/support/field_run.h"
#include "tests/support/shapes.h"

using namespace nephele;
using nephele::shared::CloudField;
using nephele::shared::FieldFrame;
using nephele::shared::FrameConstants;
using nephele::shared::Particle;
using nephele::test::cloud_frame;
using nephele::test::cloud_view;
using nephele::test::FieldRun;
using nephele::test::ParticleRun;
using nephele::test::same_bytes;

namespace {

FieldFrame small_frame(const CameraState& camera = {}) {
  FieldFrame frame = cloud_frame(camera);
  frame.field.ring_size_cells = 40;
  return frame;
}

}  // namespace

TEST_CASE("a frame depends on its camera alone, not on earlier frames") {
  CameraState here, there;
  there.position_m = {52000.0, -800.0, 2600.0};
  there.yaw_rad = 2.0;
  FieldRun flown(small_frame()), fresh(small_frame());
  const ParticleRun first = flown.run(small_frame(here), cloud_view(here));
  flown.run(small_frame(there), cloud_view(there));
  const ParticleRun back = flown.run(small_frame(here), cloud_view(here));
  const ParticleRun anew = fresh.run(small_frame(here), cloud_view(here));
  CHECK(first.counters.particle_count > 1000);
  CHECK(same_bytes(first.particles, back.particles));
  CHECK(same_bytes(first.particles, anew.particles));
  CHECK(first.visible == back.visible);
  CHECK(first.visible == anew.visible);
}

TEST_CASE("kept cells are found anew when anything of the field changes that they depend on") {
  // Each change after a frame of the unchanged field must give what a fresh source gives.
  const auto change = [](int member, CloudField& field) {
    switch (member) {
      case 0:
        field.seed = 6;
        return "seed";
      case 1:
        field.coverage = 0.55f;
        return "coverage";
      case 2:
        field.base_m = 900.0f;
        return "base_m";
      case 3:
        field.thickness_m = 700.0f;
        return "thickness_m";
      case 4:
        field.extinction_per_m = 0.004f;
        return "extinction_per_m";
      case 5:
        field.layer_count = 3;
        return "layer_count";
      case 6:
        field.crown_per_cell = 1.0f;
        return "crown_per_cell";
      case 7:
        field.growth_turns = 0.3f;
        return "growth_turns";
      case 8:
        field.origin_index.x += 1;
        return "origin_index";
      default:
        field.camera_cell.y += 1;
        return "camera_cell";
    }
  };
  const FieldFrame plain = small_frame();
  FieldRun kept(plain);
  const ParticleRun before = kept.run(plain);
  for (int member = 0; member < 10; ++member) {
    FieldFrame changed = plain;
    const std::string what = change(member, changed.field);
    CAPTURE(what);
    const ParticleRun after = kept.run(changed);
    FieldRun fresh(changed);
    CHECK(same_bytes(after.particles, fresh.run(changed).particles));
    CHECK(!same_bytes(after.particles, before.particles));
    CHECK(same_bytes(kept.run(plain).particles, before.particles));
  }
}

TEST_CASE("past the capacity the farthest cells are left out and counted; what stays does not change") {
  const FieldFrame frame = small_frame();
  FieldRun roomy(frame);
  const ParticleRun all = roomy.run(frame);
  REQUIRE(all.counters.particle_demand == all.counters.particle_count);
  const auto cell_first = roomy.grid().cell_first.read_vector<std::uint32_t>(shared::grid_cell_count(frame.field) + 1);
  const auto cell_of = roomy.grid().particle_cell.read_vector<std::uint32_t>(all.counters.particle_count);
  for (const std::uint32_t capacity :
       {1u, 64u, 1000u, all.counters.particle_demand - 1u, all.counters.particle_demand}) {
    CAPTURE(capacity);
    FieldRun tight(frame, capacity);
    const ParticleRun some = tight.run(frame);
    CHECK(some.counters.particle_demand == all.counters.particle_demand);
    CHECK(some.records[0].demand == all.counters.particle_demand);
    CHECK(some.records[0].count == some.counters.particle_count);
    REQUIRE(some.counters.particle_count <= capacity);
    CHECK(some.counters.particle_groups == glm::uvec3((some.counters.particle_count + 63) / 64, 1, 1));
    CHECK(some.counters.visible_count <= some.counters.particle_count);

    // What stays: the particles of all bins that fit, counted here from the cells.
    std::vector<std::uint32_t> in_bin(shared::kDistanceBins);
    for (std::uint32_t cell = 0; cell + 1 < cell_first.size(); ++cell)
      in_bin[shared::distance_bin(frame, shared::grid_cell(frame.field, cell))] +=
          cell_first[cell + 1] - cell_first[cell];
    std::uint32_t kept_bins = 0, kept = 0;
    while (kept_bins < shared::kDistanceBins && kept + in_bin[kept_bins] <= capacity) kept += in_bin[kept_bins++];
    std::vector<Particle> expected;
    for (std::size_t i = 0; i < all.particles.size(); ++i)
      if (shared::distance_bin(frame, shared::grid_cell(frame.field, cell_of[i])) < kept_bins)
        expected.push_back(all.particles[i]);
    CHECK(same_bytes(some.particles, expected));
  }
}

TEST_CASE("empty skies") {
  FieldFrame frame = small_frame();
  const auto check_empty = [](const ParticleRun& result) {
    CHECK(result.counters.particle_demand == 0);
    CHECK(result.counters.particle_groups == glm::uvec3(0, 1, 1));
    CHECK(result.counters.visible_demand == 0);
    CHECK(result.counters.draw == glm::uvec4(0, 1, 0, 0));
  };
  SUBCASE("no source") {
    check_empty(
        test::SourcesRun([](Workshop&) { return std::vector<std::unique_ptr<CloudSource>>(); }).run(cloud_view()));
  }
  SUBCASE("no coverage") {
    frame.field.coverage = 0.0f;
    check_empty(FieldRun(frame).run(frame));
  }
  SUBCASE("a view distance of 1 m") {
    frame.field.view_distance_m = 1.0f;
    shared::place_camera(frame, {{0, 0}, {500.0f, 500.0f, 1500.0f}});
    FieldRun field(frame);
    check_empty(field.run(frame));
    CHECK(field.counters().cell_count == 0);
  }
  SUBCASE("looking up from above") {
    CameraState up;
    up.position_m = {0, 0, 30000};
    up.pitch_rad = 1.5;
    frame = small_frame(up);
    const ParticleRun result = FieldRun(frame).run(frame, cloud_view(up));
    CHECK(result.counters.particle_count > 0);
    CHECK(result.counters.visible_count == 0);
    CHECK(result.counters.visible_groups == glm::uvec3(0, 1, 1));
    CHECK(result.counters.draw == glm::uvec4(0, 1, 0, 0));
  }
}

TEST_CASE("extreme settings stay finite and within the capacity") {
  for (const float thickness_m : {1.0f, 15000.0f})
    for (const float coverage : {0.05f, 1.0f})
      for (const double x : {0.0, 1e7, -94208.0 * 1.5}) {
        CameraState camera;
        camera.position_m = {x, 184.0 * 8, 0.1};  // on cell corners, 10 cm above the ground
        FieldFrame frame = small_frame(camera);
        frame.field.thickness_m = thickness_m;
        frame.field.coverage = coverage;
        CAPTURE(thickness_m);
        CAPTURE(coverage);
        CAPTURE(x);
        const ParticleRun result = FieldRun(frame).run(frame, cloud_view(camera));
        CHECK(result.counters.particle_demand == result.counters.particle_count);
        CHECK(result.counters.particle_count > 10);
        std::uint32_t bad = 0;
        for (const Particle& p : result.particles)
          bad += !(std::isfinite(p.center_m.x + p.center_m.y + p.center_m.z + shared::shape_determinant(p.shape) +
                                 p.base_m + p.top_m) &&
                   p.extinction_per_m >= 0.0f &&
                   p.extinction_per_m <= shared::kMaxGain * shared::kAdiabaticMost * frame.field.extinction_per_m);
        CHECK(bad == 0);
      }
}

TEST_CASE("the sky over a place is the same 10 000 km out") {
  // Moving by whole units with the seed kept changes the clouds; the counts' scale must not.
  CameraState near_camera, far_camera;
  far_camera.position_m = {1e7, 1e7, 1500.0};
  const FieldFrame near_frame = small_frame(near_camera), far_frame = small_frame(far_camera);
  FieldRun field(near_frame);
  const ParticleRun a = field.run(near_frame, cloud_view(near_camera)),
                    b = field.run(far_frame, cloud_view(far_camera));
  CHECK(b.counters.particle_count > a.counters.particle_count / 3);
  CHECK(b.counters.particle_count < a.counters.particle_count * 3);
  // A shift of the origin that leaves the world place alone gives the same particles, up to rounding.
  FieldFrame shifted = near_frame;
  shared::place_camera(shifted,
                       {near_frame.field.origin_index + glm::ivec2(1, -1),
                        near_frame.camera_grid_m + glm::vec3(-shared::kOriginUnitM, shared::kOriginUnitM, 0.0f)});
  const ParticleRun c = field.run(shifted, cloud_view(near_camera));
  REQUIRE(c.counters.particle_count > 0);
  CHECK(std::abs(static_cast<int>(c.counters.particle_count) - static_cast<int>(a.counters.particle_count)) < 50);
  std::size_t matched = 0, j = 0;
  for (const Particle& p : a.particles) {
    for (std::size_t k = j; k < std::min(j + 40, c.particles.size()); ++k)
      if (c.particles[k].id == p.id) {
        matched += glm::length(c.particles[k].center_m - p.center_m) < 5.0f;
        j = k + 1;
        break;
      }
  }
  CHECK(matched > a.particles.size() * 98 / 100);
}

TEST_CASE("the visible list leaves out nothing that shows, and little that does not") {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  FieldRun field(small_frame());
  for (int view = 0; view < 12; ++view) {
    CameraState camera;
    camera.position_m = {2e4 * unit(random), 2e4 * unit(random),
                         view % 3 == 0 ? 1500.0 : 6000.0 + 5900.0 * unit(random)};
    camera.yaw_rad = 3.1 * unit(random);
    camera.pitch_rad = view == 1 ? 1.5707963 : view == 2 ? -1.5707963 : 0.6 * unit(random);
    camera.roll_rad = unit(random);
    const FrameConstants constants = cloud_view(camera);
    CAPTURE(view);
    const ParticleRun result = field.run(small_frame(camera), constants);
    std::vector<bool> listed(result.particles.size());
    for (const std::uint32_t index : result.visible) listed[index] = true;
    for (std::size_t k = 1; k < result.visible.size(); ++k) REQUIRE(result.visible[k - 1] < result.visible[k]);

    // Points on each ellipsoid that lie in the picture and above the horizon prove that it shows.
    std::uint32_t missed = 0, zero = 0, showing = 0;
    for (std::size_t i = 0; i < result.particles.size(); ++i) {
      const Particle& p = result.particles[i];
      if (p.extinction_per_m <= 0.0f) {
        zero += listed[i];
        continue;
      }
      bool shows = false;
      for (int k = 0; k < 40 && !shows; ++k) {
        const glm::dvec3 direction = glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)));
        const glm::vec3 point = p.center_m + glm::vec3(test::matrix_of(p.shape) * direction);
        const glm::vec4 clip = constants.clip_from_render * glm::vec4(point, 1.0f);
        if (clip.w <= 0.0f || std::fabs(clip.x) > clip.w || std::fabs(clip.y) > clip.w) continue;
        shows = true;
        for (int step = 1; step <= 64; ++step)
          if (shared::altitude_m(point * (static_cast<float>(step) / 64.0f), constants.camera_grid_m.z) < 0.0f)
            shows = false;
      }
      missed += shows && !listed[i];
      showing += shows;
    }
    CHECK(missed == 0);
    CHECK(zero == 0);
    CHECK(result.visible.size() <= showing * 3 / 2 + 100);  // the samples miss some that only touch the frame
  }
}

TEST_CASE("the ground hides what is behind it, with a margin, unless there is none") {
  FrameConstants constants = cloud_view();
  constants.camera_grid_m.z = 100.0f;
  CameraState camera;
  camera.pitch_rad = 0.0;
  constants.clip_from_render = camera_matrices(camera, 1.0).clip_from_render;
  // 100 m above the ground the horizon is 35.7 km away; at 150 km it hides (150 - 35.7)^2 / 2R = 1027 m.
  const auto at = [&](float altitude, float radius) {
    Particle p{};
    p.center_m = shared::render_from_grid(
        glm::vec3(0.0f, 150000.0f, altitude) + glm::vec3(constants.camera_grid_m.x, constants.camera_grid_m.y, 0.0f),
        constants.camera_grid_m);
    p.shape = test::ball(radius);
    p.extinction_per_m = 0.1f;
    return p;
  };
  CHECK(shared::particle_visible(constants, at(1100.0f, 10.0f)));
  CHECK(!shared::particle_visible(constants, at(900.0f, 10.0f)));
  CHECK(shared::particle_visible(constants, at(900.0f, 200.0f)));
  constants.ground_enabled = 0;
  CHECK(shared::particle_visible(constants, at(900.0f, 10.0f)));
}
