#include "tools/fly/presenter.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>

#include <algorithm>

#include "engine/check.h"

namespace nephele::fly {
namespace {

constexpr std::uint32_t kLeastImages = 3;

VkImageMemoryBarrier2 layout_change(VkImage image, VkImageLayout from, VkImageLayout to) {
  VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
  barrier.oldLayout = from;
  barrier.newLayout = to;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image;
  barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  return barrier;
}

void record_barrier(VkCommandBuffer commands, const VkImageMemoryBarrier2& barrier) {
  VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  dependency.imageMemoryBarrierCount = 1;
  dependency.pImageMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &dependency);
}

void blit(VkCommandBuffer commands, const Placed& placed, VkImage target, VkExtent2D extent) {
  const auto at = [](float share, std::uint32_t pixels) {
    return static_cast<std::int32_t>(share * static_cast<float>(pixels) + 0.5f);
  };
  const VkExtent3D source = placed.image->extent();
  VkImageBlit region{};
  region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.srcOffsets[0] = {at(placed.source_left, source.width), 0, 0};
  region.srcOffsets[1] = {static_cast<std::int32_t>(source.width), static_cast<std::int32_t>(source.height), 1};
  region.dstOffsets[0] = {at(placed.left, extent.width), at(placed.top, extent.height), 0};
  region.dstOffsets[1] = {at(placed.right, extent.width), at(placed.bottom, extent.height), 1};
  const bool same =
      region.dstOffsets[1].x - region.dstOffsets[0].x == region.srcOffsets[1].x - region.srcOffsets[0].x &&
      region.dstOffsets[1].y - region.dstOffsets[0].y == region.srcOffsets[1].y;
  vkCmdBlitImage(commands, placed.image->vk(), VK_IMAGE_LAYOUT_GENERAL, target, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                 &region, same ? VK_FILTER_NEAREST : VK_FILTER_LINEAR);
}

void check_imgui(VkResult result) { NEPHELE_CHECK(result >= 0, "Dear ImGui: VkResult ", static_cast<int>(result)); }

}  // namespace

std::vector<std::string> Presenter::device_extensions() { return {VK_KHR_SWAPCHAIN_EXTENSION_NAME}; }

std::vector<std::string> Presenter::instance_extensions() {
  std::uint32_t count = 0;
  const char** names = glfwGetRequiredInstanceExtensions(&count);
  return {names, names + count};
}

Result<std::unique_ptr<Presenter>> Presenter::create(Device& device, Window& window) {
  std::unique_ptr<Presenter> presenter(new Presenter(device, window));
  if (auto ok = presenter->make_surface(); !ok) return ok.error();
  for (Slot& slot : presenter->slots_) {
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.queueFamilyIndex = device.queue_family();
    NEPHELE_VK(vkCreateCommandPool(device.vk(), &pool, nullptr, &slot.pool));
    VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocate.commandPool = slot.pool;
    allocate.commandBufferCount = 1;
    NEPHELE_VK(vkAllocateCommandBuffers(device.vk(), &allocate, &slot.commands));
    const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
    NEPHELE_VK(vkCreateFence(device.vk(), &fence, nullptr, &slot.fence));
    const VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, nullptr, 0};
    NEPHELE_VK(vkCreateSemaphore(device.vk(), &semaphore, nullptr, &slot.acquired));
  }
  presenter->make_render_pass();
  presenter->start_imgui();
  return presenter;
}

Presenter::~Presenter() {
  finish();
  if (imgui_started_) {
    ImGui_ImplVulkan_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
  }
  vkDestroyDescriptorPool(device_.vk(), imgui_descriptors_, nullptr);
  destroy_targets();
  vkDestroySwapchainKHR(device_.vk(), swapchain_, nullptr);
  vkDestroyRenderPass(device_.vk(), render_pass_, nullptr);
  for (Slot& slot : slots_) {
    vkDestroySemaphore(device_.vk(), slot.acquired, nullptr);
    vkDestroyFence(device_.vk(), slot.fence, nullptr);
    vkDestroyCommandPool(device_.vk(), slot.pool, nullptr);
  }
  vkDestroySurfaceKHR(device_.instance(), surface_, nullptr);
}

