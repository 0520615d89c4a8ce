#include "engine/resources.h"

#include <atomic>
#include <utility>

namespace nephele {
namespace {

VkDeviceMemory allocate_for(Device& device, const VkMemoryRequirements& needs, VkMemoryPropertyFlags properties) {
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  info.allocationSize = needs.size;
  info.memoryTypeIndex = device.memory_type(needs.memoryTypeBits, properties);
  VkDeviceMemory memory = VK_NULL_HANDLE;
  NEPHELE_VK(vkAllocateMemory(device.vk(), &info, nullptr, &memory));
  device.count_allocation(needs.size);
  return memory;
}

void full_barrier(VkCommandBuffer commands) {
  VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  barrier.srcStageMask = barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &dependency);
}

VkBufferImageCopy whole_image(const Image& image) {
  VkBufferImageCopy copy{};
  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  copy.imageExtent = image.extent();
  return copy;
}

}  // namespace

std::uint64_t next_resource_id() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

std::uint32_t format_bytes(VkFormat format) {
  switch (format) {
    case VK_FORMAT_R8_UNORM:
      return 1;
    case VK_FORMAT_R8G8_UNORM:
    case VK_FORMAT_R16_SFLOAT:
    case VK_FORMAT_R16_UNORM:
      return 2;
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R16G16_SFLOAT:
    case VK_FORMAT_R32_SFLOAT:
    case VK_FORMAT_R32_UINT:
      return 4;
    case VK_FORMAT_R16G16B16A16_SFLOAT:
    case VK_FORMAT_R32G32_SFLOAT:
      return 8;
    case VK_FORMAT_R32G32B32A32_SFLOAT:
      return 16;
    default:
      NEPHELE_CHECK(false, "format ", static_cast<int>(format), " has no size in the table");
  }
  return 0;
}

Buffer::Buffer(Device& device, std::string name, VkDeviceSize bytes, Memory memory)
    : device_(&device), id_(next_resource_id()), name_(std::move(name)), bytes_(bytes) {
  NEPHELE_CHECK(bytes > 0, "buffer ", name_);
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = bytes;
  info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  VkMemoryPropertyFlags properties = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  if (memory == Memory::device)
    info.usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                  VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
  else
    properties = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT |
                 (memory == Memory::readback ? VK_MEMORY_PROPERTY_HOST_CACHED_BIT : 0);
  NEPHELE_VK(vkCreateBuffer(device.vk(), &info, nullptr, &buffer_));
  device.set_name(VK_OBJECT_TYPE_BUFFER, reinterpret_cast<std::uint64_t>(buffer_), name_);
  VkMemoryRequirements needs{};
  vkGetBufferMemoryRequirements(device.vk(), buffer_, &needs);
  memory_ = allocate_for(device, needs, properties);
  allocated_ = needs.size;
  NEPHELE_VK(vkBindBufferMemory(device.vk(), buffer_, memory_, 0));
  if (memory == Memory::device)
    device.run_once([&](VkCommandBuffer commands) { vkCmdFillBuffer(commands, buffer_, 0, VK_WHOLE_SIZE, 0); });
  else
    NEPHELE_VK(vkMapMemory(device.vk(), memory_, 0, VK_WHOLE_SIZE, 0, &mapped_));
}

Buffer::~Buffer() {
  if (!buffer_) return;
  vkDestroyBufferView(device_->vk(), words_, nullptr);
  vkDestroyBufferView(device_->vk(), texels_, nullptr);
  vkDestroyBuffer(device_->vk(), buffer_, nullptr);
  vkFreeMemory(device_->vk(), memory_, nullptr);
  device_->count_free(allocated_);
}

void Buffer::swap(Buffer& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(id_, other.id_);
  std::swap(name_, other.name_);
  std::swap(buffer_, other.buffer_);
  std::swap(memory_, other.memory_);
  std::swap(bytes_, other.bytes_);
  std::swap(allocated_, other.allocated_);
  std::swap(mapped_, other.mapped_);
  std::swap(words_, other.words_);
  std::swap(texels_, other.texels_);
}

VkBufferView Buffer::texel_view(VkFormat format) const {
  NEPHELE_CHECK(format == VK_FORMAT_R32_UINT || format == VK_FORMAT_R32G32B32A32_UINT, name_, ": format ",
                static_cast<int>(format));
  VkBufferView& view = format == VK_FORMAT_R32_UINT ? words_ : texels_;
  if (view) return view;
  const VkDeviceSize texel_bytes = format == VK_FORMAT_R32_UINT ? 4 : 16;
  NEPHELE_CHECK(bytes_ / texel_bytes <= device_->info().max_texel_buffer_elements, name_, ": ", bytes_,
                " bytes as texels");
  VkBufferViewCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
  info.buffer = buffer_;
  info.format = format;
  info.range = VK_WHOLE_SIZE;
  NEPHELE_VK(vkCreateBufferView(device_->vk(), &info, nullptr, &view));
  return view;
}

