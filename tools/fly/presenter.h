// The swapchain: takes a finished picture to the window with Dear ImGui on top. Two frames may be under way.
#pragma once

#include <vulkan/vulkan.h>
#include <string>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "engine/device.h"
#include "engine/resources.h"
#include "engine/result.h"
#include "tools/fly/window.h"

namespace nephele::fly {

// Where in the window an image goes, from the upper left, in shares of its size.
struct Placed {
  const Image* image = nullptr;  // RGBA8 in layout GENERAL
  float left = 0, top = 0, right = 1, bottom = 1;
  float source_left = 0;  // of the image, what lies left of it is not shown
};

class Presenter {
 public:
  // Device extensions and instance extensions that the device must have been created with.
  static std::vector<std::string> device_extensions();
  static std::vector<std::string> instance_extensions();

  // The device and the window must outlive it. An error where the device can't present to the window.
  static Result<std::unique_ptr<Presenter>> create(Device& device, Window& window);
  ~Presenter();
  Presenter(const Presenter&) = delete;
  Presenter& operator=(const Presenter&) = delete;

  // Waits until at most one frame is under way. False while there is nothing to draw on: the window is minimised or
  // has just changed; try again later.
  bool begin();
  // After begin(): `record` adds the frame's own work to the command buffer and says what to show; then Dear ImGui's
  // draw data (ImGui::Render must have been called) goes on top, and the frame to the screen.
  void show(const std::function<std::vector<Placed>(VkCommandBuffer)>& record);

  glm::uvec2 size_px() const { return {extent_.width, extent_.height}; }
  std::uint64_t frames() const { return frame_; }  // shown so far
  // Frames that have finished for sure; grows in begin() and in finish().
  std::uint64_t frames_finished() const { return finished_; }
  void finish();  // waits for all frames

 private:
  struct Slot {
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
    VkSemaphore acquired = VK_NULL_HANDLE;
    bool busy = false;
  };
  struct Target {  // of the swapchain
    VkImage image;
    VkImageView view;
    VkFramebuffer framebuffer;
    VkSemaphore drawn;
  };
  Presenter(Device& device, Window& window) : device_(device), window_(window) {}
  Result<void> make_surface();
  void make_render_pass();
  void make_swapchain();
  void destroy_targets();
  void start_imgui();
  void match_scale();
  void wait_for(Slot& slot);

  Device& device_;
  Window& window_;
  VkSurfaceKHR surface_ = VK_NULL_HANDLE;
  VkSurfaceFormatKHR format_{};
  VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
  VkExtent2D extent_{};
  VkRenderPass render_pass_ = VK_NULL_HANDLE;
  VkDescriptorPool imgui_descriptors_ = VK_NULL_HANDLE;
  bool imgui_started_ = false;
  float scale_ = 0;  // that sizes of controls are made for
  std::vector<Target> targets_;
  std::array<Slot, 2> slots_;
  std::uint64_t frame_ = 0, finished_ = 0;
  std::uint32_t target_ = 0;
  bool stale_ = true;  // the swapchain no longer fits the window
};

}  // namespace nephele::fly