Result<void> Presenter::make_surface() {
  if (const VkResult made = glfwCreateWindowSurface(device_.instance(), window_.glfw(), nullptr, &surface_);
      made != VK_SUCCESS)
    return Error{concat("the window has no surface for Vulkan (VkResult ", static_cast<int>(made), ')')};
  VkBool32 presents = VK_FALSE;
  NEPHELE_VK(vkGetPhysicalDeviceSurfaceSupportKHR(device_.physical(), device_.queue_family(), surface_, &presents));
  if (!presents) return Error{concat("device '", device_.info().name, "' can't present to this window")};
  std::uint32_t count = 0;
  NEPHELE_VK(vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical(), surface_, &count, nullptr));
  std::vector<VkSurfaceFormatKHR> formats(count);
  NEPHELE_VK(vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical(), surface_, &count, formats.data()));
  // The picture is encoded already: a format that would encode it again is the wrong one.
  for (const VkFormat wanted : {VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM})
    for (const VkSurfaceFormatKHR& format : formats)
      if (format_.format == VK_FORMAT_UNDEFINED && format.format == wanted) format_ = format;
  if (format_.format == VK_FORMAT_UNDEFINED)
    return Error{concat("device '", device_.info().name, "' presents no format of 8 bits a channel to this window")};
  return {};
}

void Presenter::make_render_pass() {
  VkAttachmentDescription color{};
  color.format = format_.format;
  color.samples = VK_SAMPLE_COUNT_1_BIT;
  color.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
  color.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  color.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  color.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  color.initialLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  color.finalLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
  const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass{};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &reference;
  VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  info.attachmentCount = 1;
  info.pAttachments = &color;
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  NEPHELE_VK(vkCreateRenderPass(device_.vk(), &info, nullptr, &render_pass_));
}

void Presenter::start_imgui() {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 16};
  VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
  pool.maxSets = size.descriptorCount;
  pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  NEPHELE_VK(vkCreateDescriptorPool(device_.vk(), &pool, nullptr, &imgui_descriptors_));
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;                // leaves no file behind
  ImGui_ImplGlfw_InitForVulkan(window_.glfw(), true);  // calls the window's own callbacks too
  ImGui_ImplVulkan_InitInfo info{};
  info.Instance = device_.instance();
  info.PhysicalDevice = device_.physical();
  info.Device = device_.vk();
  info.QueueFamily = device_.queue_family();
  info.Queue = device_.queue();
  info.DescriptorPool = imgui_descriptors_;
  info.MinImageCount = kLeastImages;
  info.ImageCount = kLeastImages;
  info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
  info.CheckVkResultFn = check_imgui;
  ImGui_ImplVulkan_Init(&info, render_pass_);
#if IMGUI_VERSION_NUM >= 19000
  ImGui_ImplVulkan_CreateFontsTexture();
#else
  device_.run_once([](VkCommandBuffer commands) { ImGui_ImplVulkan_CreateFontsTexture(commands); });
  ImGui_ImplVulkan_DestroyFontUploadObjects();
#endif
  imgui_started_ = true;
}

// The window may have come to a monitor of another scale.
void Presenter::match_scale() {
  const float scale = window_.content_scale();
  if (scale == scale_) return;
  scale_ = scale;
  ImGui::GetStyle() = ImGuiStyle();
  ImGui::StyleColorsDark();
  ImGui::GetStyle().ScaleAllSizes(scale);
  ImGui::GetIO().FontGlobalScale = scale;
}

void Presenter::destroy_targets() {
  for (const Target& target : targets_) {
    vkDestroyFramebuffer(device_.vk(), target.framebuffer, nullptr);
    vkDestroyImageView(device_.vk(), target.view, nullptr);
    vkDestroySemaphore(device_.vk(), target.drawn, nullptr);
  }
  targets_.clear();
}

