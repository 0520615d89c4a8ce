// Nephele inside a host: a lent VkDevice, the host's own command buffer and submission, the same image.
#include <doctest/doctest.h>

#include "engine/check.h"
#include "passes/nephele.h"
#include "shared/types.h"
#include "tests/support/support.h"
#include "tests/support/test_tables.h"

using namespace nephele;
using nephele::test::test_device;
using nephele::test::test_sky;
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
  const auto lent_sky = Sky::create(*lent, test_tables());
  REQUIRE(lent_sky);
  const auto embedded = Renderer::create(**lent_sky, scene, settings);
  const auto alone = Renderer::create(test_sky(), scene, settings);
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

namespace {

// A host with two command buffers, as one that records a frame while the device still draws the one before.
class TwoInFlight {
 public:
  explicit TwoInFlight(Device& device) : device_(device) {
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool.queueFamilyIndex = device.queue_family();
    NEPHELE_VK(vkCreateCommandPool(device.vk(), &pool, nullptr, &pool_));
    VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocate.commandPool = pool_;
    allocate.commandBufferCount = 2;
    NEPHELE_VK(vkAllocateCommandBuffers(device.vk(), &allocate, commands_));
    const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
    for (VkFence& made : fences_) NEPHELE_VK(vkCreateFence(device.vk(), &fence, nullptr, &made));
  }
  ~TwoInFlight() {
    for (VkFence fence : fences_) vkDestroyFence(device_.vk(), fence, nullptr);
    vkDestroyCommandPool(device_.vk(), pool_, nullptr);
  }
  VkCommandBuffer begin(int frame) {
    const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr, 0, nullptr};
    NEPHELE_VK(vkBeginCommandBuffer(commands_[frame % 2], &begin));
    return commands_[frame % 2];
  }
  void submit(int frame) {
    NEPHELE_VK(vkEndCommandBuffer(commands_[frame % 2]));
    VkCommandBufferSubmitInfo command_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
    command_info.commandBuffer = commands_[frame % 2];
    VkSubmitInfo2 submit{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
    submit.commandBufferInfoCount = 1;
    submit.pCommandBufferInfos = &command_info;
    NEPHELE_VK(vkQueueSubmit2(device_.queue(), 1, &submit, fences_[frame % 2]));
  }
  void wait(int frame) {
    NEPHELE_VK(vkWaitForFences(device_.vk(), 1, &fences_[frame % 2], VK_TRUE, UINT64_MAX));
    NEPHELE_VK(vkResetFences(device_.vk(), 1, &fences_[frame % 2]));
  }

 private:
  Device& device_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_[2];
  VkFence fences_[2];
};

}  // namespace

TEST_CASE("a host records a frame while the one before is under way, and changes the scene between them") {
  Device& device = test_device();
  const RenderSettings settings{.width = 48, .height = 32, .quality = Quality::low, .ring_size_cells = 40};
  const auto hosted = Renderer::create(test_sky(), Scene{}, settings);
  REQUIRE(hosted);
  TwoInFlight host(device);
  constexpr int kFrames = 5;
  Scene scene;
  std::vector<std::uint32_t> visible, alone_visible;
  std::vector<float> last;
  for (int frame = 0; frame < kFrames; ++frame) {
    scene.camera.yaw_rad = 0.4 * frame;
    if (frame == 2) scene.clouds->coverage = 0.7f;  // more particles: larger buffers, while frame 1 uses the old ones
    if (frame == 2) REQUIRE((*hosted)->set(scene, settings));
    if (frame >= 2) {
      host.wait(frame - 2);
      (*hosted)->collect();
      visible.push_back((*hosted)->stats().particles_visible);
    }
    (*hosted)->record(scene.camera, 10.0 * frame, host.begin(frame));
    host.submit(frame);

    const auto alone = Renderer::create(test_sky(), scene, settings);
    REQUIRE(alone);
    (*alone)->render(scene.camera, 10.0 * frame);
    alone_visible.push_back((*alone)->stats().particles_visible);
    last = (*alone)->read_hdr();
  }
  for (int frame = kFrames - 2; frame < kFrames; ++frame) {
    host.wait(frame);
    (*hosted)->collect();
    visible.push_back((*hosted)->stats().particles_visible);
  }
  CHECK(visible == alone_visible);
  CHECK((*hosted)->read_hdr() == last);
}

TEST_CASE("a recorded frame that the host never submits is forgotten") {
  const RenderSettings settings{.width = 48, .height = 32, .quality = Quality::low, .ring_size_cells = 40};
  const Scene scene;
  const auto hosted = Renderer::create(test_sky(), scene, settings),
             alone = Renderer::create(test_sky(), scene, settings);
  REQUIRE(hosted);
  TwoInFlight host(test_device());
  (*hosted)->record(scene.camera, 0.0, host.begin(0));
  (*hosted)->forget();
  (*hosted)->render(scene.camera, 0.0);
  (*alone)->render(scene.camera, 0.0);
  CHECK((*hosted)->read_hdr() == (*alone)->read_hdr());
}

TEST_CASE("a scene without clouds has no cloud layer and records no cloud pass") {
  Scene scene;
  scene.clouds.reset();
  const auto renderer = Renderer::create(test_sky(), scene, {.width = 16, .height = 16, .quality = Quality::low});
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
  scene.particles = {{.center_m = {5000, -4000, 1400}, .ellipsoid = {{50, 60, 70}, glm::vec3(0)}, .density = 0.5f}};
  const RenderSettings settings{.width = 16, .height = 16, .quality = Quality::low};
  const auto renderer = Renderer::create(test_sky(), scene, settings);
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
  const auto sky = Renderer::create(test_sky(), scene, settings);
  REQUIRE(sky);
  (*sky)->render(scene.camera, 0.0);
  CHECK((*sky)->read_particles().size() == (*sky)->stats().particles_generated);
  CHECK((*sky)->stats().particles_generated > (*sky)->stats().particles_visible);
}
