// Particle generation as the frame sees it: the same every time, safe past its capacity, and a visible list that
// leaves out nothing that shows.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "passes/sources/cell_source.h"
#include "shared/cell_particles.h"
#include "shared/ellipsoid.h"
#include "shared/in_view.h"
#include "shared/listed_particles.h"
#include "shared/ring_grid.h"
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

struct Run {
  FrameCounters counters;
  std::vector<Particle> particles;
  std::vector<std::uint32_t> visible;
};

Run run(CloudParticles& pass, const FrameConstants& constants, const glm::dvec3& camera_world_m = glm::dvec3(0)) {
  Buffer buffer(test_device(), "frame_constants", sizeof(FrameConstants));
  FrameBuilder frame(test_device());
  frame.update("frame_constants", buffer, as_push(constants));
  const CloudParticles::Outputs outputs = pass.add(frame, constants, buffer, camera_world_m);
  FrameExecutor(test_device()).run(frame);
  Run result{outputs.counters.read_vector<FrameCounters>(1)[0], {}, {}};
  result.particles = outputs.particles.read_vector<Particle>(result.counters.particle_count);
  result.visible = outputs.visible.read_vector<std::uint32_t>(result.counters.visible_count);
  return result;
}

bool same_bytes(const std::vector<Particle>& a, const std::vector<Particle>& b) {
  if (a.size() != b.size()) return false;
  return a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Particle)) == 0;
}

FrameConstants small_frame(const CameraState& camera = {}) {
  FrameConstants constants = cloud_frame(camera);
  constants.ring_size_cells = 40;
  return constants;
}

ListedParticle listed_at(const glm::dvec3& center_m) {
  ListedParticle particle;
  particle.center_m = center_m;
  particle.radius_m = {100.0f, 80.0f, 60.0f};
  particle.yaw_rad = 0.5;
  particle.density = 0.5f;
  return particle;
}

}  // namespace

TEST_CASE("a frame depends on its camera alone, not on earlier frames") {
  CameraState here, there;
  there.position_m = {52000.0, -800.0, 2600.0};
  there.yaw_rad = 2.0;
  Workshop make_flown(test_kernels());
  CloudParticles flown(make_flown, small_frame(), {});
  Workshop make_fresh(test_kernels());
  CloudParticles fresh(make_fresh, small_frame(), {});
  const Run first = run(flown, small_frame(here));
  run(flown, small_frame(there));
  const Run back = run(flown, small_frame(here));
  const Run anew = run(fresh, small_frame(here));
  CHECK(first.counters.particle_count > 1000);
  CHECK(same_bytes(first.particles, back.particles));
  CHECK(same_bytes(first.particles, anew.particles));
  CHECK(first.visible == back.visible);
  CHECK(first.visible == anew.visible);
}

TEST_CASE("past the capacity the farthest cells are left out and counted; what stays does not change") {
  const FrameConstants constants = small_frame();
  Workshop make_roomy(test_kernels());
  CloudParticles roomy(make_roomy, constants, {});
  const Run all = run(roomy, constants);
  REQUIRE(all.counters.particle_demand == all.counters.particle_count);
  const auto cell_first = roomy.grid().cell_first.read_vector<std::uint32_t>(shared::grid_cell_count(constants) + 1);
  const auto cell_of = roomy.grid().particle_cell.read_vector<std::uint32_t>(all.counters.particle_count);
  for (const std::uint32_t capacity :
       {1u, 64u, 1000u, all.counters.particle_demand - 1u, all.counters.particle_demand}) {
    CAPTURE(capacity);
    Workshop make_tight(test_kernels());
    CloudParticles tight(make_tight, constants, {}, capacity);
    const Run some = run(tight, constants);
    CHECK(some.counters.particle_demand == all.counters.particle_demand);
    REQUIRE(some.counters.particle_count <= capacity);
    CHECK(some.counters.particle_groups == glm::uvec3((some.counters.particle_count + 63) / 64, 1, 1));
    CHECK(some.counters.visible_count <= some.counters.particle_count);

    // What stays: the particles of all bins that fit, counted here from the cells.
    std::vector<std::uint32_t> in_bin(shared::kDistanceBins);
    for (std::uint32_t cell = 0; cell + 1 < cell_first.size(); ++cell)
      in_bin[shared::distance_bin(constants, shared::grid_cell(constants, cell))] +=
          cell_first[cell + 1] - cell_first[cell];
    std::uint32_t kept_bins = 0, kept = 0;
    while (kept_bins < shared::kDistanceBins && kept + in_bin[kept_bins] <= capacity) kept += in_bin[kept_bins++];
    std::vector<Particle> expected;
    for (std::size_t i = 0; i < all.particles.size(); ++i)
      if (shared::distance_bin(constants, shared::grid_cell(constants, cell_of[i])) < kept_bins)
        expected.push_back(all.particles[i]);
    CHECK(same_bytes(some.particles, expected));
  }
}