void Presenter::make_swapchain() {
  finish();
  {
    const std::lock_guard lock(device_.queue_mutex());
    NEPHELE_VK(vkQueueWaitIdle(device_.queue()));  // what was presented has no fence
  }
  VkSurfaceCapabilitiesKHR surface{};
  NEPHELE_VK(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical(), surface_, &surface));
  const glm::uvec2 wanted = window_.framebuffer_px();
  extent_ = surface.currentExtent;
  if (extent_.width == ~0u)  // the window takes the swapchain's size
    extent_ = {std::clamp(wanted.x, surface.minImageExtent.width, surface.maxImageExtent.width),
               std::clamp(wanted.y, surface.minImageExtent.height, surface.maxImageExtent.height)};
  if (wanted.x == 0 || extent_.width == 0 || extent_.height == 0) return;  // minimised: stays stale
  VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
  info.surface = surface_;
  info.minImageCount = std::max(kLeastImages, surface.minImageCount);
  if (surface.maxImageCount > 0) info.minImageCount = std::min(info.minImageCount, surface.maxImageCount);
  info.imageFormat = format_.format;
  info.imageColorSpace = format_.colorSpace;
  info.imageExtent = extent_;
  info.imageArrayLayers = 1;
  info.imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  info.preTransform = surface.currentTransform;
  info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
  info.presentMode = VK_PRESENT_MODE_FIFO_KHR;
  info.clipped = VK_TRUE;
  info.oldSwapchain = swapchain_;
  VkSwapchainKHR made = VK_NULL_HANDLE;
  const VkResult result = vkCreateSwapchainKHR(device_.vk(), &info, nullptr, &made);
  destroy_targets();
  vkDestroySwapchainKHR(device_.vk(), swapchain_, nullptr);
  swapchain_ = VK_NULL_HANDLE;
  if (result == VK_ERROR_OUT_OF_DATE_KHR) return;
  NEPHELE_CHECK(result == VK_SUCCESS, "vkCreateSwapchainKHR: VkResult ", static_cast<int>(result));
  swapchain_ = made;
  std::uint32_t count = 0;
  NEPHELE_VK(vkGetSwapchainImagesKHR(device_.vk(), swapchain_, &count, nullptr));
  std::vector<VkImage> images(count);
  NEPHELE_VK(vkGetSwapchainImagesKHR(device_.vk(), swapchain_, &count, images.data()));
  for (VkImage image : images) {
    Target target{image, VK_NULL_HANDLE, VK_NULL_HANDLE, VK_NULL_HANDLE};
    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = image;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = format_.format;
    view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    NEPHELE_VK(vkCreateImageView(device_.vk(), &view, nullptr, &target.view));
    VkFramebufferCreateInfo framebuffer{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    framebuffer.renderPass = render_pass_;
    framebuffer.attachmentCount = 1;
    framebuffer.pAttachments = &target.view;
    framebuffer.width = extent_.width;
    framebuffer.height = extent_.height;
    framebuffer.layers = 1;
    NEPHELE_VK(vkCreateFramebuffer(device_.vk(), &framebuffer, nullptr, &target.framebuffer));
    const VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, nullptr, 0};
    NEPHELE_VK(vkCreateSemaphore(device_.vk(), &semaphore, nullptr, &target.drawn));
    targets_.push_back(target);
  }
  stale_ = false;
}

void Presenter::wait_for(Slot& slot) {
  if (!slot.busy) return;
  NEPHELE_VK(vkWaitForFences(device_.vk(), 1, &slot.fence, VK_TRUE, UINT64_MAX));
  NEPHELE_VK(vkResetFences(device_.vk(), 1, &slot.fence));
  slot.busy = false;
}

void Presenter::finish() {
  for (Slot& slot : slots_) wait_for(slot);
  finished_ = frame_;
}