void Buffer::write(std::span<const std::byte> data) {
  NEPHELE_CHECK(data.size() <= bytes_, name_, ": ", data.size(), " > ", bytes_);
  if (data.empty()) return;
  const Buffer staging(*device_, name_ + " staging", data.size(), Memory::upload);
  std::memcpy(staging.mapped(), data.data(), data.size());
  device_->run_once([&](VkCommandBuffer commands) {
    const VkBufferCopy copy{0, 0, data.size()};
    full_barrier(commands);
    vkCmdCopyBuffer(commands, staging.vk(), buffer_, 1, &copy);
  });
}

void Buffer::read(std::span<std::byte> data) const {
  NEPHELE_CHECK(data.size() <= bytes_, name_, ": ", data.size(), " > ", bytes_);
  if (data.empty()) return;
  const Buffer staging(*device_, name_ + " staging", data.size(), Memory::readback);
  device_->run_once([&](VkCommandBuffer commands) {
    const VkBufferCopy copy{0, 0, data.size()};
    full_barrier(commands);
    vkCmdCopyBuffer(commands, buffer_, staging.vk(), 1, &copy);
    full_barrier(commands);
  });
  std::memcpy(data.data(), staging.mapped(), data.size());
}

Image::Image(Device& device, std::string name, const ImageDesc& desc)
    : device_(&device), id_(next_resource_id()), name_(std::move(name)), desc_(desc) {
  const bool is_3d = desc.depth > 1 || desc.force_3d;
  VkFormatProperties properties{};
  vkGetPhysicalDeviceFormatProperties(device.physical(), desc.format, &properties);
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.imageType = is_3d ? VK_IMAGE_TYPE_3D : VK_IMAGE_TYPE_2D;
  info.format = desc.format;
  info.extent = extent();
  info.mipLevels = info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.tiling = VK_IMAGE_TILING_OPTIMAL;
  info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  if (properties.optimalTilingFeatures & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT) info.usage |= VK_IMAGE_USAGE_STORAGE_BIT;
  if (desc.attachment) info.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT;
  NEPHELE_VK(vkCreateImage(device.vk(), &info, nullptr, &image_));
  device.set_name(VK_OBJECT_TYPE_IMAGE, reinterpret_cast<std::uint64_t>(image_), name_);
  VkMemoryRequirements needs{};
  vkGetImageMemoryRequirements(device.vk(), image_, &needs);
  memory_ = allocate_for(device, needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  allocated_ = needs.size;
  NEPHELE_VK(vkBindImageMemory(device.vk(), image_, memory_, 0));

  VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  view.image = image_;
  view.viewType = is_3d ? VK_IMAGE_VIEW_TYPE_3D : VK_IMAGE_VIEW_TYPE_2D;
  view.format = desc.format;
  view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  NEPHELE_VK(vkCreateImageView(device.vk(), &view, nullptr, &view_));

  device.run_once([&](VkCommandBuffer commands) {
    VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_NONE;
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image_;
    barrier.subresourceRange = view.subresourceRange;
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.imageMemoryBarrierCount = 1;
    dependency.pImageMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands, &dependency);
  });
}

Image::~Image() {
  if (!image_) return;
  vkDestroyImageView(device_->vk(), view_, nullptr);
  vkDestroyImage(device_->vk(), image_, nullptr);
  vkFreeMemory(device_->vk(), memory_, nullptr);
  device_->count_free(allocated_);
}

void Image::swap(Image& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(id_, other.id_);
  std::swap(name_, other.name_);
  std::swap(desc_, other.desc_);
  std::swap(image_, other.image_);
  std::swap(view_, other.view_);
  std::swap(memory_, other.memory_);
  std::swap(allocated_, other.allocated_);
}

VkDeviceSize Image::tight_bytes() const {
  return VkDeviceSize{desc_.width} * desc_.height * desc_.depth * format_bytes(desc_.format);
}

void Image::write(std::span<const std::byte> texels) {
  NEPHELE_CHECK(texels.size() == tight_bytes(), name_, ": ", texels.size(), " != ", tight_bytes());
  const Buffer staging(*device_, name_ + " staging", texels.size(), Buffer::Memory::upload);
  std::memcpy(staging.mapped(), texels.data(), texels.size());
  device_->run_once([&](VkCommandBuffer commands) {
    const VkBufferImageCopy copy = whole_image(*this);
    full_barrier(commands);
    vkCmdCopyBufferToImage(commands, staging.vk(), image_, VK_IMAGE_LAYOUT_GENERAL, 1, &copy);
  });
}

void Image::read(std::span<std::byte> texels) const {
  NEPHELE_CHECK(texels.size() == tight_bytes(), name_, ": ", texels.size(), " != ", tight_bytes());
  const Buffer staging(*device_, name_ + " staging", texels.size(), Buffer::Memory::readback);
  device_->run_once([&](VkCommandBuffer commands) {
    const VkBufferImageCopy copy = whole_image(*this);
    full_barrier(commands);
    vkCmdCopyImageToBuffer(commands, image_, VK_IMAGE_LAYOUT_GENERAL, staging.vk(), 1, &copy);
    full_barrier(commands);
  });
  std::memcpy(texels.data(), staging.mapped(), texels.size());
}

}  // namespace nephele