TEST_CASE("empty skies") {
  FrameConstants constants = small_frame();
  SUBCASE("no coverage") { constants.coverage = 0.0f; }
  SUBCASE("clouds off") { constants.clouds_enabled = 0; }
  SUBCASE("a view distance of 1 m") {
    constants.view_distance_m = 1.0f;
    shared::place_camera(constants, {{0, 0}, {500.0f, 500.0f, 1500.0f}});
  }
  SUBCASE("looking up from above") {
    CameraState up;
    up.position_m = {0, 0, 30000};
    up.pitch_rad = 1.5;
    constants = small_frame(up);
    Workshop make_pass(test_kernels());
    CloudParticles pass(make_pass, constants, {});
    const Run result = run(pass, constants);
    CHECK(result.counters.particle_count > 0);
    CHECK(result.counters.visible_count == 0);
    CHECK(result.counters.visible_groups == glm::uvec3(0, 1, 1));
    CHECK(result.counters.draw == glm::uvec4(0, 1, 0, 0));
    return;
  }
  Workshop make_pass(test_kernels());
  CloudParticles pass(make_pass, constants, {});
  const Run result = run(pass, constants);
  CHECK(result.counters.particle_demand == 0);
  CHECK(result.counters.cell_count == 0);
  CHECK(result.counters.particle_groups == glm::uvec3(0, 1, 1));
  CHECK(result.counters.visible_demand == 0);
  CHECK(result.counters.draw == glm::uvec4(0, 1, 0, 0));
}

TEST_CASE("extreme settings stay finite and within the capacity") {
  for (const float thickness_m : {1.0f, 15000.0f})
    for (const float coverage : {0.05f, 1.0f})
      for (const double x : {0.0, 1e7, -94208.0 * 1.5}) {
        CameraState camera;
        camera.position_m = {x, 184.0 * 8, 0.1};  // on cell corners, 10 cm above the ground
        FrameConstants constants = small_frame(camera);
        constants.thickness_m = thickness_m;
        constants.coverage = coverage;
        CAPTURE(thickness_m);
        CAPTURE(coverage);
        CAPTURE(x);
        Workshop make_pass(test_kernels());
        CloudParticles pass(make_pass, constants, {});
        const Run result = run(pass, constants);
        CHECK(result.counters.particle_demand == result.counters.particle_count);
        CHECK(result.counters.particle_count > 10);
        std::uint32_t bad = 0;
        for (const Particle& p : result.particles)
          bad += !(std::isfinite(p.center_m.x + p.center_m.y + p.center_m.z + p.radius_m.x + p.radius_m.y +
                                 p.radius_m.z + p.base_m + p.top_m) &&
                   p.extinction_per_m >= 0.0f && p.extinction_per_m <= shared::kMaxGain * constants.extinction_per_m);
        CHECK(bad == 0);
      }
}