bool Presenter::begin() {
  Slot& slot = slots_[frame_ % slots_.size()];
  wait_for(slot);
  if (frame_ >= slots_.size()) finished_ = std::max(finished_, frame_ - (slots_.size() - 1));
  if (window_.framebuffer_px().x == 0) return false;
  if (window_.framebuffer_px() != size_px()) stale_ = true;
  if (stale_) make_swapchain();
  if (stale_) return false;
  match_scale();
  const VkResult acquired =
      vkAcquireNextImageKHR(device_.vk(), swapchain_, UINT64_MAX, slot.acquired, VK_NULL_HANDLE, &target_);
  if (acquired == VK_ERROR_OUT_OF_DATE_KHR) {
    stale_ = true;
    return false;
  }
  if (acquired == VK_ERROR_SURFACE_LOST_KHR) {  // the window system has taken it away: ask for another
    finish();
    destroy_targets();
    vkDestroySwapchainKHR(device_.vk(), swapchain_, nullptr);
    swapchain_ = VK_NULL_HANDLE;
    vkDestroySurfaceKHR(device_.instance(), surface_, nullptr);
    surface_ = VK_NULL_HANDLE;
    NEPHELE_VK(glfwCreateWindowSurface(device_.instance(), window_.glfw(), nullptr, &surface_));
    stale_ = true;
    return false;
  }
  NEPHELE_CHECK(acquired == VK_SUCCESS || acquired == VK_SUBOPTIMAL_KHR, "vkAcquireNextImageKHR: VkResult ",
                static_cast<int>(acquired));
  return true;
}

void Presenter::show(const std::function<std::vector<Placed>(VkCommandBuffer)>& record) {
  Slot& slot = slots_[frame_ % slots_.size()];
  const Target& target = targets_[target_];
  NEPHELE_VK(vkResetCommandPool(device_.vk(), slot.pool, 0));
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  NEPHELE_VK(vkBeginCommandBuffer(slot.commands, &begin));
  const std::vector<Placed> pictures = record(slot.commands);

  VkImageMemoryBarrier2 to_transfer =
      layout_change(target.image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  to_transfer.srcStageMask = to_transfer.dstStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
  to_transfer.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
  record_barrier(slot.commands, to_transfer);
  const VkClearColorValue black{};
  const VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  if (pictures.empty())
    vkCmdClearColorImage(slot.commands, target.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &black, 1, &all);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (i > 0) {  // one lies over the other
      VkImageMemoryBarrier2 order =
          layout_change(target.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
      order.srcStageMask = order.dstStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
      order.srcAccessMask = order.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
      record_barrier(slot.commands, order);
    }
    blit(slot.commands, pictures[i], target.image, extent_);
  }
  VkImageMemoryBarrier2 to_color =
      layout_change(target.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
  to_color.srcStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
  to_color.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
  to_color.dstStageMask = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
  to_color.dstAccessMask = VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
  record_barrier(slot.commands, to_color);
  VkRenderPassBeginInfo pass{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
  pass.renderPass = render_pass_;
  pass.framebuffer = target.framebuffer;
  pass.renderArea.extent = extent_;
  vkCmdBeginRenderPass(slot.commands, &pass, VK_SUBPASS_CONTENTS_INLINE);
  ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), slot.commands);
  vkCmdEndRenderPass(slot.commands);
  NEPHELE_VK(vkEndCommandBuffer(slot.commands));

  VkSemaphoreSubmitInfo wait{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO};
  wait.semaphore = slot.acquired;
  wait.stageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
  VkSemaphoreSubmitInfo signal{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO};
  signal.semaphore = target.drawn;
  signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  VkCommandBufferSubmitInfo commands{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
  commands.commandBuffer = slot.commands;
  VkSubmitInfo2 submit{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
  submit.waitSemaphoreInfoCount = 1;
  submit.pWaitSemaphoreInfos = &wait;
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &commands;
  submit.signalSemaphoreInfoCount = 1;
  submit.pSignalSemaphoreInfos = &signal;
  device_.submit(submit, slot.fence);
  slot.busy = true;
  ++frame_;
  VkPresentInfoKHR present{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
  present.waitSemaphoreCount = 1;
  present.pWaitSemaphores = &target.drawn;
  present.swapchainCount = 1;
  present.pSwapchains = &swapchain_;
  present.pImageIndices = &target_;
  VkResult presented;
  {
    const std::lock_guard lock(device_.queue_mutex());
    presented = vkQueuePresentKHR(device_.queue(), &present);
  }
  if (presented == VK_ERROR_OUT_OF_DATE_KHR || presented == VK_SUBOPTIMAL_KHR || presented == VK_ERROR_SURFACE_LOST_KHR)
    stale_ = true;
  else
    NEPHELE_CHECK(presented == VK_SUCCESS, "vkQueuePresentKHR: VkResult ", static_cast<int>(presented));
}

}  // namespace nephele::fly
