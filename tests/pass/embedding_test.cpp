// Nephele inside a host: a lent VkDevice, the host's own command buffer and submission, the same image.
#include <doctest/doctest.h>

#include "passes/nephele.h"
#include "tests/support/support.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using nephele::test::test_device;
using nephele::test::test_tables;

TEST_CASE("a frame recorded into a host's command buffer equals a rendered one") {
  Device& host = test_device();
  const std::unique_ptr<Device> lent =
      Device::adopt({.physical_device = host.physical(),
                     .device = host.vk(),
                     .queue = host.queue(),
                     .queue_family = host.queue_family(),
                     .fragment_shader_interlock = host.info().fragment_shader_interlock,
                     .ordered_attachment_access = host.info().ordered_attachment_access,
                     .fragment_count_query = host.info().fragment_count_query});
  Scene scene;
  scene.clouds->coverage = 0.5f;
  const RenderSettings settings{.width = 48, .height = 32, .quality = Quality::low, .scale = 2};
  const auto embedded = Renderer::create(*lent, test_tables(), scene, settings);
  const auto alone = Renderer::create(host, test_tables(), scene, settings);
  REQUIRE(embedded);
  REQUIRE(alone);

  for (const double time_s : {0.0, 100.0}) {
    host.run_once([&](VkCommandBuffer commands) { (*embedded)->record(scene.camera, time_s, commands); });
    (*embedded)->collect();
    (*alone)->render(scene.camera, time_s);
    CHECK((*embedded)->read_hdr() == (*alone)->read_hdr());
    CHECK((*embedded)->stats().particles_visible == (*alone)->stats().particles_visible);
    CHECK((*embedded)->stats().particles_visible > 0);
  }
  REQUIRE((*embedded)->cloud_color() != nullptr);
  CHECK((*embedded)->cloud_color()->desc().width == settings.width);
}

TEST_CASE("a scene without clouds has no cloud layer and records no cloud pass") {
  Scene scene;
  scene.clouds.reset();
  const auto renderer =
      Renderer::create(test_device(), test_tables(), scene, {.width = 16, .height = 16, .quality = Quality::low});
  REQUIRE(renderer);
  (*renderer)->render(scene.camera, 0.0);
  CHECK((*renderer)->cloud_color() == nullptr);
  CHECK((*renderer)->describe_frame().find("shade_blend") == std::string::npos);
  CHECK((*renderer)->describe_frame().find("light_tiles") == std::string::npos);
  CHECK((*renderer)->describe_frame().find("composite") != std::string::npos);
}

TEST_CASE("a host can read the particles of the last frame, in view or not") {
  Scene scene;
  scene.camera.position_m = {5000, -3000, 1500};
  scene.clouds.reset();
  scene.particles = {{.center_m = {5000, -4000, 1400}, .radius_m = {50, 60, 70}, .density = 0.5f}};
  const RenderSettings settings{.width = 16, .height = 16, .quality = Quality::low};
  const auto renderer = Renderer::create(test_device(), test_tables(), scene, settings);
  REQUIRE(renderer);
  CHECK((*renderer)->read_particles().empty());  // no frame yet
  (*renderer)->render(scene.camera, 0.0);
  const std::vector<shared::Particle> particles = (*renderer)->read_particles();
  REQUIRE(particles.size() == 1);
  CHECK((*renderer)->stats().particles_visible == 0);  // it is behind the camera
  // 1 000 m along the ground are 1 000 (1 + 1 400 / R) up there, and 0.08 m further down.
  CHECK(glm::distance(particles[0].center_m, glm::vec3(0, -1000.22f, -100.08f)) < 0.01f);
  CHECK(particles[0].extinction_per_m == doctest::Approx(0.025f));

  scene.clouds = CloudSettings{};
  const auto sky = Renderer::create(test_device(), test_tables(), scene, settings);
  REQUIRE(sky);
  (*sky)->render(scene.camera, 0.0);
  CHECK((*sky)->read_particles().size() == (*sky)->stats().particles_generated);
  CHECK((*sky)->stats().particles_generated > (*sky)->stats().particles_visible);
}