TEST_CASE("the sky over a place is the same 10 000 km out") {
  // Moving by whole units with the seed kept changes the clouds; the counts' scale must not.
  CameraState near_camera, far_camera;
  far_camera.position_m = {1e7, 1e7, 1500.0};
  const FrameConstants near_frame = small_frame(near_camera), far_frame = small_frame(far_camera);
  Workshop make_pass(test_kernels());
  CloudParticles pass(make_pass, near_frame, {});
  const Run a = run(pass, near_frame), b = run(pass, far_frame);
  CHECK(b.counters.particle_count > a.counters.particle_count / 3);
  CHECK(b.counters.particle_count < a.counters.particle_count * 3);
  // A shift of the origin that leaves the world place alone gives the same particles, up to rounding.
  FrameConstants shifted = near_frame;
  shared::place_camera(shifted,
                       {near_frame.origin_index + glm::ivec2(1, -1),
                        near_frame.camera_grid_m + glm::vec3(-shared::kOriginUnitM, shared::kOriginUnitM, 0.0f)});
  const Run c = run(pass, shifted);
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
  Workshop make_pass(test_kernels());
  CloudParticles pass(make_pass, small_frame(), {});
  for (int view = 0; view < 12; ++view) {
    CameraState camera;
    camera.position_m = {2e4 * unit(random), 2e4 * unit(random),
                         view % 3 == 0 ? 1500.0 : 6000.0 + 5900.0 * unit(random)};
    camera.yaw_rad = 3.1 * unit(random);
    camera.pitch_rad = view == 1 ? 1.5707963 : view == 2 ? -1.5707963 : 0.6 * unit(random);
    camera.roll_rad = unit(random);
    const FrameConstants constants = small_frame(camera);
    CAPTURE(view);
    const Run result = run(pass, constants);
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
        const glm::vec3 point = p.center_m + shared::render_from_local(glm::vec3(direction) * p.radius_m, p.yaw_rad);
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

TEST_CASE("listed particles come first, in world space without loss") {
  for (const double far_m : {0.0, 1e7}) {
    CAPTURE(far_m);
    CameraState camera;
    camera.position_m = {far_m + 10.25, -far_m, 1500.0};
    std::vector<ListedParticle> listed;
    for (int i = 0; i < 200; ++i)
      listed.push_back(listed_at(camera.position_m + glm::dvec3(3.0 * i, 500.0 + i, -10.0 * (i % 7))));
    listed[1].radiance = glm::vec3(1, 2, 3);
    listed[2].shape = ParticleShape::homogeneous;
    listed[3].density = 0.0f;
    FrameConstants constants = small_frame(camera);
    constants.listed_particle_count = 200;
    Workshop make_pass(test_kernels());
    CloudParticles pass(make_pass, constants, listed);
    const Run result = run(pass, constants, camera.position_m);
    REQUIRE(result.particles.size() > 1000);
    for (std::size_t i = 0; i < listed.size(); ++i) {
      const Particle& p = result.particles[i];
      const glm::dvec3 offset = listed[i].center_m - camera.position_m;
      const glm::vec3 exact = shared::render_from_offset(glm::vec3(offset), 1500.0f);
      CHECK(glm::length(p.center_m - exact) < 2e-4f);  // 900 m in floats
      CHECK(p.extinction_per_m == listed[i].density * listed[i].extinction_per_m);
      CHECK(p.base_m == shared::kNoBaseM);
    }
    CHECK(result.particles[0].flags == shared::kParticleDetail);
    CHECK(result.particles[1].flags == shared::kParticleEmissive);
    CHECK(result.particles[1].radiance_per_sr == glm::vec3(1, 2, 3));
    CHECK(result.particles[2].flags == shared::kParticleHomogeneous);
    CHECK(result.visible[0] == 0);
    CHECK(result.visible[3] == 4);  // the third has no extinction
    CHECK(result.counters.particle_demand == result.counters.particle_count);

    constants.clouds_enabled = 0;
    Workshop make_alone(test_kernels());
    CloudParticles alone(make_alone, constants, listed, 150);
    const Run few = run(alone, constants, camera.position_m);
    CHECK(few.counters.particle_demand == 200);
    CHECK(few.counters.particle_count == 150);
    CHECK(same_bytes(few.particles, {result.particles.begin(), result.particles.begin() + 150}));
  }
}

TEST_CASE("the ground hides what is behind it, with a margin, unless there is none") {
  FrameConstants constants = small_frame();
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
    p.radius_m = glm::vec3(radius);
    p.extinction_per_m = 0.1f;
    return p;
  };
  CHECK(shared::particle_visible(constants, at(1100.0f, 10.0f)));
  CHECK(!shared::particle_visible(constants, at(900.0f, 10.0f)));
  CHECK(shared::particle_visible(constants, at(900.0f, 200.0f)));
  constants.ground_enabled = 0;
  CHECK(shared::particle_visible(constants, at(900.0f, 10.0f)));
}
