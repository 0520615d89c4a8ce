// Buffers and images: RAII, named, one allocation each (a renderer makes dozens, not thousands).
// Every image lives in VK_IMAGE_LAYOUT_GENERAL from its creation on, so that barriers are memory barriers only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "engine/check.h"
#include "engine/device.h"

namespace nephele {

// A number that no other buffer or image of this process has had: an address may come back, a number does not.
std::uint64_t next_resource_id();

class Buffer {
 public:
  enum class Memory {
    device,    // storage, indirect, transfer
    readback,  // host-visible, cached, mapped: transfer destination, read after the frame
    upload,    // host-visible, mapped: transfer source
  };
  Buffer() = default;
  // bytes > 0; the contents start as zeros (device memory) or are undefined (host memory).
  Buffer(Device& device, std::string name, VkDeviceSize bytes, Memory memory = Memory::device);
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Buffer();

  explicit operator bool() const { return buffer_ != VK_NULL_HANDLE; }
  VkBuffer vk() const { return buffer_; }
  VkDeviceSize bytes() const { return bytes_; }
  const std::string& name() const { return name_; }
  std::uint64_t id() const { return id_; }
  void* mapped() const { return mapped_; }

  // The whole buffer as texels of R32_UINT or R32G32B32A32_UINT, made at the first call; device memory only.
  VkBufferView texel_view(VkFormat format) const;

  // Blocking transfers through a staging buffer: for set-up, tools and tests, never inside a frame.
  void write(std::span<const std::byte> data);
  void read(std::span<std::byte> data) const;
  template <class T>
  void write_vector(const std::vector<T>& values) {
    write(std::as_bytes(std::span(values)));
  }
  template <class T>
  std::vector<T> read_vector(std::size_t count) const {
    std::vector<T> values(count);
    read(std::as_writable_bytes(std::span(values)));
    return values;
  }

 private:
  void swap(Buffer& other) noexcept;
  Device* device_ = nullptr;
  std::uint64_t id_ = 0;
  std::string name_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize bytes_ = 0, allocated_ = 0;
  void* mapped_ = nullptr;
  mutable VkBufferView words_ = VK_NULL_HANDLE, texels_ = VK_NULL_HANDLE;
};

struct ImageDesc {
  VkFormat format = VK_FORMAT_R32G32B32A32_SFLOAT;
  std::uint32_t width = 1, height = 1, depth = 1;  // depth > 1 makes a 3D image
  bool attachment = false;                         // also colour and input attachment
  bool force_3d = false;                           // a 3D image even when depth is 1

  bool operator==(const ImageDesc&) const = default;
};

class Image {
 public:
  Image() = default;
  // Storage (where the format allows), sampled and transfer usage. Contents are undefined, layout GENERAL.
  Image(Device& device, std::string name, const ImageDesc& desc);
  Image(Image&& other) noexcept { swap(other); }
  Image& operator=(Image&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Image();

  explicit operator bool() const { return image_ != VK_NULL_HANDLE; }
  VkImage vk() const { return image_; }
  VkImageView view() const { return view_; }
  const ImageDesc& desc() const { return desc_; }
  const std::string& name() const { return name_; }
  std::uint64_t id() const { return id_; }
  VkExtent3D extent() const { return {desc_.width, desc_.height, desc_.depth}; }
  VkDeviceSize tight_bytes() const;  // bytes of all texels, tightly packed

  // Blocking transfers of the whole image, tightly packed, x fastest. For set-up, tools and tests.
  void write(std::span<const std::byte> texels);
  void read(std::span<std::byte> texels) const;

 private:
  void swap(Image& other) noexcept;
  Device* device_ = nullptr;
  std::uint64_t id_ = 0;
  std::string name_;
  ImageDesc desc_;
  VkImage image_ = VK_NULL_HANDLE;
  VkImageView view_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize allocated_ = 0;
};

std::uint32_t format_bytes(VkFormat format);

}  // namespace nephele
